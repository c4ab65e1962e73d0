#include "tests/zebro/mission/autopilot.h"

#include <algorithm>
#include <cmath>

#include "idl/zebro/codes.h"

namespace lss::zebro::mission {
namespace {

using Common = lss::CommandKind;

constexpr double kStand_s = 120, kLayDown_s = 120, kSolve_s = 400, kPanel_s = 30, kLook_s = 5;
constexpr double kAfterReset_s = 3, kAgain_s = 30;
constexpr int kMostRefusals = 5;

bool ended(const Ack* ack) {
  return ack != nullptr && ack->phase != Phase::accepted && ack->phase != Phase::executing;
}

}  // namespace

// Waits for its end; without one in time the last one received, phase accepted or executing.
Ack Autopilot::command_number(std::uint16_t kind, std::initializer_list<double> parameters,
                              double limit_s) {
  const std::uint64_t sequence = link_.send(kind, parameters);
  for (double waited_s = 0; waited_s < limit_s; waited_s += 0.1) {
    if (ended(link_.answer(sequence))) break;
    link_.pass(0.1);
  }
  const Ack* ack = link_.answer(sequence);
  return ack != nullptr ? *ack : Ack{.kind = kind, .phase = Phase::failed};
}

bool Autopilot::may_go_on() const {
  return !arrived() && link_.daylight() && count_.interventions < parameters_.most_interventions;
}

void Autopilot::run() {
  while (may_go_on()) {
    if (!to_idle()) continue;
    if (link_.charge() < parameters_.rest_below) {
      rest();
    } else {
      stretch();
    }
  }
  to_idle();
}

// True when the daemon is idle.
bool Autopilot::to_idle() {
  if (link_.state() == State::operational) command(Common::stop, {1}, kLayDown_s);
  if (link_.state() == State::solve_errors) link_.pass(1);
  if (link_.state() == State::fatal_error) recover();
  return link_.state() == State::idle;
}

void Autopilot::recover() {
  for (int i = 0; i < parameters_.solve_tries; ++i) {
    ++count_.solves;
    const Ack solved = command(Common::solve, {}, kSolve_s);
    if (solved.phase == Phase::completed) {
      ++count_.recoveries;
      return;
    }
    if (solved.verdict.reason == reasons::solved_too_often) return person();
    link_.pass(kAgain_s);
  }
  if (++resets_ > parameters_.reset_tries) return person();
  // Beyond error solving: everything again, including isolated legs. Not the controller: that it
  // has solved the same too often is for a person to forgive.
  ++count_.resets;
  command(Common::reset, {0}, 1);
  command(Common::restore, {}, 1);
  link_.pass(kAfterReset_s);
  ++count_.solves;
  if (command(Common::solve, {}, kSolve_s).phase == Phase::completed) {
    ++count_.recoveries;
    return;
  }
  person();
}

void Autopilot::person() {
  ++count_.interventions;
  resets_ = 0;
  link_.ask_person();
  command(Common::reset, {-1}, 1);
  command(Common::reset, {0}, 1);
  command(Common::restore, {}, 1);
  link_.pass(kAfterReset_s);
  if (link_.state() == State::fatal_error) command(Common::solve, {}, kSolve_s);
}

// The remedy of the reason; when it is the same again and again, a person.
void Autopilot::refused(const Ack& ack) {
  if (++refusals_ >= kMostRefusals) {
    refusals_ = 0;
    return person();
  }
  const Reason reason = ack.verdict.reason;
  if (reason == reasons::panel_deployed) {
    command(CommandKind::panel, {0}, kPanel_s);
  } else if (reason == reasons::fault_latched) {
    command(Common::reset, {static_cast<double>(ack.verdict.subject)}, 1);
    link_.pass(kAfterReset_s);
  } else {
    link_.pass(kLook_s);
    // Silent for long: error solving isolates it, and is for FatalError.
    const bool silent = reason == Reason::module_silent || reason == Reason::never_heard;
    if (silent && refusals_ > 2) command(Common::emergency_stop, {}, 1);
  }
}

void Autopilot::rest() {
  const Ack deployed = command(CommandKind::panel, {1}, kPanel_s);
  if (deployed.phase != Phase::completed) return refused(deployed);
  ++count_.rests;
  link_.sleep(parameters_.rest_until);
  for (int i = 0; i < kMostRefusals; ++i) {
    if (!to_idle()) continue;
    const Ack retracted = command(CommandKind::panel, {0}, kPanel_s);
    if (retracted.phase == Phase::completed) return;
    refused(retracted);
  }
}

// Stands up, walks until something comes between, and lies down.
void Autopilot::stretch() {
  ++count_.stretches;
  said_m_ = 0;
  const Ack started = command(Common::start, {1}, kStand_s);
  if (started.phase == Phase::rejected) return refused(started);
  if (started.phase != Phase::completed || !walk(0)) return;
  refusals_ = 0;
  double steering_rad = 0, without_s = 0, well_s = 0;
  while (link_.state() == State::operational) {
    link_.pass(kLook_s);
    reckon();
    if (misses_a_leg()) without_s += kLook_s;
    well_s += kLook_s;
    if (well_s > parameters_.healthy_s) resets_ = 0;
    const bool tired = link_.charge() < parameters_.rest_below;
    const bool restores = without_s > parameters_.restore_after_s;
    if (!may_go_on() || tired || restores) {
      command(Common::stop, {1}, kLayDown_s);
      if (restores && command(Common::restore, {}, 1).phase == Phase::completed) ++count_.restores;
      return;
    }
    const double wanted_rad = steer(steering_rad);
    if (wanted_rad != steering_rad && walk(wanted_rad)) steering_rad = wanted_rad;
  }
  reckon();
}

bool Autopilot::misses_a_leg() const {
  return std::ranges::any_of(link_.telemetry().modules, &lss_ZebroModule::isolated);
}

bool Autopilot::walk(double heading_rad) {
  const Ack ack =
      command(CommandKind::walk, {1, heading_rad, static_cast<double>(parameters_.speed)}, 0.3);
  return ack.phase == Phase::executing || ack.phase == Phase::accepted;
}

// Back to the course, and towards it from aside, when the heading is off by more than noise.
double Autopilot::steer(double steering_rad) {
  const double wanted_rad = std::clamp(-parameters_.back_rad_m * aside_m_,
                                       -parameters_.most_back_rad, parameters_.most_back_rad);
  const double off_rad = link_.heading_rad() - wanted_rad;
  const bool steers = steering_rad != 0;
  if (std::abs(off_rad) > parameters_.steer_above_rad && !steers) ++count_.steered;
  if (std::abs(off_rad) > parameters_.steer_above_rad)
    return std::copysign(parameters_.steer_rad, off_rad);
  const bool past = off_rad * steering_rad <= 0;
  return steers && !past && std::abs(off_rad) > parameters_.straight_below_rad ? steering_rad : 0;
}

void Autopilot::reckon() {
  const double now_m = link_.telemetry().distance_m;
  course_m_ += (now_m - said_m_) * std::cos(link_.heading_rad());
  aside_m_ += (now_m - said_m_) * std::sin(link_.heading_rad());
  said_m_ = now_m;
}

}  // namespace lss::zebro::mission
