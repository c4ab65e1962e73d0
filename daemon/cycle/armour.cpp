#include "daemon/cycle/armour.h"

#include <algorithm>
#include <cmath>

#include "daemon/cycle/common_commands.h"

namespace lss {
namespace {

// Not empty, terminated, printable.
bool good_text(std::span<const char> name) noexcept {
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

Verdict Armour::check(const Request& request, std::uint64_t writer, const Name& holder) noexcept {
  if (!good_text(request.source)) return refuse(Reason::bad_source);
  if (request.kind == 0) return {};  // a heartbeat: nothing else in it is used
  const CommandInfo* info = find_command(commands_, request.kind);
  if (info == nullptr) return refuse(Reason::unknown_command, request.kind);
  if (const Verdict v = check_parameters(*info, request); v.reason != Reason::none) return v;
  if (const Verdict v = check_name(*info, request); v.reason != Reason::none) return v;
  if (info->leased) {
    if (request.lease_ms < lease_min_ms_)
      return refuse(Reason::bad_lease, request.lease_ms, lease_min_ms_);
    if (request.lease_ms > lease_max_ms_)
      return refuse(Reason::bad_lease, request.lease_ms, lease_max_ms_);
  }
  if (info->access == Access::anyone) return {};
  return check_sequence(request, writer, holder);
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

Verdict Armour::check_name(const CommandInfo& info, const Request& request) const noexcept {
  if (!info.named)
    return refuse(request.name == ParameterName{} ? Reason::none : Reason::unused_name);
  if (!good_text(request.name)) return refuse(Reason::bad_name);
  const bool known = find_tunable(tunables_, {request.name.data(), request.name.size()}) >= 0;
  return refuse(known ? Reason::none : Reason::no_such_parameter);
}

Verdict Armour::check_sequence(const Request& request, std::uint64_t writer,
                               const Name& holder) noexcept {
  const auto older = [&](const Writer& a, const Writer& b) {
    const auto kept = [&](const Writer& w) { return w.id != 0 && w.source == holder; };
    return kept(a) != kept(b) ? kept(b) : a.seen_ns < b.seen_ns;
  };
  auto room = std::ranges::find(writers_, writer, &Writer::id);
  if (room == writers_.end()) {
    room = std::ranges::min_element(writers_, older);
  } else if (request.sequence <= room->sequence) {
    return refuse(Reason::stale_sequence, static_cast<double>(request.sequence),
                  static_cast<double>(room->sequence));
  }
  *room = {.id = writer,
           .source = request.source,
           .sequence = request.sequence,
           .seen_ns = request.arrival_ns};
  return {};
}

}  // namespace lss
