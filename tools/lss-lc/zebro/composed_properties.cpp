// The properties of the composed system, checked after each frame.

#include <algorithm>
#include <bit>

#include "tools/lss-lc/zebro/composed.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr TimeNs kLongest = 3600 * kSecond;

bool moves(const ModuleOrder& order) { return order.rotates() || order.kind == Kind::motion_on; }

}  // namespace

bool Composed::ill(std::size_t i) const {
  const AbstractModule& m = env_.module[i];
  return m.ill != Ill::well || m.tripped() || m.disobeys();
}

// Whether the daemon could know by now that something is wrong, and has to do something.
bool Composed::exposed(const Active& active) const {
  const lc::ControllerState& c = controller();
  const bool operational = c.state == State::operational;
  const bool held = (c.links & lc::kHeld) != 0;
  if (active.module != 0) {
    const std::size_t i = active.module - 1u;
    if ((c.isolated >> i & 1u) != 0 || !env_.plugged || !env_.runs) return false;
    const AbstractModule& m = env_.module[i];
    switch (m.ill) {
      case Ill::well: return false;
      case Ill::silent:  // in Idle, too, unless it was never heard or the port was not there
        return operational || (c.state == State::idle && ((c.silent | c.unheard) >> i & 1u) == 0);
      case Ill::jammed: return operational && m.tripped();
      case Ill::deaf:
      case Ill::late: return operational && m.contradicts() && m.disobeys();
      case Ill::frozen: {
        const auto mode = static_cast<Mode>(c.mode);
        return operational && (mode == Mode::walking || mode == Mode::standing_up ||
                               mode == Mode::finishing_step || mode == Mode::lying_down);
      }
    }
  }
  switch (active.failure) {
    case Failure::unplugged:
    case Failure::bus_stands: return operational;
    case Failure::client_lost:
    case Failure::obc_lost: return held;
    default: return false;
  }
}

// From the configuration; frames are judged at their end, so one step is allowed each.
TimeNs Composed::limit(Failure failure) const {
  switch (failure) {
    case Failure::silent: return limits_.module_silent_ns + kStep;
    case Failure::frozen:
      // The longest movement of the fastest gait, and a way back that is ordered at most twice.
      return static_cast<TimeNs>(
                 (limits_.locomotion.late_limit_s +
                  2 * (limits_.locomotion.flight_s + limits_.locomotion.stance_min_s)) *
                 1e9) +
             kStep;
    case Failure::bus_stands: return kit::PortWatch::kBusStuckAfter + kStep;
    case Failure::client_lost:
    case Failure::obc_lost: return static_cast<TimeNs>(kLease_ms) * kMillisecond + kStep;
    default: return kStep;
  }
}

const char* Composed::check_losses() {
  for (Active& active : std::span(env_.active).first(env_.failed)) {
    if (!active.lasts || !exposed(active)) {
      active.exposed_ns = 0;
      continue;
    }
    active.exposed_ns += kStep;
    if (active.exposed_ns > limit(active.failure))
      return "each loss leads to a safe state within its time";
  }
  // Without who commands it comes to rest: the step is finished, it lies down.
  const bool on_its_own =
      controller().state == State::operational && (controller().links & lc::kHeld) == 0;
  env_.unheld_ns = on_its_own ? env_.unheld_ns + kStep : 0;
  const gnc::zebro::LocomotionParameters& p = limits_.locomotion;
  const double rest_s =
      2 * (p.flight_s + p.stance_min_s) + p.lay_down_s + p.lift_s + p.align_s + p.late_limit_s;
  if (static_cast<double>(env_.unheld_ns) * 1e-9 > rest_s)
    return "without the heartbeat of who commands it comes to rest within its time";
  return nullptr;
}

const char* Composed::check_orders() const {
  const lc::ControllerState& c = controller();
  int driven = 0;
  for (std::size_t i = 0; i < kModules; ++i) {
    const ModuleOrder& order = out_->command.module[i];
    if (!moves(order)) continue;
    ++driven;
    if ((c.isolated >> i & 1u) != 0) return "no motion order to an isolated module";
    if ((c.silent >> i & 1u) != 0) return "no motion order to a silent module";
    if (i == kPanel && c.state == State::operational)
      return "the panel stays where it is in operation";
    if (c.state == State::idle || c.state == State::fatal_error)
      return "no motion order in Idle and FatalError";
  }
  if (c.state == State::solve_errors && driven > 1) return "error solving moves one leg at a time";
  if (env_.emergency_stop || (c.state == State::fatal_error && env_.changed && driven > 0)) {
    if (env_.emergency_stop && c.state != State::fatal_error)
      return "an emergency stop is obeyed from each state";
    for (const ModuleOrder& order : out_->command.module) {
      if (env_.emergency_stop && order.kind != Kind::emergency_stop)
        return "an emergency stop is obeyed from each state";
    }
  }
  if (env_.reset_lc && c.state != State::idle && c.state != State::fatal_error)
    return "a reset of the controller is obeyed from each state";
  return nullptr;
}

