#include "daemon/vehicles/zebro/solver.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <utility>

#include "daemon/cycle/plan.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

constexpr double kWholeTurn_rad = 6.283185307179586;
constexpr double kArrived_rad = 0.05;
constexpr TimeNs kMoveGrace = kSecond;      // a movement this late has failed
constexpr TimeNs kReplanned = kSecond / 2;  // shortest time of a movement that is ordered again

double turned(double from_rad, double by_rad) noexcept {
  return std::fmod(from_rad + by_rad + kWholeTurn_rad, kWholeTurn_rad);
}
double apart(double a_rad, double b_rad) noexcept {
  return std::abs(std::remainder(a_rad - b_rad, kWholeTurn_rad));
}

}  // namespace

FaultClass class_of(FaultId fault) noexcept {
  constexpr std::pair<FaultId, FaultClass> kClasses[] = {
      {FaultId::module_silent, FaultClass::contact},
      {FaultId::module_over_current, FaultClass::current},
      {faults::current_limit, FaultClass::current},
      {faults::current_sum, FaultClass::current},
      {faults::module_driver_fault, FaultClass::driver},
      {FaultId::module_disobeys, FaultClass::obedience},
      {faults::module_watchdog, FaultClass::obedience},
      {faults::motion_timeout, FaultClass::obedience},
      {faults::leg_still, FaultClass::obedience},
      {FaultId::module_reset, FaultClass::supply},
      {faults::report_impossible, FaultClass::report},
      {faults::position_jumps, FaultClass::report},
      {faults::gear_slips, FaultClass::gear},
  };
  return class_in(kClasses, fault, FaultClass::system);
}

bool of_operator(FaultId fault) noexcept {
  return fault == FaultId::emergency_stop || fault == FaultId::obc_silent;
}

void ResetModules::begin(Vehicle& vehicle, std::uint8_t modules) noexcept {
  for (std::size_t i = 0; i < kModules; ++i) {
    if (all_ || contains(modules, i)) vehicle.reset(i);
  }
}

void MoveFree::begin(Vehicle& vehicle, std::uint8_t modules) noexcept {
  left_ = 0;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(modules, i) && vehicle.answers(i))
      left_ = static_cast<std::uint8_t>(left_ | 1u << i);
  }
  moved_ = stuck_ = 0;
  phase_ = Phase::next_leg;
}

// Others may still be moved: only what does not move is isolated.
Treatment MoveFree::give_up_leg(Vehicle& vehicle) noexcept {
  vehicle.rest();
  stuck_ = static_cast<std::uint8_t>(stuck_ | 1u << leg_);
  phase_ = Phase::next_leg;
  return Treatment::running;
}

Treatment MoveFree::step(Vehicle& vehicle) noexcept {
  const TimeNs now = vehicle.now();
  if (phase_ == Phase::next_leg) {
    if (left_ == 0) return stuck_ == 0 ? Treatment::done : Treatment::failed;
    leg_ = static_cast<std::size_t>(std::countr_zero(left_));
    left_ = static_cast<std::uint8_t>(left_ & (left_ - 1));
    if (!vehicle.begin_move(leg_)) return give_up_leg(vehicle);
    phase_ = Phase::switching_on;
    due_ns_ = now + kMoveGrace;
    return Treatment::running;
  }
  const Status& status = vehicle.status(leg_);
  const bool late = now > due_ns_ + kMoveGrace || vehicle.doubtful(leg_);
  const bool stopped = phase_ != Phase::switching_on &&
                       (status.flags & (kFlagOverCurrent | kFlagDriverFault | kFlagWatchdog)) != 0;
  if (late || stopped || !vehicle.answers(leg_) || status.current_A > parameters_.current_limit_A)
    return give_up_leg(vehicle);
  follow_calibration(vehicle);
  const auto moved = [&](double to_rad) {
    return now >= due_ns_ && (status.flags & kFlagMoving) == 0 &&
           apart(status.position_rad, to_rad) < kArrived_rad;
  };
  switch (phase_) {
    case Phase::switching_on:
      if ((status.flags & kFlagMotionControl) == 0) break;
      from_rad_ = status.position_rad;
      due_ns_ = now + parameters_.free_move_ns;
      phase_ = Phase::back;
      order(vehicle);
      break;
    case Phase::back:
      if (!moved(turned(from_rad_, -parameters_.free_rad))) break;
      due_ns_ = now + parameters_.free_move_ns;
      phase_ = Phase::forth;
      order(vehicle);
      break;
    case Phase::forth:
      if (!moved(from_rad_)) break;
      vehicle.rest();
      moved_ = static_cast<std::uint8_t>(moved_ | 1u << leg_);
      phase_ = Phase::next_leg;
      break;
    case Phase::next_leg: break;
  }
  return Treatment::running;
}

