#include "drivers/talaris/valves.h"

#include <algorithm>

#include "drivers/canopen/canopen.h"

namespace lss::talaris {
namespace {

constexpr std::uint8_t kLastSequence = 255;

bool has(std::uint8_t bits, std::size_t valve) { return (bits >> valve & 1) != 0; }

}  // namespace

CanFrame valve_frame(std::uint8_t node, std::uint8_t bits, std::uint8_t sequence) noexcept {
  CanFrame frame;
  frame.id = canopen::kRpdo1 + node;
  frame.size = 2;
  frame.data[0] = bits;
  frame.data[1] = sequence;
  return frame;
}

CanFrame fan_frame(std::uint8_t node,
                   const std::array<std::uint16_t, kHopperFans>& fan_us) noexcept {
  CanFrame frame;
  frame.id = canopen::kRpdo1 + node;
  frame.size = 8;
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    const std::uint16_t width = std::clamp(fan_us[i], kFanOff_us, kFanFull_us);
    frame.data[2 * i] = static_cast<std::uint8_t>(width);
    frame.data[2 * i + 1] = static_cast<std::uint8_t>(width >> 8);
  }
  return frame;
}

ValveSequencer::ValveSequencer(const ValveParameters& parameters) noexcept
    : parameters_(parameters) {}

// Sends the present state at once.
void ValveSequencer::force(TimeNs now) noexcept {
  if (!forced_) forced_ns_ = now;
  forced_ = true;
  retry_ns_ = INT64_MIN;
  next_ns_ = now;
}

void ValveSequencer::reopened(TimeNs now) noexcept {
  ++counters_.restarts;
  orders_ = {};
  window_ = {};
  told_stale_ = true;
  force(now);
}

void ValveSequencer::begin_again(const ValveParameters& parameters, const ValveCounters& counters,
                                 std::uint8_t open, TimeNs now) noexcept {
  *this = ValveSequencer(parameters);
  counters_ = counters;
  sent_ = open;
  last_ns_ = checked_ns_ = now;
  begins_ = true;
  reopened(now);
}

void ValveSequencer::all_stop(TimeNs now) noexcept {
  ++counters_.all_stops;
  orders_ = {};
  window_ = {};
  told_stale_ = fans_due_ = true;
  force(now);
}

void ValveSequencer::release(const TalarisOrders& orders, TimeNs now) noexcept {
  orders_ = orders;
  told_stale_ = false;
  const TimeNs frame_end = orders.release_ns + parameters_.frame_ns;
  // Orders pulse again when repeated; they were not computed for a third frame.
  const bool worn = orders.release_ns - orders.boundary_ns >= 2 * parameters_.frame_ns;
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    const ValvePulse& pulse = orders.pulse[i];
    const TimeNs from = orders.release_ns + std::max<TimeNs>(pulse.delay_ns, 0);
    TimeNs to = from + std::max<TimeNs>(pulse.on_ns, 0);
    if (pulse.on_ns > 0 && to >= frame_end) to = frame_end + parameters_.carry_ns;
    window_[i] = worn ? Window{} : Window{from, to};
  }
  force(now);
}

bool ValveSequencer::stale(TimeNs time) const noexcept {
  return time - orders_.issued_ns > parameters_.stale_after_ns;
}

std::uint8_t ValveSequencer::bits_at(TimeNs time) const noexcept {
  if (orders_.issued_ns == 0 || orders_.all_stop || stale(time)) return 0;
  std::uint8_t bits = 0;
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (!has(orders_.enabled, i)) continue;
    const bool held = orders_.hold[i].open && time < orders_.hold[i].until_ns;
    const bool pulsed = time >= window_[i].from_ns && time < window_[i].to_ns;
    if (held || pulsed) bits = static_cast<std::uint8_t>(bits | 1u << i);
  }
  return bits;
}

// The next time after `time` at which bits_at() may change; kNever: none.
TimeNs ValveSequencer::edge_after(TimeNs time) const noexcept {
  TimeNs edge = kNever;
  const auto consider = [&edge, time](TimeNs at) {
    if (at > time) edge = std::min(edge, at);
  };
  if (orders_.issued_ns == 0 || orders_.all_stop || stale(time)) return kNever;
  consider(orders_.issued_ns + parameters_.stale_after_ns + 1);
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (!has(orders_.enabled, i)) continue;
    if (window_[i].to_ns > window_[i].from_ns) {
      consider(window_[i].from_ns);
      consider(window_[i].to_ns);
    }
    if (orders_.hold[i].open) consider(orders_.hold[i].until_ns);
  }
  return edge;
}

void ValveSequencer::plan() noexcept {
  if (forced_ || fans_due_) {
    next_ns_ = std::max(retry_ns_, forced_ns_);
    return;
  }
  next_ns_ = edge_after(checked_ns_);
  if (sent_ != 0) next_ns_ = std::min(next_ns_, last_ns_ + parameters_.renew_ns);
  next_ns_ = std::max(next_ns_, retry_ns_);
}

std::uint8_t ValveSequencer::next_sequence() const noexcept {
  if (begins_) return 0;
  return static_cast<std::uint8_t>(sequence_ == kLastSequence ? 1 : sequence_ + 1);
}

bool ValveSequencer::due(TimeNs now, CanFrame& frame) noexcept {
  if (now < retry_ns_) return false;
  if (!told_stale_ && orders_.issued_ns != 0 && stale(now)) {
    told_stale_ = true;
    ++counters_.stale;
  }
  // With sequence 0 the node shuts all valves: those that are to be open follow at once.
  const std::uint8_t bits = begins_ ? std::uint8_t{0} : bits_at(now);
  // Valves first: the fans' message can wait the time of one frame.
  if (forced_ || bits != sent_ || (bits != 0 && now - last_ns_ >= parameters_.renew_ns)) {
    pending_ = bits;
    fans_pending_ = false;
    frame = valve_frame(parameters_.node, bits, next_sequence());
    frame.time_ns = now;
    return true;
  }
  if (fans_due_) {
    fans_pending_ = true;
    frame = fan_frame(parameters_.fan_node, TalarisOrders{}.fan_us);
    frame.time_ns = now;
    return true;
  }
  checked_ns_ = std::max(checked_ns_, now);
  plan();
  return false;
}

void ValveSequencer::sent(bool ok, TimeNs now) noexcept {
  if (!ok) {
    ++counters_.failed;
    retry_ns_ = now + parameters_.retry_ns;
    next_ns_ = retry_ns_;
    return;
  }
  retry_ns_ = INT64_MIN;
  ++counters_.frames;
  if (fans_pending_) {
    fans_due_ = false;
    return;
  }
  count(pending_, now);
  sequence_ = next_sequence();
  begins_ = false;
  sent_ = pending_;
  forced_ = false;
  last_ns_ = checked_ns_ = now;
}

// The sent state becomes the present one.
void ValveSequencer::count(std::uint8_t bits, TimeNs now) noexcept {
  const auto changed = static_cast<std::uint8_t>(bits ^ sent_);
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (has(sent_, i)) counters_.open_ns[i] += now - last_ns_;
    if (!has(changed, i)) continue;
    ++counters_.edges;
    if (has(bits, i)) ++counters_.pulses[i];
  }
  if (changed == 0) return;
  // The first edge of this frame.
  TimeNs due_ns = edge_after(checked_ns_);
  if (forced_) due_ns = std::min(due_ns, forced_ns_);
  if (due_ns < now) counters_.worst_late_ns = std::max(counters_.worst_late_ns, now - due_ns);
}

}  // namespace lss::talaris
