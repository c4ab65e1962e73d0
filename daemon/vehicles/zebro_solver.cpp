#include "daemon/vehicles/zebro_solver.h"

#include <bit>
#include <cmath>

namespace lss::zebro {
namespace {

constexpr double kTurn_rad = 6.283185307179586;
constexpr double kArrived_rad = 0.05;
constexpr TimeNs kMoveGrace = kSecond;  // a movement this late has failed

double turned(double from_rad, double by_rad) noexcept {
  return std::fmod(from_rad + by_rad + kTurn_rad, kTurn_rad);
}
double apart(double a_rad, double b_rad) noexcept {
  return std::abs(std::remainder(a_rad - b_rad, kTurn_rad));
}

}  // namespace

FaultClass class_of(FaultId fault) noexcept {
  switch (fault) {
    case FaultId::module_silent:
      return FaultClass::contact;
    case FaultId::module_over_current:
    case FaultId::current_limit:
      return FaultClass::current;
    case FaultId::module_driver_fault:
      return FaultClass::driver;
    case FaultId::module_disobeys:
    case FaultId::module_watchdog:
    case FaultId::motion_timeout:
      return FaultClass::obedience;
    case FaultId::module_reset:
      return FaultClass::supply;
    default:
      return FaultClass::system;
  }
}

void ResetModules::begin(Patient& patient, std::uint8_t modules) noexcept {
  for (std::size_t i = 0; i < kModules; ++i) {
    if (all_ || contains(modules, i)) patient.reset(i);
  }
}

void MoveFree::begin(Patient& patient, std::uint8_t modules) noexcept {
  left_ = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(modules, i) && patient.answers(i))
      left_ = static_cast<std::uint8_t>(left_ | 1u << i);
  }
  phase_ = Phase::next_leg;
}

Outcome MoveFree::end(Patient& patient, Outcome outcome) noexcept {
  patient.rest();
  left_ = 0;
  phase_ = Phase::next_leg;
  return outcome;
}

Outcome MoveFree::step(Patient& patient) noexcept {
  const TimeNs now = patient.now();
  if (phase_ == Phase::next_leg) {
    if (left_ == 0) return Outcome::done;
    leg_ = static_cast<std::size_t>(std::countr_zero(left_));
    left_ = static_cast<std::uint8_t>(left_ & (left_ - 1));
    if (!patient.begin_move(leg_)) return end(patient, Outcome::failed);
    phase_ = Phase::switching_on;
    due_ns_ = now + kMoveGrace;
    return Outcome::running;
  }
  const Status& status = patient.status(leg_);
  const bool late = now > due_ns_ + kMoveGrace;
  const bool stopped = phase_ != Phase::switching_on &&
                       (status.flags & (kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog)) != 0;
  if (late || stopped || !patient.answers(leg_) || status.current_A > parameters_.current_limit_A)
    return end(patient, Outcome::failed);
  const auto moved = [&](double to_rad) {
    return now >= due_ns_ && (status.flags & kFlagMoving) == 0 &&
           apart(status.position_rad, to_rad) < kArrived_rad;
  };
  const double back_rad = turned(from_rad_, -parameters_.free_rad);
  switch (phase_) {
    case Phase::switching_on:
      if ((status.flags & kFlagMotionControl) == 0) break;
      from_rad_ = status.position_rad;
      due_ns_ = now + parameters_.free_move_ns;
      patient.move(leg_, turned(from_rad_, -parameters_.free_rad), due_ns_, false);
      phase_ = Phase::back;
      break;
    case Phase::back:
      if (!moved(back_rad)) break;
      due_ns_ = now + parameters_.free_move_ns;
      patient.move(leg_, from_rad_, due_ns_, true);
      phase_ = Phase::forth;
      break;
    case Phase::forth:
      if (!moved(from_rad_)) break;
      patient.rest();
      phase_ = Phase::next_leg;
      break;
    case Phase::next_leg:
      break;
  }
  return Outcome::running;
}