void MoveFree::order(Vehicle& vehicle) noexcept {
  const bool forth = phase_ == Phase::forth;
  vehicle.order_move(leg_, forth ? from_rad_ : turned(from_rad_, -parameters_.free_rad), due_ns_,
                     forth);
}

// At its Hall sensor a leg's position becomes the true one, and the module goes on to its ordered
// position, which is now another place, up to a turn away.
void MoveFree::follow_calibration(Vehicle& vehicle) noexcept {
  const Status& status = vehicle.status(leg_);
  const bool calibrated = (status.flags & kFlagCalibrated) != 0;
  const bool under_way = phase_ == Phase::back || phase_ == Phase::forth;
  if (under_way && calibrated && !calibrated_) {
    from_rad_ = turned(status.position_rad, std::remainder(from_rad_ - seen_rad_, kWholeTurn_rad));
    due_ns_ = std::max(due_ns_, vehicle.now() + kReplanned);
    order(vehicle);
  }
  calibrated_ = calibrated;
  seen_rad_ = status.position_rad;
}

Treatment CoolDown::step(Vehicle& vehicle) noexcept {
  for (std::size_t i = 0; i < kModules; ++i) {
    if (contains(modules_, i) && vehicle.temperature_degC(i) > parameters_.cool_degC)
      return Treatment::running;
  }
  // Cool: the trip may be cleared.
  for (std::size_t i = 0; i < kModules; ++i) {
    if (contains(modules_, i)) vehicle.reset(i);
  }
  return Treatment::done;
}

void Isolate::begin(Vehicle& vehicle, std::uint8_t modules) noexcept {
  modules_ = modules;
  until_ns_ = vehicle.now() + kMoveGrace;
}

// Waits until the motor of a leg that was just moved is off.
Treatment Isolate::step(Vehicle& vehicle) noexcept {
  for (std::size_t i = 0; i < kModules && vehicle.now() < until_ns_; ++i) {
    const bool motor = (vehicle.status(i).flags & kFlagMotionControl) != 0;
    if (contains(modules_, i) && vehicle.answers(i) && motor) return Treatment::running;
  }
  return modules_ == 0 || vehicle.isolate(modules_) ? Treatment::done : Treatment::failed;
}

Solver::Solver(const SolverParameters& parameters) noexcept
    : parameters_(parameters), move_free_(parameters), cool_down_(parameters) {}

void Solver::begin(std::span<const Symptom> symptoms) noexcept {
  std::array<bool, kFaultClasses> present{};
  unsigned suspects = 0, relapsed = 0;
  for (const Symptom& symptom : symptoms) {
    const FaultClass c = symptom.fault_class;
    present[static_cast<std::size_t>(c)] = true;
    const bool misled =
        c == FaultClass::obedience || c == FaultClass::report || c == FaultClass::gear;
    const bool under_power = misled || c == FaultClass::current || c == FaultClass::driver;
    const bool leg = symptom.module >= 1 && symptom.module <= kLegs;
    if (under_power && leg) suspects |= 1u << (symptom.module - 1);
    const StrategyList& order = parameters_.order[static_cast<std::size_t>(c)];
    const bool isolates = std::ranges::count(order, StrategyKind::isolate) != 0;
    if (misled && leg && symptom.again && isolates) relapsed |= 1u << (symptom.module - 1);
  }
  suspects_ = static_cast<std::uint8_t>(suspects);
  relapsed_ = static_cast<std::uint8_t>(relapsed);
  blamed_ = 0;
  // The cause may be gone by now.
  plan_ = plan(parameters_.order, present, StrategyKind::reconnect);
  if (relapsed_ != 0 && plan_[0] != StrategyKind::isolate) {
    // In place of the first one when there are too many.
    if (plan_.back() == StrategyKind::none) std::shift_right(plan_.begin(), plan_.end(), 1);
    plan_[0] = StrategyKind::isolate;
  }
  at_ = 0;
  running_ = true;
  begun_ = false;
}

