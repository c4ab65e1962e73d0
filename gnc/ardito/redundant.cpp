#include "gnc/ardito/redundant.h"

#include <cstring>
#include <type_traits>

namespace lss::gnc::ardito {

static_assert(std::is_trivially_copyable_v<MobilityController>);
static_assert(kAllMembersTied<Geometry> && kAllMembersTied<Parameters>);
static_assert(kAllMembersTied<WheelHealth> && kAllMembersTied<SteeringHealth>);
static_assert(kAllMembersTied<Linkage> && kAllMembersTied<SlipWatch>);
static_assert(kAllMembersTied<State> && kAllMembersTied<MobilityController>);
static_assert(kAllMembersTied<Estimate> && kAllMembersTied<Command>);

namespace {

bool several(std::uint32_t set) noexcept { return (set & (set - 1)) != 0; }

// Usually all are equal, which one comparison shows: every byte of them is tied.
template <class T>
std::uint32_t compare(T& a, T& b, T& c) noexcept {
  static_assert(kAllMembersTied<T>);
  if (std::memcmp(&a, &b, sizeof a) == 0 && std::memcmp(&a, &c, sizeof a) == 0) return 0;
  return vote(a, b, c);
}

}  // namespace

Command Redundant::step(const Request& request, const Measured& measured) noexcept {
  auto& [a, b, c] = instances_;
  const std::uint32_t before = compare(a, b, c);
  Command command = a.step(request, measured);
  Command second = b.step(request, measured);
  Command third = c.step(request, measured);
  const std::uint32_t after = compare(a, b, c) | compare(command, second, third);

  report_.disagreed = before | after;
  report_.no_majority = several(before) || several(after) ? 1 : 0;
  if (report_.disagreed != 0 && report_.upsets < UINT32_MAX) ++report_.upsets;
  if (report_.no_majority != 0) {
    // Wheels that are out of work stay so: their gears may be blocked.
    const Command voted = command;
    command = {};
    command.clutches_engaged = voted.clutches_engaged;
    command.motors_stopped = voted.motors_stopped;
    command.error = 1;
  }
  return command;
}

}  // namespace lss::gnc::ardito
