// Supervision of TALARIS' calibration and flight, as they were in the last frame. In the air the
// flight reacts by itself (gnc/talaris/flight.h has the table); here its faults are reported and
// latched at once, and become an emergency after the landing.

#include "daemon/vehicles/talaris/vehicle.h"
#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

namespace g = gnc::talaris;

Reason reason_of(g::CalibrationFault fault) noexcept {
  switch (fault) {
    case g::CalibrationFault::turning:
    case g::CalibrationFault::rate_spread:
    case g::CalibrationFault::shaking:
    case g::CalibrationFault::force_spread: return reasons::moved;
    case g::CalibrationFault::imu_silent: return Reason::imu_lost;
    case g::CalibrationFault::few_ranges:
    case g::CalibrationFault::range_spread: return reasons::altimeter_lost;
    default: return reasons::calibration_bad;
  }
}

Reason reason_of(gnc::talaris::Shortfall why) noexcept {
  using gnc::talaris::Shortfall;
  switch (why) {
    case Shortfall::no_lift_off: return reasons::no_lift_off;
    case Shortfall::fallen: return reasons::fell_over;
    case Shortfall::hard: return reasons::landed_hard;
    case Shortfall::sideways: return reasons::landed_sideways;
    case Shortfall::place: return reasons::off_target;
    default: return reasons::flight_failed;
  }
}

struct FlightFault {
  gnc::talaris::Fault bit;
  FaultId id;
  std::uint16_t subject;
};
constexpr std::array kFlightFaults = {
    FlightFault{gnc::talaris::kImuLost, faults::navigation_lost, kImuModule},
    FlightFault{gnc::talaris::kAltimeterLost, faults::altitude_lost, kAltimeterModule},
    FlightFault{gnc::talaris::kValvesLost, FaultId::module_silent, kValveModule},
    FlightFault{gnc::talaris::kFansLost, FaultId::module_silent, kFanModule},
    FlightFault{gnc::talaris::kPressureLost, faults::pressure_lost, kValveModule},
    FlightFault{gnc::talaris::kGasLow, faults::gas_low, kValveModule},
    FlightFault{gnc::talaris::kUpset, faults::attitude_lost, 0},
    FlightFault{gnc::talaris::kOverruns, FaultId::frame_overrun, 0},
    FlightFault{gnc::talaris::kSpinUpFailed, faults::fan_slow, kFanModule},
    FlightFault{gnc::talaris::kRunTime, faults::fans_hot, kFanModule},
    FlightFault{gnc::talaris::kOffCourse, faults::corridor_left, 0},
    FlightFault{gnc::talaris::kGasShort, faults::hop_shortened, kValveModule},
};
constexpr gnc::talaris::FaultSet kKnown = [] {
  gnc::talaris::FaultSet set = gnc::talaris::kActuatorFailed;
  for (const FlightFault& fault : kFlightFaults) set |= fault.bit;
  return set;
}();

}  // namespace

void Vehicle::watch_calibration(Supervisor& s) noexcept {
  if (mode() != Mode::calibrate) return;
  const gnc::talaris::CalibrationStatus& c = navigation_.calibration();
  const bool lost = (s.controller().flags & kImuLost) != 0;
  if (c.phase == g::CalibrationPhase::failed || lost) {
    s.note(EventId::calibration_refused, 0, static_cast<double>(c.fault), c.measured, c.limit);
    s.abandon(lost ? Reason::imu_lost : reason_of(c.fault));
    s.happen(event::calibration_refused);
  } else if (c.phase == g::CalibrationPhase::done) {
    s.note(events::calibrated);
    s.happen(event::calibrated);
  }
}

void Vehicle::watch_flight(Supervisor& s) noexcept {
  const g::FlightOutput& f = output_;
  if (mode() != Mode::execute) return;
  if (executed_ns_ == now_ns_) {  // of the flight before; nothing else solves them
    s.clear(faults::corridor_left);
    s.clear(faults::hop_shortened, kValveModule);
  }
  if (!begun_) {  // the plan is gone: treated as over
    s.abandon(reasons::not_planned);
    s.happen(event::finished);
    return;
  }
  if (f.airborne && s.happen(event::lifted_off).reason == Reason::none) s.note(events::lifted_off);
  if (f.phase != phase_ && f.phase != gnc::talaris::Phase::none) {
    s.note(EventId::phase_changed, 0, static_cast<double>(phase_), static_cast<double>(f.phase));
    phase_ = f.phase;
  }
  if (f.reaction != reaction_) {
    reaction_ = f.reaction;
    if ((f.faults & ~faults_ & gnc::talaris::kOffCourse) != 0)
      s.note(events::off_course, 0, static_cast<double>(f.judgement.off), f.judgement.measured,
             f.judgement.limit);
    // A commanded landing is no failure.
    if (f.reaction > gnc::talaris::Reaction::land || f.faults != 0)
      s.note(EventId::contingency, 0, static_cast<double>(f.phase));
  }
  watch_faults(s);
  watch_actuators(s);
  if (f.all_stop) {
    if ((faults_ & kKnown) == 0) s.latch(FaultId::stop_not_followed);
    s.happen(lc::Event::emergency);
  } else if (f.finished) {
    s.note(events::landed, 0, f.touchdown_m_s, f.gas_used_s);
    if (f.off_target_sigma_m > 0)
      s.note(events::flight_judged, 0, f.off_target_m, f.off_target_sigma_m, f.touchdown_m_s,
             f.touchdown_side_m_s);
    const auto goal = static_cast<Goal>(s.controller().goal);
    const bool cut_short = goal == Goal::landing || goal == Goal::idle;  // by command
    if (!f.succeeded && !cut_short) s.abandon(reason_of(f.shortfall));
    s.happen(event::finished);
  }
}

// Valves and fans that failed in the air.
void Vehicle::watch_actuators(Supervisor& s) noexcept {
  using gnc::talaris::Health;
  const gnc::talaris::ActuatorVerdict& v = output_.verdict;
  if (v.health == Health::good) return;
  const FaultId id = v.health == Health::open   ? faults::valve_stuck_open
                     : v.health == Health::shut ? faults::valve_stuck_shut
                     : v.health == Health::dead ? faults::fan_dead
                                                : faults::fan_without_thrust;
  static_assert(kFirstFan == kFirstValve + static_cast<int>(gnc::talaris::kValves));
  const auto subject = static_cast<std::uint16_t>(kFirstValve + v.actuator);
  // One that was found to be free again has one failure: the last.
  if (v.health == Health::open) s.clear(faults::valve_stuck_shut, subject);
  if (v.health == Health::shut) s.clear(faults::valve_stuck_open, subject);
  s.raise(id, subject, v.measured, v.limit);
}

// On rails and sled it brakes to standstill first: the actuators must not be cut off before.
void Vehicle::watch_faults(Supervisor& s) noexcept {
  const gnc::talaris::FaultSet fresh = output_.faults & ~faults_;
  faults_ |= fresh;
  pending_ |= fresh;
  const bool ground = !s.airborne();
  if (ground && !output_.finished && !output_.all_stop) return;
  for (const FlightFault& fault : kFlightFaults) {
    if ((pending_ & fault.bit) == 0) continue;
    if (output_.all_stop) {
      s.latch(fault.id, fault.subject);
    } else {
      s.raise(fault.id, fault.subject);
    }
  }
  pending_ = 0;
}

}  // namespace lss::talaris