Strategy& Solver::strategy() noexcept {
  switch (kind()) {
    case StrategyKind::reset_module: return reset_module_;
    case StrategyKind::move_free: return move_free_;
    case StrategyKind::cool_down: return cool_down_;
    case StrategyKind::isolate: return isolate_;
    case StrategyKind::reset_all: return reset_all_;
    case StrategyKind::none:
    case StrategyKind::reconnect: break;
  }
  return reconnect_;
}

TimeNs Solver::moves_ns(std::uint8_t legs) const noexcept {
  return std::popcount(legs) * 2 * (parameters_.free_move_ns + 2 * kMoveGrace);
}

void Solver::clear_moved() noexcept {
  suspects_ = static_cast<std::uint8_t>(suspects_ & ~move_free_.moved());
}

Solver::Report Solver::give_up(Vehicle& vehicle) noexcept {
  unsigned blamed = suspects_;
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(vehicle.faulty_modules(), i) && vehicle.answers(i)) blamed |= 1u << i;
  }
  blamed_ = static_cast<std::uint8_t>(blamed);
  vehicle.rest();  // ends a movement in progress
  if (at_ + 1 == plan_.size() || plan_[at_ + 1] == StrategyKind::none) return Report::unsolved;
  ++at_;
  begun_ = false;
  return Report::next;
}

Solver::Report Solver::step(Vehicle& vehicle, bool healthy) noexcept {
  const TimeNs now = vehicle.now();
  suspects_ = static_cast<std::uint8_t>(suspects_ & ~vehicle.isolated());
  if (!begun_) {
    auto modules = static_cast<std::uint8_t>(vehicle.faulty_modules() | suspects_);
    if (at_ == 0 && relapsed_ != 0) modules = relapsed_;
    // New orders between two strategies hide that a module disobeys.
    if (kind() == StrategyKind::isolate && modules == 0) modules = blamed_;
    strategy().begin(vehicle, modules);
    begun_ = true;
    std::uint8_t moves = suspects_;
    if (kind() == StrategyKind::move_free) moves = modules;
    if (kind() == StrategyKind::isolate) moves = static_cast<std::uint8_t>(suspects_ & ~modules);
    until_ns_ = now + moves_ns(moves) +
                (kind() == StrategyKind::cool_down ? parameters_.cool_down_ns : 0) +
                parameters_.budget_ns;
    phase_ = Phase::treating;
  }
  if (now > until_ns_) return give_up(vehicle);
  switch (phase_) {
    case Phase::treating: {
      const Treatment treatment = strategy().step(vehicle);
      if (kind() == StrategyKind::move_free) clear_moved();
      if (treatment == Treatment::failed) return give_up(vehicle);
      if (treatment == Treatment::running) break;
      phase_ = Phase::waiting;
      until_ns_ = std::min(until_ns_, now + parameters_.budget_ns + moves_ns(suspects_));
      break;
    }
    case Phase::waiting:
      if (!healthy) break;
      healthy_since_ns_ = now;
      phase_ = suspects_ != 0 ? Phase::moving : Phase::proving;
      if (phase_ == Phase::moving) move_free_.begin(vehicle, suspects_);
      break;
    case Phase::moving: {
      const Treatment treatment = move_free_.step(vehicle);
      clear_moved();
      if (treatment == Treatment::failed) return give_up(vehicle);
      if (treatment == Treatment::running) break;
      phase_ = Phase::waiting;
      break;
    }
    case Phase::proving:
      if (!healthy) phase_ = Phase::waiting;
      if (healthy && now - healthy_since_ns_ >= kProof) return Report::solved;
      break;
  }
  return Report::running;
}

}  // namespace lss::zebro
