#include "drivers/canopen/drive_bus.h"

#include <cmath>

namespace lss::canopen {
namespace {

// Serials count up and wrap.
bool after(std::uint32_t serial, std::uint32_t other) {
  return static_cast<std::int32_t>(serial - other) > 0;
}

}  // namespace

void DriveBus::restart(TimeNs now) noexcept {
  master_.restart(now, now + times_.stand_still_ns);
  forget_samples();
  for (Drive& drive : drive_) {
    drive.state = DriveState::unknown;
    drive.reset_step = 0;
  }
  all_stop(now);
}

void DriveBus::all_stop(TimeNs now) noexcept {
  stopping_ = true;
  ended_serial_ = orders_.serial;
  send_all(now);
}

void DriveBus::release_orders(const BusOrders& orders, TimeNs now) noexcept {
  ++counters_.releases;
  const bool emergency = orders.emergency_serial != emergency_serial_;
  emergency_serial_ = orders.emergency_serial;
  released_ = true;
  orders_ = orders;
  if (now - orders.issued_ns > times_.stale_after_ns) {
    ++counters_.stale_orders;
    return stop_stale(now);
  }
  stale_ = false;
  if (orders.fault_reset_serial != fault_reset_serial_) {
    fault_reset_serial_ = orders.fault_reset_serial;
    for (Drive& drive : drive_) drive.reset_step = drive.state == DriveState::fault ? 1 : 0;
  }
  if (orders.node_reset_serial != node_reset_serial_) {
    node_reset_serial_ = orders.node_reset_serial;
    for (std::size_t i = 0; i < master_.nodes(); ++i) {
      if ((orders.reset_nodes >> i & 1) != 0) master_.reset(i, now);
    }
  }
  master_.allow_boot(orders.standing);
  if (orders.next_frame_ns != 0) master_.sync_at(orders.next_frame_ns - times_.sync_lead_ns);
  if (emergency) return all_stop(now);
  if (stopping_ && after(orders.serial, ended_serial_)) stopping_ = false;
  if (stopping_) ++counters_.old_orders;
  send_all(now);
}

// Orders are missing or too old.
void DriveBus::stop_stale(TimeNs now) noexcept {
  if (!stale_) ++counters_.safe_commands;
  stale_ = true;
  master_.allow_boot(false);
  all_stop(now);
}

bool DriveBus::operational(std::size_t node) const noexcept {
  return master_.nodes() > node && master_.status(node).state == NodeState::operational;
}

// Sends all orders, or the stop.
void DriveBus::send_all(TimeNs now) noexcept {
  stop_again_ns_ = now + times_.period_ns;
  for (std::size_t drive = 0; drive < drives_; ++drive) {
    watch(drive, now);
    send_drive(drive, now);
  }
  if (released_ && !stale_) send_others();
}

// A drive whose heartbeat is lost may still receive: it gets a stop.
void DriveBus::send_drive(std::size_t i, TimeNs now) noexcept {
  const bool enabled = ordered(i);
  if (!operational(i)) drive_[i].state = DriveState::unknown;
  if (moves() && operational(i)) return send_order(i, enabled, now);
  send_stop(i, drive_[i].reset_step > 0 ? controlword(i, false) : kQuickStop);
}

std::uint16_t DriveBus::controlword(std::size_t i, bool enabled) noexcept {
  Drive& drive = drive_[i];
  if (drive.reset_step > 0) {
    drive.reset_step = drive.reset_step == 1 ? 2 : 0;
    return drive.reset_step == 2 ? kDisableVoltage : kFaultReset;
  }
  if (enabled) return towards_enabled(drive.state);
  const bool stays = drive.state == DriveState::quick_stop_active ||
                     drive.state == DriveState::fault || drive.state == DriveState::unknown;
  return stays ? kDisableVoltage : kShutdown;
}

// Whether the orders enable this drive. An order that is not a number does not.
bool DriveBus::ordered(std::size_t i) noexcept {
  const Order wanted = order(i);
  if (!wanted.enabled || std::isfinite(wanted.value)) return wanted.enabled;
  ++counters_.bad_orders;
  return false;
}

void DriveBus::watch(std::size_t i, TimeNs now) noexcept {
  Drive& drive = drive_[i];
  const bool runs = drive.state == DriveState::operation_enabled;
  if (!operational(i) || runs == (order(i).enabled && moves())) drive.obeyed_ns = now;
  drive.disobeys = now - drive.obeyed_ns > times_.disobeys_after_ns;
}

void DriveBus::heard(std::size_t i, std::uint16_t statusword) noexcept {
  Drive& drive = drive_[i];
  const DriveState before = drive.state;
  drive.statusword = statusword;
  drive.state = drive_state(statusword);
  const bool leaves = before == DriveState::operation_enabled && drive.state != before;
  if (leaves && moves() && order(i).enabled) ++drive.dropouts;
}

bool DriveBus::transmit(TimeNs now, CanFrame& frame) noexcept {
  if (released_ && !stale_ && now - orders_.issued_ns > times_.stale_after_ns) {
    stop_stale(now);
  } else if (stopping_ && now >= stop_again_ns_) {
    send_all(now);
  }
  send_due(now);
  return master_.transmit(now, frame);
}

TimeNs DriveBus::next_wake() const noexcept {
  TimeNs wake = std::min(master_.next_wake(), next_due());
  if (released_ && !stale_) wake = std::min(wake, orders_.issued_ns + times_.stale_after_ns + 1);
  return stopping_ ? std::min(wake, stop_again_ns_) : wake;
}

void DriveBus::describe(std::size_t node, DriveLink& link) const noexcept {
  link.node = master_.status(node);
  link.sdo_aborts = master_.sdo(node).aborts;
  link.sdo_repeats = master_.sdo(node).repeats;
  if (node >= drives_) return;
  link.drive = operational(node) ? drive_[node].state : DriveState::unknown;
  link.statusword = drive_[node].statusword;
  link.disobeys = drive_[node].disobeys;
  link.dropouts = drive_[node].dropouts;
}

void DriveBus::describe(DriveBusCounters& counters) const noexcept {
  counters = counters_;
  counters.master = master_.counters();
}

}  // namespace lss::canopen
