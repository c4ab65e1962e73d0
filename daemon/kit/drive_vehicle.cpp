#include "daemon/kit/drive_vehicle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "daemon/config/reading.h"
#include "daemon/kit/gate.h"

namespace lss::kit {
namespace {

constexpr double kStands_rpm = 20;  // a motor that is not faster

}  // namespace

void read_drive_bus(config::Section s, DriveParameters& p) {
  std::vector<std::int64_t> fallback;
  for (const std::uint8_t node : p.bus.node) {
    if (node != 0) fallback.push_back(node);
  }
  const auto nodes = s.integers("nodes", fallback, fallback.size(), 1, 126);
  for (std::size_t i = 0; i < nodes.size() && i < fallback.size(); ++i)
    p.bus.node[i] = static_cast<std::uint8_t>(nodes[i]);
  p.bus.heartbeat.master =
      static_cast<std::uint8_t>(s.integer("master_node", p.bus.heartbeat.master, 1, 127));
  std::set<std::int64_t> all(nodes.begin(), nodes.end());
  all.insert(p.bus.heartbeat.master);
  if (all.size() != nodes.size() + 1)
    s.error("nodes", "a number is there twice: give each node and the master its own");
  p.bus.stale_after_ns = config::milliseconds(s, "stale_ms", p.bus.stale_after_ns, 50, 5000);
  p.bus.heartbeat.timeout_ns =
      config::milliseconds(s, "heartbeat_timeout_ms", p.bus.heartbeat.timeout_ns, 150, 5000);
  p.bus.acceleration_rpm_s = s.number("acceleration_rpm_s", p.bus.acceleration_rpm_s, 100, 100'000);
}

// ---- read

void DriveVehicle::begin(TimeNs now, const BusReport& bus) noexcept {
  now_ns_ = now;
  data_requested_ = false;
  bus_ = bus;
}

void DriveVehicle::take(const Sample& sample) noexcept {
  if (sample.drive >= drives_) return;
  motion_[sample.drive] = {sample.motor_rpm, sample.current_permille, sample.time_ns};
}

// ---- state

bool DriveVehicle::answers(std::size_t i) const noexcept {
  return bus_.open && bus_.status.link[i].node.state == canopen::NodeState::operational;
}

bool DriveVehicle::faulty(std::size_t i) const noexcept {
  const canopen::DriveState state = bus_.status.link[i].drive;
  return state == canopen::DriveState::fault || state == canopen::DriveState::fault_reaction;
}

std::uint16_t DriveVehicle::faulty_modules() const noexcept {
  unsigned mask = 0;
  for (std::size_t i = 0; i < drives_; ++i) {
    if (!answers(i) || faulty(i) || bus_.status.link[i].disobeys) mask |= 1u << i;
  }
  return static_cast<std::uint16_t>(mask);
}

bool DriveVehicle::enabled() const noexcept {
  for (std::size_t i = 0; i < drives_; ++i) {
    if (!answers(i) || bus_.status.link[i].drive != canopen::DriveState::operation_enabled)
      return false;
  }
  return true;
}

bool DriveVehicle::powered() const noexcept {
  for (std::size_t i = 0; i < drives_; ++i) {
    if (answers(i) && canopen::powered(bus_.status.link[i].drive)) return true;
  }
  return false;
}

bool DriveVehicle::standing(double motor_rpm) const noexcept {
  return std::ranges::all_of(std::span(motion_).first(drives_),
                             [&](const Motion& m) { return std::abs(m.motor_rpm) <= motor_rpm; });
}

std::uint64_t DriveVehicle::age_ms(const canopen::NodeStatus& node) const noexcept {
  if (node.heartbeat_ns == 0) return kNeverHeard_ms;
  return static_cast<std::uint64_t>(std::max<TimeNs>(now_ns_ - node.heartbeat_ns, 0) /
                                    kMillisecond);
}

// ---- watch

void DriveVehicle::supervise(bool overrun_limit, Supervisor& s) noexcept {
  supervisor_ = &s;
  const bool operational = s.controller().state == State::operational;
  if (overrun_limit && operational) s.raise(FaultId::frame_overrun);
  s.check_stop(bus_.time_ns != 0 && bus_.all_stop_pending);
  port_.watch(bus_, bus_.status.counters.safe_commands, bus_.port.bus_offs, now_ns_, s);
  port_.watch_masters(bus_.status.counters.master.other_masters, now_ns_, s);
  const auto link = [this](std::size_t i) -> const canopen::DriveLink& {
    return bus_.status.link[i];
  };
  nodes_.watch_resets(
      now_ns_, drive_.reset_ns, bus_.open, link, [this](std::size_t i) { return answers(i); }, s);
  set_ages(drives_, now_ns_, drive_.bus.heartbeat.timeout_ns, link, s);
  for (std::size_t i = 0; i < drives_; ++i) {
    nodes_.watch(i, link(i).node, {.answers = answers(i)}, bus_.open, s);
    nodes_.watch_drive(i, link(i), answers(i), true, s);
    nodes_.watch_dropouts(i, link(i), now_ns_, true, s);
    // The node answers but its values are missing.
    const bool old = now_ns_ - motion_[i].time_ns > drive_.bus.stale_after_ns;
    const TimeNs since_ns = now_ns_ - link(i).node.since_ns;
    if (s.controller().state == State::operational && answers(i) && old &&
        since_ns > drive_.bus.stale_after_ns)
      s.raise(FaultId::stale_input, module_of(i));
  }
  watch_solver(s);
}

void DriveVehicle::watch_solver(Supervisor& s) noexcept {
  if (s.controller().state != State::solve_errors) return;
  const bool healthy = port_.open() && !PortWatch::stands_still(bus_, now_ns_) &&
                       faulty_modules() == 0 && s.controller().unheard == 0 &&
                       s.controller().silent == 0;
  const auto begin = [this] {
    solver_.begin(
        {DriveStrategy::reconnect, DriveStrategy::reset_fault, DriveStrategy::reset_node});
  };
  const auto treat = [this] {
    if (solver_.kind() == DriveStrategy::reset_fault) ++orders_.fault_reset_serial;
    if (solver_.kind() == DriveStrategy::reset_node) reset_nodes(faulty_modules());
    return Treatment::done;
  };
  const auto step = [&] {
    return solver_.step(
        now_ns_, healthy, [this] { return drive_.budget_ns; }, treat);
  };
  solve_errors(s, solver_, begin, step);
}

// ---- act: actions of the locomotion controller, at once

void DriveVehicle::act(lc::ActionSet actions, const Request* request) noexcept {
  if (actions & lc::kEmergencyStop) {
    on_ = false;
    make_safe(now_ns_);
  } else if (actions & lc::kMotorsOff) {
    on_ = false;
    ++orders_.serial;  // ends a stop that the bus maintains
    // Only error solving ends it before the vehicle stands.
    const bool solves = (actions & (lc::kNextStrategy | lc::kEndSolve | lc::kIsolate)) != 0;
    orders_.quick_stop = orders_.quick_stop && !solves && !standing(kStands_rpm);
  }
  if (actions & lc::kEndSolve) solver_.end();
  if (actions & lc::kResetModule) {
    const int number = arguments<Reset>(*request).module;
    const unsigned all = (1u << drives_) - 1;
    const unsigned nodes = number == 0 ? all : 1u << (number - 1);
    reset_nodes(static_cast<std::uint16_t>(nodes));
    for (std::size_t i = 0; i < drives_; ++i) {
      if (nodes >> i & 1u) nodes_.begin_reset(i, now_ns_, bus_.status.link[i].node);
    }
  }
  if (actions & lc::kPublishData) data_requested_ = true;
}

void DriveVehicle::motors_on() noexcept {
  on_ = true;
  orders_.quick_stop = false;
  ++orders_.fault_reset_serial;  // of faults while standing
  ++orders_.serial;
}

void DriveVehicle::reset_nodes(std::uint16_t nodes) noexcept {
  const bool sent = orders_.node_reset_serial == sent_.node_reset_serial;
  orders_.reset_nodes = static_cast<std::uint16_t>(sent ? nodes : orders_.reset_nodes | nodes);
  ++orders_.node_reset_serial;
}

DriveVehicle::Command DriveVehicle::order(std::span<const double> motor_rpm, TimeNs now) noexcept {
  for (std::size_t i = 0; i < drives_; ++i)
    orders_.drive[i] = {.enabled = on_, .motor_rpm = on_ ? motor_rpm[i] : 0};
  orders_.standing = supervisor_->controller().state != State::operational;
  orders_.next_frame_ns = now + drive_.bus.period_ns;
  orders_.issued_ns = now;
  return orders_;
}

// ---- gate

DriveGate DriveVehicle::check(const Command& orders, TimeNs now) const noexcept {
  if (orders.issued_ns != now) return DriveGate::fresh;
  const bool may = supervisor_->controller().state == State::operational && !orders.quick_stop;
  const double step = drive_.slew_rpm_s * static_cast<double>(drive_.bus.period_ns) * 1e-9;
  for (std::size_t i = 0; i < orders.drive.size(); ++i) {
    const canopen::VelocityOrder &is = orders.drive[i], &was = sent_.drive[i];
    if (is.enabled && (!may || i >= drives_)) return DriveGate::state;
    if (!std::isfinite(is.motor_rpm)) return DriveGate::finite;
    if (std::abs(is.motor_rpm) > drive_.max_motor_rpm * 1.001) return DriveGate::range;
    const double faster = is.motor_rpm * was.motor_rpm < 0
                              ? std::abs(is.motor_rpm)
                              : std::abs(is.motor_rpm) - std::abs(was.motor_rpm);
    if (faster > step * 1.001) return DriveGate::slew;
  }
  return DriveGate::passed;
}

void DriveVehicle::make_safe(TimeNs now) noexcept {
  orders_.issued_ns = now;
  ++orders_.serial;
  ++orders_.emergency_serial;
  orders_.quick_stop = true;
  orders_.drive.fill({});
}

DriveVehicle::Command DriveVehicle::gate(const Command& wanted, Supervisor& supervisor,
                                         TimeNs now) noexcept {
  return pass_gate(check(wanted, now), wanted, orders_, sent_, supervisor, [&] { make_safe(now); });
}

}  // namespace lss::kit
