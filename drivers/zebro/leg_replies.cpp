// Replies: which one answers which request, and whether the module follows its orders.

#include <algorithm>
#include <cstdlib>

#include "drivers/zebro/leg_bus.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr TimeNs kResetTime_ns = kSecond;  // by then a reset must show
constexpr std::uint64_t kIdentityCycles = 64;
constexpr TimeNs kUptimeTolerance_ns = 50 * kMillisecond;  // rounding, and a clock that is 1 % fast
constexpr TimeNs kArrivalTolerance_ns = 250 * kMillisecond;

TimeNs ns(double seconds) { return static_cast<TimeNs>(seconds * static_cast<double>(kSecond)); }

}  // namespace

void LegBus::receive(std::span<const std::uint8_t> bytes, TimeNs now) noexcept {
  while (!bytes.empty()) {
    const auto piece =
        bytes.first(std::min(bytes.size(), Receiver::kCapacity * frame_characters(Stop::lf)));
    bytes = bytes.subspan(piece.size());
    receiver_.receive(piece, now);
    while (const auto received = receiver_.take()) heard(*received, now);
  }
  const ReceiverCounters& r = receiver_.counters();
  counters_.bad_start = r.bad_start;
  counters_.bad_length = r.bad_length;
  counters_.bad_character = r.bad_character;
  counters_.bad_check = r.bad_check;
  counters_.frames_dropped = r.bad_start + r.bad_length + r.bad_character + r.bad_check +
                             counters_.unexpected + counters_.overflows;
}

void LegBus::heard(const Received& received, TimeNs now) noexcept {
  std::size_t n = 0;
  while (n < asked_count_ &&
         (parameters_.address[asked(n).module] != received.frame.address ||
          static_cast<std::uint8_t>(reply_code(asked(n).page)) != received.frame.code)) {
    ++n;
  }
  if (n == asked_count_) {
    ++counters_.unexpected;
    return;
  }
  // Replies come in the order of the requests: earlier ones will not come any more.
  for (; n > 0; --n) {
    missed(asked(0), now);
    forget_first();
  }
  const Asked request = asked(0);
  forget_first();

  Module& module = module_[request.module];
  ModuleLink& link = counters_.module[request.module];
  ++link.replies;
  ++counters_.frames_received;
  const ModuleReply reply{received.time_ns, request.module, received.frame.code,
                          received.frame.data};
  keep(reply);
  if (request.page == Page::status) {
    const std::uint16_t flags = decode_status(reply.data).flags;
    module.answers = true;
    module.motor_on = (flags & kFlagMotionControl) != 0;
    if ((flags & kFlagReset) != 0) module.identity_cycle = 0;
    status_over(request, now);
  } else if (request.page == Page::identity) {
    module.identity_cycle = counters_.cycles + kIdentityCycles;
  }
  if (request.commands != module.commands || !module.sent) return;
  if (lost(module, link, reply)) module.unconfirmed = true;
  if (module.unconfirmed) verify(module, link, reply, now);
}

// A confirmed movement that the module does not have any more: noise made another order of a frame,
// with a check that fits. Its pages of health, which come in turn, show it.
bool LegBus::lost(const Module& module, const ModuleLink& link, const ModuleReply& reply) noexcept {
  return !module.unconfirmed && !link.disobeys && module.motor_on && module.order.rotates() &&
         reply.code == static_cast<std::uint8_t>(Code::health) &&
         position_cdeg(decode_health(reply.data).set_point_rad) != module.order.position_cdeg;
}

void LegBus::verify(Module& module, ModuleLink& link, const ModuleReply& reply,
                    TimeNs now) noexcept {
  const Kind kind = module.order.kind;
  bool executed = false;
  if (reply.code == static_cast<std::uint8_t>(Code::status)) {
    const std::uint16_t flags = decode_status(reply.data).flags;
    if (module.order.rotates()) return;
    if (kind == Kind::reset) {
      if ((flags & kFlagReset) == 0) return;  // the uptime shows it
      executed = true;
    } else {
      executed = ((flags & kFlagMotionControl) != 0) == (kind == Kind::motion_on);
    }
  } else if (reply.code == static_cast<std::uint8_t>(Code::health)) {
    if (!module.order.rotates()) return;
    const Health health = decode_health(reply.data);
    const TimeNs expected_ns = std::max<TimeNs>(0, module.told_arrival_ns - reply.time_ns);
    executed = position_cdeg(health.set_point_rad) == module.order.position_cdeg &&
               std::abs(ns(health.time_left_s) - expected_ns) <= kArrivalTolerance_ns;
  } else {
    if (kind != Kind::reset) return;
    const TimeNs since_ns = reply.time_ns - module.sent_ns;
    executed = ns(decode_identity(reply.data).uptime_s) <= since_ns + kUptimeTolerance_ns;
    if (!executed && since_ns < kResetTime_ns) return;
  }

  if (!executed) return again(module, link, true, now);
  if (kind == Kind::reset) ++link.resets;
  module.unconfirmed = false;
  module.due_ns = kNever;
}

// The order was contradicted by the module's own report, or (stops only) the module is silent.
void LegBus::again(Module& module, ModuleLink& link, bool contradicted, TimeNs now) noexcept {
  if (module.due_ns != kNever) return;
  const bool stop = module.order.kind == Kind::emergency_stop;
  int& times = contradicted ? module.contradictions : module.silences;
  times = std::min(times + 1, parameters_.resend_limit + 1);
  const bool used_up = times > parameters_.resend_limit;
  if (used_up && contradicted) link.disobeys = true;
  if (used_up && !stop) {
    module.unconfirmed = false;
    return;
  }
  module.due_ns = used_up ? module.sent_ns + kRepeat_ns : now;
  ++link.resends;
}

void LegBus::expire(TimeNs now) noexcept {
  while (asked_count_ > 0 && asked(0).deadline_ns <= now) {
    missed(asked(0), now);
    forget_first();
  }
}

void LegBus::missed(const Asked& request, TimeNs now) noexcept {
  Module& module = module_[request.module];
  if (request.page != Page::status) return;
  module.answers = false;
  status_over(request, now);
  if (module.unconfirmed && module.order.kind == Kind::emergency_stop &&
      request.commands == module.commands) {
    again(module, counters_.module[request.module], false, now);
  }
}

void LegBus::status_over(const Asked& request, TimeNs now) noexcept {
  if (request.cycle != counters_.cycles || --status_open_ > 0) return;
  counters_.cycle_ns = now - cycle_start_ns_;
}

void LegBus::forget_first() noexcept {
  first_asked_ = (first_asked_ + 1) % kMaxAsked;
  --asked_count_;
}

void LegBus::keep(const ModuleReply& reply) noexcept {
  if (reply_count_ == kMaxReplies) {
    ++counters_.overflows;
    first_reply_ = (first_reply_ + 1) % kMaxReplies;
    --reply_count_;
  }
  reply_[(first_reply_ + reply_count_) % kMaxReplies] = reply;
  ++reply_count_;
}

std::size_t LegBus::take(std::span<ModuleReply> out) noexcept {
  const std::size_t n = std::min(out.size(), reply_count_);
  for (std::size_t i = 0; i < n; ++i) out[i] = reply_[(first_reply_ + i) % kMaxReplies];
  first_reply_ = (first_reply_ + n) % kMaxReplies;
  reply_count_ -= n;
  return n;
}

}  // namespace lss::zebro
