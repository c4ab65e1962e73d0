// Error solving of Lunar Zebro: the strategies' access to the vehicle, their initial symptoms, and
// the count of rounds.

#include "daemon/cycle/solving.h"

#include "daemon/vehicles/zebro/vehicle.h"

namespace lss::zebro {

std::uint8_t Vehicle::faulty_modules() const noexcept {
  unsigned mask = 0;
  for (std::size_t i = 0; i < kModules; ++i) {
    const bool well = answers(i) && (modules_[i].status.flags & kStopFlags) == 0 &&
                      !disobeyed_[i] && !doubtful(i);
    if (in_service(i) && !well) mask |= 1u << i;
  }
  return static_cast<std::uint8_t>(mask);
}

bool Vehicle::isolate(std::uint8_t modules) noexcept {
  // All of them, or none: no leg is lost when walking is impossible without them.
  if (contains(modules, kPanel)) return false;
  const unsigned all = (isolated_ | modules) & kAllLegs;
  if (!enough_legs_without(all) || !walks_without_[all]) return false;
  for (std::size_t i = 0; i < kLegs; ++i) {
    // Do not go on with a motor that cannot be switched off.
    const bool motor = (modules_[i].status.flags & kFlagMotionControl) != 0;
    if (contains(modules, i) && answers(i) && motor) return false;
  }
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(modules, i)) supervisor_->happen(event::isolate, number(i));
  }
  // When it is restored its angle is searched: what it has counted so far is not believed.
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (contains(modules, i) && answers(i)) order(i, ModuleOrder::Kind::reset);
  }
  isolated_ = supervisor_->controller().isolated;
  return true;
}

bool Vehicle::begin_move(std::size_t leg) noexcept {
  if (supervisor_->happen(event::free_leg, number(leg)).reason != Reason::none) return false;
  order(leg, ModuleOrder::Kind::motion_on);
  return true;
}

void Vehicle::rest() noexcept {
  if (supervisor_->controller().flags & kFreeing) supervisor_->happen(event::leg_freed);
}

// From the latched faults and the present ones.
Vehicle::Symptoms Vehicle::symptoms(const Supervisor& s) const noexcept {
  Symptoms all;
  each_fatal(s, [&](const FaultRecord& fault) {
    all.add({class_of(fault.id), fault.subject, !of_operator(fault.id)});
  });
  for (std::size_t i = 0; i < kModules; ++i) {
    if (!in_service(i)) continue;
    const auto see = [&](bool wrong, FaultClass fault_class) {
      if (wrong) all.add({fault_class, number(i)});
    };
    const std::uint16_t flags = modules_[i].status.flags;
    see(!answers(i), FaultClass::contact);
    see((flags & kFlagOverCurrent) != 0, FaultClass::current);
    see((flags & kFlagDriverFault) != 0, FaultClass::driver);
    see((flags & kFlagWatchdog) != 0 || disobeyed_[i], FaultClass::obedience);
    see(doubtful(i), class_of(fault_of(checks_[i].finding(now_ns_))));
  }
  return all;
}

// A fault that is solved again and again and returns at the next step needs a person: the guard of
// `solve` reads these values in sense.
void Vehicle::watch_rounds(Supervisor& s) noexcept {
  const State state = s.controller().state;
  if (state == State::fatal_error) operated_ns_ = 0;
  if (state == State::operational) operated_ns_ += now_ns_ - before_ns_;
  before_ns_ = now_ns_;
  if (operated_ns_ >= parameters_.solver.healthy_ns) rounds_.forget();
  const Rounds::Most most = rounds_.most(symptoms(s).all());
  std::array<double, kMaxModules> sense = s.state().sense;
  sense[kSenseSolveRounds] = most.rounds;
  sense[kSenseSolveModule] = most.module;
  sense[kSenseSolveLimit] = parameters_.solver.rounds;
  s.set_sense(sense);
}

void Vehicle::watch_solver(Supervisor& s) noexcept {
  if (s.controller().state != State::solve_errors) return;
  bool healthy = port_.open() && faulty_modules() == 0 && s.controller().unheard == 0;
  for (std::size_t i = 0; i < kModules; ++i) {
    const bool motor = (modules_[i].status.flags & kFlagMotionControl) != 0;
    healthy = healthy && !(motor && answers(i));
  }
  const auto begin = [&] {
    Symptoms all = symptoms(s);
    rounds_.begun(all.all());
    for (Symptom& symptom : std::span(all.items).first(all.count))
      symptom.again = rounds_.of(symptom) > 1;
    solver_.begin(all.all());
  };
  solve_errors(s, solver_, begin, [&] { return solver_.step(*this, healthy); });
}

}  // namespace lss::zebro