// Each strategy within its budget and the time of the movements that it may need.
const char* Composed::check_strategies() {
  const Supervisor::Outbox& box = supervisor_.outbox();
  for (std::uint32_t i = 0; i < box.event_count; ++i) {
    const EventRecord& e = box.events[i];
    if (e.id != static_cast<std::uint16_t>(EventId::strategy_begun)) continue;
    const auto kind = static_cast<StrategyKind>(static_cast<int>(e.argument[0]));
    // Legs that have to move: those at fault under power; move_free moves all that are at fault.
    if (!env_.solves) env_.suspects = 0;
    env_.solves = true;
    unsigned legs = 0;
    for (std::size_t m = 0; m < kModules; ++m) {
      const bool accused =
          std::ranges::any_of(supervisor_.state().faults, [&](const FaultRecord& f) {
            return f.id != FaultId::none && f.subject == m + 1 &&
                   class_of(f.id) != FaultClass::contact;
          });
      const bool away = env_.module[m].ill == Ill::silent || !env_.plugged || !env_.runs;
      if (accused) env_.suspects |= 1u << m;
      if (kind == StrategyKind::move_free && away) legs |= 1u << m;
    }
    env_.suspects |= env_.seen;
    const int moved = std::popcount(legs | env_.suspects);
    const SolverParameters& p = limits_.solver;
    env_.strategy_ns = env_.now_ns;
    env_.strategy_limit_ns = p.budget_ns + (kind == StrategyKind::cool_down ? p.cool_down_ns : 0) +
                             moved * 2 * (p.free_move_ns + 2 * kSecond) + kStep;
  }
  if (controller().state != State::solve_errors) {
    env_.strategy_ns = 0;
    env_.solves = false;
    return nullptr;
  }
  if (env_.strategy_ns == 0) return "solve begins a strategy";
  return env_.now_ns - env_.strategy_ns > env_.strategy_limit_ns ? "no endless solving" : nullptr;
}

// What is seen of a module in service is well when errors are said to be solved.
const char* Composed::check_solved() const {
  constexpr const char* kProperty = "solved is what is solved";
  if (!env_.plugged) return kProperty;
  for (std::size_t i = 0; i < kModules; ++i) {
    if ((controller().isolated >> i & 1u) != 0) continue;
    const AbstractModule& m = env_.module[i];
    const bool fresh =
        std::ranges::any_of(std::span(env_.active).first(env_.failed), [&](const Active& a) {
          return a.module == i + 1 && a.exposed_ns <= limits_.module_silent_ns;
        });
    if (m.ill == Ill::silent && !fresh) return kProperty;
    if (m.answers() && m.ill != Ill::late && (m.tripped() || m.motor_on())) return kProperty;
  }
  return nullptr;
}

void Composed::check(const lc::ControllerState& before) {
  const lc::ControllerState& c = controller();
  const char* broken = check_orders();
  if (broken == nullptr) broken = check_losses();
  if (broken == nullptr) broken = check_strategies();
  if (broken == nullptr && before.state == State::solve_errors && c.state == State::idle)
    broken = check_solved();
  // Motors of modules that obey are off outside Operational.
  bool motor = false;
  for (const AbstractModule& m : env_.module) motor = motor || (m.ill == Ill::well && m.motor_on());
  const bool may = c.state == State::operational || (c.flags & (kFreeing | kPanelMoving)) != 0 ||
                   !env_.plugged || !env_.runs;
  env_.motor_ns = motor && !may ? env_.motor_ns + kStep : 0;
  if (broken == nullptr && env_.motor_ns > AbstractModule::kRepeat + kStep)
    broken = "outside Operational motors are off";
  if (broken == nullptr && env_.now_ns - kBegin > kLongest)
    broken = "every mission comes to an end";
  if (broken != nullptr) broken_ = broken;
  if (broken != nullptr) env_.over = true;
}

// Whether a lasting failure is one of legs that can be isolated, and the others can walk.
bool Composed::can_recover() const {
  unsigned gone = controller().isolated;
  for (const Active& active : std::span(env_.active).first(env_.failed)) {
    if (!active.lasts) continue;
    if (active.module == 0) return false;
    const std::size_t i = active.module - 1u;
    // A motor that cannot be switched off, and a panel whose place is not known, need a person.
    if (i == kPanel || (env_.module[i].answers() && env_.module[i].motor_on())) return false;
    gone |= 1u << i;
  }
  return enough_legs_without(gone) && (controller().flags & kPanelOut) == 0;
}

}  // namespace lss::zebro
