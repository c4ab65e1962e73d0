#include "daemon/vehicles/talaris/script.h"

#include <algorithm>
#include <cmath>

#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

std::int32_t milliseconds(double s) noexcept {
  return static_cast<std::int32_t>(std::lround(s * 1e3));
}
double seconds(std::int32_t ms) noexcept { return ms * 1e-3; }

// Of a script-step command.
ScriptStep read(const ScriptStepArguments& wanted) noexcept {
  ScriptStep step{.at_ms = milliseconds(wanted.at_s),
                  .kind = wanted.kind,
                  .which = wanted.which,
                  .value = wanted.value};
  if (step.kind == StepKind::pulse) step.on_ms = milliseconds(wanted.value);
  return step;
}

}  // namespace

Verdict Script::consider_step(const Request& r) const noexcept {
  const auto wanted = arguments<ScriptStepArguments>(r);
  const auto number = static_cast<std::uint16_t>(wanted.index + 1);
  const auto refuse = [&](Reason reason, double measured, double limit) {
    return Verdict{.reason = reason, .measured = measured, .limit = limit, .subject = number};
  };
  if (wanted.id != id_) return refuse(Reason::script_other, wanted.id, id_);
  if (wanted.index != count_) return refuse(Reason::script_order, wanted.index, count_);
  if (count_ >= announced_) return refuse(Reason::script_order, number, announced_);
  const double value = wanted.value;
  const auto within = [&](double min, double max) {
    if (value < min) return refuse(Reason::script_value, value, min);
    if (value > max) return refuse(Reason::script_value, value, max);
    return Verdict{};
  };
  const ScriptStep step = read(wanted);
  Verdict verdict;
  if (step.kind == StepKind::pulse) {
    verdict = within(kMinPulse_s, kMaxManual_s);
  } else if (step.which >= 1u << kFanCount) {
    verdict = refuse(Reason::script_actuator, step.which, (1u << kFanCount) - 1);
  } else {
    verdict = step.kind == StepKind::throttle ? within(0, 1) : within(0, 40000);
  }
  if (verdict.reason != Reason::none) return verdict;
  if (count_ > 0 && step.at_ms < step_[count_ - 1u].at_ms)
    return refuse(Reason::script_backwards, wanted.at_s, seconds(step_[count_ - 1u].at_ms));
  if (step.end_ms() > milliseconds(kMaxScript_s))
    return refuse(Reason::script_too_long, seconds(step.end_ms()), kMaxScript_s);
  if (step.kind != StepKind::pulse) return {};
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if ((step.which >> i & 1u) == 0 || busy_until_ms_[i] == 0) continue;
    // The first release after the end of the last pulse.
    const std::int32_t earliest = (busy_until_ms_[i] + kFrame_ms - 1) / kFrame_ms * kFrame_ms;
    if (step.at_ms < earliest)
      return refuse(Reason::script_overlap, wanted.at_s, seconds(earliest));
  }
  return {};
}

Verdict Script::consider_run(std::uint32_t id) const noexcept {
  if (id != id_)
    return {.reason = Reason::script_other, .measured = double(id), .limit = double(id_)};
  if (count_ < announced_ || count_ == 0)
    return {.reason = reasons::script_incomplete,
            .measured = static_cast<double>(count_),
            .limit = static_cast<double>(announced_)};
  return {};
}

void Script::begin(const Request& r) noexcept {
  *this = Script{};
  const auto wanted = arguments<ScriptBegin>(r);
  id_ = wanted.id;
  announced_ = wanted.steps;
}

void Script::add(const Request& r) noexcept {
  const ScriptStep step = read(arguments<ScriptStepArguments>(r));
  step_[count_++] = step;
  end_ms_ = std::max(end_ms_, step.end_ms());
  if (step.kind != StepKind::pulse) {
    fans_ = true;
    return;
  }
  valves_ = static_cast<std::uint8_t>(valves_ | step.which);
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (step.which >> i & 1u) busy_until_ms_[i] = step.end_ms();
  }
}

void Script::run() noexcept {
  running_ = true;
  done_ = 0;
  now_ms_ = -kLead_ms;
  window_.fill({});
}

void Script::open(const ScriptStep& step) noexcept {
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (step.which >> i & 1u) window_[i] = {step.at_ms, step.end_ms()};
  }
}

void Script::write(TalarisOrders& orders, std::int32_t from_ms) noexcept {
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    const Window& w = window_[i];
    if (w.to_ms <= from_ms || w.from_ms >= from_ms + kFrame_ms) continue;
    if (w.from_ms < from_ms) {  // continued from the frame before
      orders.hold[i] = {true, orders.release_ns + (w.to_ms - from_ms) * kMillisecond};
    } else {
      const std::int32_t delay_ms = w.from_ms - from_ms;
      const std::int32_t on_ms = std::min(w.to_ms - w.from_ms, kFrame_ms - delay_ms);
      orders.pulse[i] = {delay_ms * kMillisecond, on_ms * kMillisecond};
    }
  }
}

}  // namespace lss::talaris
