#include "drivers/zebro/leg_bus.h"

#include <algorithm>

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr std::int64_t kResendDelta_ms = 100;  // shortest time of a repeated rotate

Code code_of(Kind kind) {
  switch (kind) {
    case Kind::motion_on: return Code::start_motion_control;
    case Kind::motion_off: return Code::stop_motion_control;
    case Kind::rotate_forward: return Code::rotate_forward;
    case Kind::rotate_backward: return Code::rotate_backward;
    case Kind::reset: return Code::reset;
    case Kind::emergency_stop:
    case Kind::none: break;  // none is never due
  }
  return Code::emergency_stop;
}

}  // namespace

bool stops_all(const BusOrders& orders) noexcept {
  return std::ranges::none_of(orders.module, [](const ModuleOrder& order) {
    return order.rotates() || order.kind == Kind::motion_on;
  });
}

LegBus::LegBus(const LegBusParameters& parameters) noexcept
    : parameters_(parameters),
      frame_ns_(frame_time_ns(parameters.baud, parameters.stop)),
      receiver_(parameters.check, parameters.stop) {
  if (!parameters.half_duplex) {  // nothing waits for the reply: a late one is valid
    parameters_.reply_timeout_ns =
        std::max(parameters.reply_timeout_ns, parameters.period_ns * 3 / 4);
  }
  stop_all(0, true);
}

void LegBus::restart(TimeNs now) noexcept {
  receiver_.clear();
  asked_count_ = 0;
  reply_count_ = 0;
  status_left_ = status_open_ = 0;
  wire_free_ns_ = now;
  next_cycle_ns_ = now;
  for (Module& module : module_) {
    module.answers = false;
    module.identity_cycle = 0;
  }
  stop_all(now, true);
}

void LegBus::release(const BusOrders& orders, TimeNs now) noexcept {
  released_ = true;
  issued_ns_ = orders.issued_ns;
  const bool fresh = now - issued_ns_ <= parameters_.stale_after_ns;
  if (fresh) stale_ = false;
  if (orders.emergency_serial != emergency_serial_) {
    emergency_serial_ = orders.emergency_serial;
    // A stop that is being sent is not restarted: it would reach the last modules later.
    const auto stops = [](const Module& m) { return m.order.kind == Kind::emergency_stop; };
    const auto unsent = [](const Module& m) { return !m.sent; };
    const bool under_way =
        std::ranges::all_of(module_, stops) && std::ranges::any_of(module_, unsent);
    if (!under_way) stop_all(now, true);
  }
  for (std::size_t i = 0; i < module_.size(); ++i) {
    accept(module_[i], counters_.module[i], orders.module[i], fresh, now);
  }
  begin_cycle(now);
}

void LegBus::accept(Module& module, ModuleLink& link, const ModuleOrder& order, bool fresh,
                    TimeNs now) noexcept {
  if (order.serial == module.serial) return;
  module.serial = order.serial;
  if (order.kind == Kind::none) return;
  if (!fresh && order.kind != Kind::emergency_stop) return;
  const bool stopping = module.order.kind == Kind::emergency_stop && module.unconfirmed;
  if (stopping && order.kind == Kind::emergency_stop) return;  // it is being sent
  module.order = order;
  module.due_ns = now;
  module.unconfirmed = true;
  module.sent = false;
  module.contradictions = module.silences = 0;
  link.disobeys = false;
}

void LegBus::stop_all(TimeNs now, bool again) noexcept {
  broadcast_due_ = true;
  for (std::size_t i = 0; i < module_.size(); ++i) {
    Module& module = module_[i];
    if (again || module.order.kind != Kind::emergency_stop) {
      module.contradictions = module.silences = 0;
      counters_.module[i].disobeys = false;
    }
    module.order = {};
    module.order.kind = Kind::emergency_stop;
    module.due_ns = now;
    module.unconfirmed = true;
    module.sent = false;
  }
}

void LegBus::stop_if_stale(TimeNs now) noexcept {
  if (!released_ || now - issued_ns_ <= parameters_.stale_after_ns) return;
  if (stale_ && now - safe_sent_ns_ < kRepeat_ns) return;
  stop_all(now, !stale_);
  stale_ = true;
  safe_sent_ns_ = now;
  ++counters_.safe_commands;
}

void LegBus::begin_cycle(TimeNs now) noexcept {
  ++counters_.cycles;
  cycle_start_ns_ = now;
  next_cycle_ns_ = now + 2 * parameters_.period_ns;
  cycle_full_ = false;
  if (status_left_ == 0) status_next_ = 0;
  status_left_ = status_open_ = kBusModules;
  page_first_ = health_left_;
  health_left_ = identity_left_ = true;
}

// One frame ahead of the wire; on one pair none while a reply may come.
TimeNs LegBus::may_write_ns() const noexcept {
  if (parameters_.half_duplex && asked_count_ > 0) return kNever;
  return wire_free_ns_ - frame_ns_;
}

// Emergency stops first. -1: none.
int LegBus::due_command(TimeNs now) const noexcept {
  int found = -1;
  for (int i = 0; i < kBusModules; ++i) {
    const Module& module = module_[static_cast<std::size_t>(i)];
    if (module.due_ns > now) continue;
    if (module.order.kind == Kind::emergency_stop) return i;
    if (found < 0) found = i;
  }
  return found;
}

