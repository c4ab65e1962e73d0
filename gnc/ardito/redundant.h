#pragma once

// Three instances of the mobility controller and a majority comparator against soft errors
// (Ardito thesis, FMEA 7.5.3).
//
// Before each frame all members of the three, parameters and state, are voted bit by bit and the
// majority is written back into all three; after it the states and the three commands are voted
// the same way. One instance that differs has no effect and is reported; when no two agree the
// result is the stop command with an error, with the bitwise majority of clutches and of motors
// that are stopped, and the instances go on with the bitwise majority.

#include "gnc/ardito/mobility_controller.h"
#include "gnc/ardito/vote.h"

namespace lss::gnc::ardito {

struct VoteReport {
  std::uint32_t disagreed = 0;    // bit i: instance i differed this frame and was re-synchronised
  std::uint32_t no_majority = 0;  // 1: no two were equal
  std::uint32_t upsets = 0;       // frames with a difference since the start, stays at its maximum
};

class Redundant {
 public:
  explicit Redundant(const Parameters& parameters = {}) noexcept
      : instances_{MobilityController(parameters), MobilityController(parameters),
                   MobilityController(parameters)} {}

  Command step(const Request& request, const Measured& measured) noexcept;

  // All three, so that they still agree.
  void configure(const Parameters& parameters) noexcept {
    for (MobilityController& instance : instances_) instance.configure(parameters);
  }

  const VoteReport& report() const noexcept { return report_; }
  // For tests that inject soft errors.
  MobilityController& instance(std::size_t i) noexcept { return instances_[i]; }

 private:
  std::array<MobilityController, 3> instances_;
  VoteReport report_;
};

}  // namespace lss::gnc::ardito
