#include "drivers/talaris/hopper_bus.h"

#include <algorithm>
#include <memory>

#include "drivers/talaris/valves.h"

namespace lss::talaris {
namespace {

std::span<const std::uint8_t> data_of(const CanFrame& frame) {
  return std::span(frame.data).first(frame.size);
}

}  // namespace

HopperBus::HopperBus(const HopperBusParameters& parameters) noexcept
    : parameters_(parameters), master_(master_parameters(parameters)) {
  restart(0);
}

// Earlier orders are void: the next release counts.
void HopperBus::restart(TimeNs now) noexcept {
  master_.restart(now, now + parameters_.settle_ns);
  samples_.clear();
  has_half_ = false;
  released_ = stale_ = false;
  shut(now);
}

// In the air the nodes slow the fans down by themselves while nobody speaks to them, and those that
// fell back are booted without a reset: orders go on, or there would be no lift until the next
// release. Orders that are too old by now are found by transmit().
void HopperBus::reopened(TimeNs now) noexcept {
  if (safe() || orders_.boot_allowed) return restart(now);
  fans_ns_ = now;
}

void HopperBus::begin_again(const HopperBusParameters& parameters, const HopperStatus& said,
                            const TalarisOrders& last, TimeNs now) noexcept {
  std::construct_at(this, parameters);
  counters_ = said.counters;
  node_reset_serial_ = last.node_reset_serial;
  master_.restart(now, now + parameters_.settle_ns);
  master_.take_over(said.counters.master);
  for (std::size_t i = 0; i < master_.nodes(); ++i) master_.take_over(i, said.link[i].node, now);
  const bool in_the_air = last.issued_ns != 0 && !last.all_stop && !last.boot_allowed;
  in_the_air ? release(last, now) : restart(now);
}

// Sequence 0: shuts, regardless of the last sequence of the actuate thread.
void HopperBus::shut(TimeNs now) noexcept {
  shut_ns_ = now + parameters_.shut_period_ns;
  master_.send_rpdo(kValveNode, 1, data_of(valve_frame(parameters_.node[kValveNode], 0, 0)));
  send_fans(now);
}

void HopperBus::send_fans(TimeNs now) noexcept {
  fans_ns_ = now + parameters_.fan_period_ns;
  const TalarisOrders off;
  const CanFrame frame =
      fan_frame(parameters_.node[kFanNode], safe() ? off.fan_us : orders_.fan_us);
  master_.send_rpdo(kFanNode, 1, data_of(frame));
}

void HopperBus::release(const TalarisOrders& orders, TimeNs now) noexcept {
  ++counters_.releases;
  orders_ = orders;
  released_ = true;
  for (const std::uint16_t width : orders.fan_us) {
    if (width < kFanOff_us || width > kFanFull_us) ++counters_.bad_orders;
  }
  const bool was_stale = stale_;
  stale_ = now - orders.issued_ns > parameters_.stale_after_ns;
  if (stale_) {
    ++counters_.stale_orders;
    if (!was_stale) ++counters_.safe_commands;
    allow_boot(false, false);
    return shut(now);
  }
  if (orders.node_reset_serial != node_reset_serial_) {
    node_reset_serial_ = orders.node_reset_serial;
    for (std::size_t i = 0; i < master_.nodes(); ++i) {
      if ((orders.reset_nodes >> i & 1) != 0) master_.reset(i, now);
    }
  }
  allow_boot(orders.boot_allowed, !orders.all_stop);
  if (orders.all_stop) return shut(now);
  send_fans(now);
}

// A node that fell back has shut everything and kept its power: it is better booted, even in the
// air. A node that lost power must not be used again in flight.
void HopperBus::allow_boot(bool all, bool fallen_back) noexcept {
  master_.allow_boot(all);
  master_.allow_resume(fallen_back);
}

void HopperBus::receive(std::span<const CanFrame> frames) noexcept {
  canopen::PdoSample raw;
  for (const CanFrame& frame : frames) {
    master_.receive(frame);
    while (master_.take(raw)) heard(raw);
  }
}

// A node may send more than it is configured to, and less than counts as babbling: between the bus
// and the frame there is no room for that, and it would displace what others say. Twice as many may
// come, and a few in a batch.
bool HopperBus::too_many(const canopen::PdoSample& raw) noexcept {
  constexpr TimeNs kWindow = 100 * kMillisecond;
  Heard& heard = heard_[raw.node][raw.number - 1u];
  if (const TimeNs since_ns = raw.time_ns - heard.begun_ns; since_ns < 0 || since_ns >= kWindow)
    heard = {raw.time_ns, 0};
  const TimeNs timer_ns = event_timer(raw.node, raw.number);
  return timer_ns > 0 && ++heard.count > 4 + 2 * kWindow / timer_ns;
}

// Forces wait for the moments of the same instant.
void HopperBus::heard(const canopen::PdoSample& raw) noexcept {
  TalarisSample sample{raw.time_ns, {}};
  if (!decode(raw.node, raw.number, std::span(raw.data).first(raw.size), sample.reading)) return;
  if (too_many(raw)) {
    ++counters_.overflows;
    return;
  }
  const Load* load = std::get_if<Load>(&sample.reading);
  if (load == nullptr) return keep(sample);
  if (raw.number == 1) {
    if (has_half_) ++counters_.load_unpaired;
    half_ = sample;
    has_half_ = true;
    return;
  }
  const bool pairs = has_half_ && raw.time_ns - half_.time_ns < parameters_.load_pair_ns;
  if (!pairs) {
    counters_.load_unpaired += has_half_ ? 2 : 1;
    has_half_ = false;
    return;
  }
  has_half_ = false;
  std::get<Load>(half_.reading).moment_Nm = load->moment_Nm;
  keep(half_);
}

void HopperBus::keep(const TalarisSample& sample) noexcept {
  if (!samples_.put(sample)) ++counters_.overflows;
}

bool HopperBus::transmit(TimeNs now, CanFrame& frame) noexcept {
  if (released_ && !stale_ && now - orders_.issued_ns > parameters_.stale_after_ns) {
    // Orders are missing or too old.
    stale_ = true;
    ++counters_.safe_commands;
    allow_boot(false, false);
    shut(now);
  }
  if (safe() && now >= shut_ns_) shut(now);
  if (now >= fans_ns_) send_fans(now);
  return master_.transmit(now, frame);
}

TimeNs HopperBus::next_wake() const noexcept {
  TimeNs wake = std::min(master_.next_wake(), fans_ns_);
  if (safe()) wake = std::min(wake, shut_ns_);
  if (released_ && !stale_) {
    wake = std::min(wake, orders_.issued_ns + parameters_.stale_after_ns + 1);
  }
  return wake;
}

const HopperStatus& HopperBus::status() noexcept {
  for (std::size_t node = 0; node < master_.nodes(); ++node) {
    HopperLink& link = status_.link[node];
    link.node = master_.status(node);
    link.sdo_aborts = master_.sdo(node).aborts;
    link.sdo_repeats = master_.sdo(node).repeats;
  }
  counters_.master = master_.counters();
  status_.counters = counters_;
  return status_;
}

}  // namespace lss::talaris