bool LegBus::next_poll(Poll& poll) const noexcept {
  if (cycle_full_ || asked_count_ == kMaxAsked) return false;
  if (page_first_ && next_page(poll)) return true;
  if (status_left_ == 0) return next_page(poll);
  poll = {static_cast<std::uint8_t>(status_next_), Page::status, false};
  return true;
}

// Pages that an order waits for, then health and identity in turn.
bool LegBus::next_page(Poll& poll) const noexcept {
  const auto take = [&poll](std::size_t module, Page page, bool verifies) {
    poll = {static_cast<std::uint8_t>(module), page, verifies};
    return true;
  };
  for (std::size_t i = 0; i < module_.size(); ++i) {
    const Module& m = module_[i];
    if (!m.unconfirmed || m.due_ns != kNever || !m.answers) continue;
    if (m.verified_cycle == counters_.cycles) continue;
    if (m.order.rotates()) return take(i, Page::health, true);
    if (m.order.kind == Kind::reset) return take(i, Page::identity, true);
  }
  for (std::size_t n = 0; n < module_.size() && health_left_; ++n) {
    const std::size_t i = (health_turn_ + n) % module_.size();
    if (module_[i].answers) return take(i, Page::health, false);
  }
  for (std::size_t n = 0; n < module_.size() && identity_left_; ++n) {
    const std::size_t i = (identity_turn_ + n) % module_.size();
    if (module_[i].answers && module_[i].identity_cycle <= counters_.cycles)
      return take(i, Page::identity, false);
  }
  return false;
}

// Full duplex: the reply may come while the next cycle's first request goes out.
bool LegBus::fits(TimeNs start_ns) const noexcept {
  const TimeNs turn_around_ns =
      2 * frame_ns_ / static_cast<TimeNs>(frame_characters(parameters_.stop));
  const TimeNs cost_ns = parameters_.half_duplex ? 2 * frame_ns_ + turn_around_ns : frame_ns_;
  return start_ns + cost_ns <= cycle_start_ns_ + parameters_.period_ns;
}

std::span<const std::uint8_t> LegBus::transmit(TimeNs now) noexcept {
  expire(now);
  stop_if_stale(now);
  if (now >= next_cycle_ns_) begin_cycle(now);
  if (now < may_write_ns()) return {};

  const TimeNs start_ns = std::max(now, wire_free_ns_);
  if (broadcast_due_) {
    broadcast_due_ = false;
    return write(command(kBroadcast, Code::emergency_stop), now);
  }
  if (const int due = due_command(now); due >= 0) {
    const auto i = static_cast<std::size_t>(due);
    return write(command_frame(module_[i], parameters_.address[i], start_ns + frame_ns_), now);
  }
  Poll poll;
  if (!next_poll(poll)) return {};
  if (!fits(start_ns)) {
    cycle_full_ = true;
    return {};
  }
  const auto frame = write(request(parameters_.address[poll.module], poll.page), now);
  ask(poll);
  return frame;
}

Frame LegBus::command_frame(Module& module, std::uint8_t address, TimeNs end_ns) noexcept {
  module.due_ns = kNever;
  module.sent = true;
  module.sent_ns = end_ns;
  ++module.commands;
  const Code code = code_of(module.order.kind);
  if (!module.order.rotates()) return command(address, code);

  const bool repeated = module.contradictions > 0;
  const std::int64_t left_ms = (module.order.arrive_ns - end_ns) / kMillisecond;
  const auto delta_ms =
      std::clamp<std::int64_t>(left_ms, repeated ? kResendDelta_ms : 1, UINT16_MAX);
  module.told_arrival_ns = end_ns + delta_ms * kMillisecond;
  return rotate(address, code, module.order.position_cdeg, static_cast<std::uint16_t>(delta_ms));
}

std::span<const std::uint8_t> LegBus::write(const Frame& frame, TimeNs now) noexcept {
  wire_free_ns_ = std::max(now, wire_free_ns_) + frame_ns_;
  ++counters_.frames_sent;
  return encode(frame, parameters_.check, parameters_.stop, tx_);
}

void LegBus::ask(const Poll& poll) noexcept {
  Module& module = module_[poll.module];
  if (poll.page == Page::status) {
    --status_left_;
    status_next_ = (status_next_ + 1) % kBusModules;
  } else {
    page_first_ = false;
    if (poll.verifies) {
      module.verified_cycle = counters_.cycles;
    } else if (poll.page == Page::health) {
      health_left_ = false;
      health_turn_ = poll.module + 1u;
    } else {
      identity_left_ = false;
      identity_turn_ = poll.module + 1u;
    }
  }
  ++counters_.module[poll.module].requests;
  asked_[(first_asked_ + asked_count_) % kMaxAsked] = {
      poll.module, poll.page, module.commands, counters_.cycles,
      wire_free_ns_ + parameters_.reply_timeout_ns};
  ++asked_count_;
}

TimeNs LegBus::next_wake() const noexcept {
  TimeNs wake = next_cycle_ns_;
  if (asked_count_ > 0) wake = std::min(wake, asked(0).deadline_ns);
  if (released_) {
    wake = std::min(
        wake, stale_ ? safe_sent_ns_ + kRepeat_ns : issued_ns_ + parameters_.stale_after_ns + 1);
  }
  const TimeNs may_write = may_write_ns();
  Poll poll;
  if (broadcast_due_ || next_poll(poll)) wake = std::min(wake, may_write);
  for (const Module& module : module_) {
    if (module.due_ns != kNever) wake = std::min(wake, std::max(module.due_ns, may_write));
  }
  return wake;
}

}  // namespace lss::zebro
