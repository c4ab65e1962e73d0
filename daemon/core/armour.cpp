#include "daemon/core/armour.h"

#include <algorithm>
#include <cmath>

namespace lss {
namespace {

constexpr TimeNs kForgetAfter =
    10 * kSecond;  // a source that was silent so long makes room for another

// Named, terminated, printable.
bool good_source(const Name& name) noexcept {
  if (name.front() == '\0' || name.back() != '\0') return false;
  for (const char c : name) {
    if (c == '\0') return true;
    if (c < ' ' || c > '~') return false;
  }
  return true;
}

Verdict refuse(Reason reason, double measured = kRequired, double limit = kRequired,
               std::uint16_t subject = 0) noexcept {
  return {.reason = reason, .measured = measured, .limit = limit, .subject = subject};
}

}  // namespace

Verdict Armour::check(const Request& request) noexcept {
  // An emergency stop is taken from anyone, always, however badly it is put.
  if (request.kind == static_cast<std::uint16_t>(CommandKind::emergency_stop)) return {};
  if (!good_source(request.source)) return refuse(Reason::bad_source);
  if (request.kind == 0) return {};  // a heartbeat: nothing else in it is believed
  const CommandInfo* info = lookup_(request.kind);
  if (info == nullptr) return refuse(Reason::unknown_command, request.kind);
  if (const Verdict v = check_parameters(*info, request); v.reason != Reason::none) return v;
  if (info->leased) {
    if (request.lease_ms < lease_min_ms_)
      return refuse(Reason::bad_lease, request.lease_ms, lease_min_ms_);
    if (request.lease_ms > lease_max_ms_)
      return refuse(Reason::bad_lease, request.lease_ms, lease_max_ms_);
  }
  return check_sequence(request);
}

Verdict Armour::check_parameters(const CommandInfo& info, const Request& request) const noexcept {
  for (std::size_t i = 0; i < kMaxParameters; ++i) {
    const double value = request.parameter[i];
    const auto number = static_cast<std::uint16_t>(i + 1);
    if (!std::isfinite(value)) return refuse(Reason::not_finite, value, kRequired, number);
    if (i >= info.parameters.size()) {
      if (value != 0) return refuse(Reason::unused_parameter, value, 0, number);
      continue;
    }
    const ParameterInfo& p = info.parameters[i];
    if (value < p.min) return refuse(Reason::out_of_range, value, p.min, number);
    if (value > p.max) return refuse(Reason::out_of_range, value, p.max, number);
    if (p.is_whole() && value != std::floor(value))
      return refuse(Reason::not_a_choice, value, kRequired, number);
  }
  return {};
}

Verdict Armour::check_sequence(const Request& request) noexcept {
  Source* room = nullptr;
  for (Source& source : sources_) {
    if (source.name == request.source) {
      if (request.sequence <= source.sequence) {
        return refuse(Reason::stale_sequence, static_cast<double>(request.sequence),
                      static_cast<double>(source.sequence));
      }
      room = &source;
      break;
    }
    const bool free =
        source.name.front() == '\0' || request.arrival_ns - source.seen_ns > kForgetAfter;
    if (free && (room == nullptr || source.seen_ns < room->seen_ns)) room = &source;
  }
  if (room == nullptr) return refuse(Reason::too_many_sources, kMaxSources, kMaxSources);
  *room = {.name = request.source, .sequence = request.sequence, .seen_ns = request.arrival_ns};
  return {};
}

}  // namespace lss
