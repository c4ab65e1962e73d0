#pragma once

// One frame of error solving, the same for every vehicle: its strategies one after the other, as
// far as the locomotion controller agrees, with their events. A vehicle has its own Solver with
// kind(), running() and Report. Frame thread.

#include "daemon/cycle/supervisor.h"

namespace lss {

// Each latched fault that is an emergency.
template <class Each>
void each_fatal(const Supervisor& s, Each&& each) {
  for (const FaultRecord& fault : s.state().faults) {
    if (fault.id != FaultId::none &&
        info(fault.id)->severity == static_cast<std::uint8_t>(Severity::fatal))
      each(fault);
  }
}

// begin(): fills the solver with the present faults. step(): one frame of it; its report.
template <class Solver, class Begin, class Step>
void solve_errors(Supervisor& s, Solver& solver, Begin&& begin, Step&& step) noexcept {
  const auto tell_begin = [&] {
    s.note(EventId::strategy_begun, 0, static_cast<double>(solver.kind()));
  };
  if (!solver.running()) {
    begin();
    tell_begin();
  }
  using Report = typename Solver::Report;
  const auto tried = solver.kind();
  Report report = step();
  if (report == Report::running) return;
  s.note(EventId::strategy_ended, 0, static_cast<double>(tried), report == Report::solved ? 1 : 0);
  if (report == Report::next) {
    if (s.happen(lc::Event::next_strategy).reason == Reason::none) {
      tell_begin();
      return;
    }
    report = Report::unsolved;
  }
  const bool solved =
      report == Report::solved && s.happen(lc::Event::solved).reason == Reason::none;
  if (!solved) s.happen(lc::Event::unsolved);
  s.note(EventId::solve_ended, 0, s.state().fault_count);
}

}  // namespace lss