Outcome CoolDown::step(Patient& patient) noexcept {
  for (std::size_t i = 0; i < kModules; ++i) {
    if (contains(modules_, i) && patient.temperature_degC(i) > parameters_.cool_degC)
      return Outcome::running;
  }
  // Cool: what tripped may be forgotten.
  for (std::size_t i = 0; i < kModules; ++i) {
    if (contains(modules_, i)) patient.reset(i);
  }
  return Outcome::done;
}

Outcome Isolate::step(Patient& patient) noexcept {
  return modules_ == 0 || patient.isolate(modules_) ? Outcome::done : Outcome::failed;
}

Solver::Solver(const SolverParameters& parameters) noexcept
    : parameters_(parameters), move_free_(parameters), cool_down_(parameters) {}

// The first choice of every class that has a fault, then the second ones, and so on.
void Solver::begin(std::span<const FaultRecord> faults) noexcept {
  std::array<bool, kFaultClasses> present{};
  unsigned blocked = 0;
  for (const FaultRecord& fault : faults) {
    const FaultClass c = class_of(fault.id);
    present[static_cast<std::size_t>(c)] = true;
    const bool blocks = c == FaultClass::current || fault.id == FaultId::motion_timeout;
    if (blocks && fault.subject >= 1 && fault.subject <= kLegs)
      blocked |= 1u << (fault.subject - 1);
  }
  blocked_ = static_cast<std::uint8_t>(blocked);
  plan_.fill(StrategyKind::none);
  std::size_t count = 0;
  for (std::size_t choice = 0; choice < lc::kMaxStrategies; ++choice) {
    for (std::size_t c = 0; c < kFaultClasses; ++c) {
      const StrategyKind kind = parameters_.order[c][choice];
      if (!present[c] || kind == StrategyKind::none || count == plan_.size()) continue;
      if (count > 0 && plan_[count - 1] == kind) continue;
      plan_[count++] = kind;
    }
  }
  // Whatever was wrong may be well by now.
  if (count == 0) plan_[0] = StrategyKind::reconnect;
  at_ = 0;
  running_ = true;
  begun_ = false;
}

Strategy& Solver::strategy() noexcept {
  switch (kind()) {
    case StrategyKind::reset_module:
      return reset_module_;
    case StrategyKind::move_free:
      return move_free_;
    case StrategyKind::cool_down:
      return cool_down_;
    case StrategyKind::isolate:
      return isolate_;
    case StrategyKind::reset_all:
      return reset_all_;
    case StrategyKind::none:
    case StrategyKind::reconnect:
      break;
  }
  return reconnect_;
}

TimeNs Solver::budget_ns() const noexcept {
  return kind() == StrategyKind::cool_down ? parameters_.cool_down_ns : parameters_.budget_ns;
}

Solver::Report Solver::step(Patient& patient, bool healthy) noexcept {
  const TimeNs now = patient.now();
  if (!begun_) {
    strategy().begin(patient, static_cast<std::uint8_t>(patient.sick() | blocked_));
    begun_ = true;
    begun_ns_ = now;
    healthy_since_ns_ = 0;
    outcome_ = Outcome::running;
  }
  if (outcome_ == Outcome::running) outcome_ = strategy().step(patient);
  if (outcome_ == Outcome::done) blocked_ = 0;
  const bool proving = outcome_ == Outcome::done && healthy;
  if (!proving) healthy_since_ns_ = 0;
  if (proving && healthy_since_ns_ == 0) healthy_since_ns_ = now;
  if (proving && now - healthy_since_ns_ >= kProof) return Report::solved;
  if (outcome_ != Outcome::failed && now - begun_ns_ <= budget_ns()) return Report::running;
  // Nothing that it began goes on.
  patient.rest();
  if (at_ + 1 == plan_.size() || plan_[at_ + 1] == StrategyKind::none) return Report::unsolved;
  ++at_;
  begun_ = false;
  return Report::next;
}

}  // namespace lss::zebro
