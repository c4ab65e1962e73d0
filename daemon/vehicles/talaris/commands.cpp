// Commands of TALARIS: the checks of the vehicle, and the actions.

#include <bit>

#include "daemon/vehicles/talaris/vehicle.h"
#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

namespace g = gnc::talaris;

Reason reason_of(g::Guard guard) noexcept {
  switch (guard) {
    case g::Guard::none: return Reason::none;
    case g::Guard::request: return reasons::plan_request;
    case g::Guard::height: return reasons::plan_height;
    case g::Guard::gas: return reasons::gas_short;
    case g::Guard::hover_on_time: return reasons::hover_short;
    case g::Guard::climb: return reasons::climb_short;
    case g::Guard::lateral: return reasons::lateral_short;
    case g::Guard::altimeter: return reasons::altimeter_short;
    case g::Guard::wall: return reasons::wall_near;
    case g::Guard::fan_thrust: return reasons::fans_short;
    case g::Guard::run_time: return reasons::fans_long;
  }
  return reasons::plan_request;
}

Verdict verdict_of(const g::PlanResult& result) noexcept {
  if (result.feasible()) return {};
  return {.reason = reason_of(result.guard), .measured = result.measured, .limit = result.limit};
}

}  // namespace

// ---- consider

Verdict Vehicle::consider(const Request& r) noexcept {
  if (r.kind == kind_of(lss::CommandKind::reset)) {
    if (supervisor_ != nullptr && supervisor_->airborne()) return {.reason = reasons::in_flight};
    if (arguments<Reset>(r).module == kAltimeterModule)  // it has no state to clear
      return {.reason = Reason::not_a_choice, .measured = kAltimeterModule, .subject = 0};
    return {};
  }
  switch (static_cast<CommandKind>(r.kind)) {
    case CommandKind::valve: {
      const auto valve = arguments<OpenValves>(r);
      return valve.open ? consider_valves(valve.valves) : Verdict{};
    }
    case CommandKind::pulse: {
      const auto pulse = arguments<DutyCycle>(r);
      const double end_s = pulse.on_s + pulse.delay_s;
      if (end_s > gnc::talaris::kFrame_s + 1e-9)
        return {
            .reason = reasons::pulse_too_long, .measured = end_s, .limit = gnc::talaris::kFrame_s};
      const double pause_s = gnc::talaris::kFrame_s - pulse.on_s;  // from frame to frame
      if (pulse.frames > 1 && pause_s > 1e-9 && pause_s < kMinPulse_s - 1e-9)
        return {.reason = reasons::pause_too_short, .measured = pause_s, .limit = kMinPulse_s};
      return consider_valves(pulse.valves);
    }
    case CommandKind::gnc:
      return arguments<Gnc>(r).step == GncStep::execute ? consider_execute() : Verdict{};
    case CommandKind::plan:
      return verdict_of(
          gnc::talaris::make_plan(plan_request(r), parameters_.flight, flight_.gas().left_s()));
    case CommandKind::gains: {
      const unsigned set = arguments<SelectGains>(r).set;
      if (set <= parameters_.flight.gain_sets) return {};
      return {.reason = reasons::no_such_gains,
              .measured = static_cast<double>(set),
              .limit = static_cast<double>(parameters_.flight.gain_sets)};
    }
    case CommandKind::script_step: return script_.consider_step(r);
    case CommandKind::script_run: {
      if (const Verdict v = script_.consider_run(arguments<ScriptRun>(r).id);
          v.reason != Reason::none)
        return v;
      const bool armed =
          supervisor_ != nullptr && (supervisor_->controller().flags & kFansArmed) != 0;
      if (script_.uses_fans() && !armed)
        return {.reason = reasons::fans_not_armed, .subject = kFanModule};
      return consider_valves(script_.valves());
    }
    default: return {};
  }
}

// The first valve that is wanted and disabled.
Verdict Vehicle::consider_valves(std::uint8_t valves) const noexcept {
  const unsigned disabled = valves & ~static_cast<unsigned>(enabled_);
  if (disabled == 0) return {};
  return {.reason = reasons::valve_disabled,
          .measured = static_cast<double>(std::countr_zero(disabled) + 1),
          .limit = kRequired,
          .subject = kValveModule};
}

// Conditions that may have changed since planning.
Verdict Vehicle::consider_execute() const noexcept {
  const gnc::talaris::Plan& plan = flight_.planned();
  const std::uint8_t flags = supervisor_ != nullptr ? supervisor_->controller().flags : 0;
  if (sensors_.imu_test_failed())
    return {.reason = reasons::imu_test_failed, .subject = kImuModule};
  if (plan.needs_altimeter && ((flags & kAltimeterLost) || navigation_.range_doubted()))
    return {.reason = reasons::altimeter_lost, .subject = kAltimeterModule};
  if (plan.uses_fans && !(flags & kFansArmed))
    return {.reason = reasons::fans_not_armed, .subject = kFanModule};
  if (plan.uses_gas) {
    if (const Verdict v = consider_valves(0xFF); v.reason != Reason::none) return v;
    const double least_kPa = parameters_.flight.gas.min_regulated_kPa;
    if (sensors_.regulated_kPa() < least_kPa)
      return {.reason = reasons::pressure_low,
              .measured = sensors_.regulated_kPa(),
              .limit = least_kPa,
              .subject = kValveModule};
  }
  if (parameters_.min_voltage_V > 0 && sensors_.gas().voltage_V < parameters_.min_voltage_V)
    return {.reason = reasons::voltage_low,
            .measured = sensors_.gas().voltage_V,
            .limit = parameters_.min_voltage_V,
            .subject = kValveModule};
  return verdict_of(
      gnc::talaris::make_plan(plan.request, parameters_.flight, flight_.gas().left_s()));
}

g::PlanRequest Vehicle::plan_request(const Request& r) const noexcept {
  const auto wanted = arguments<PlanFlight>(r);
  g::PlanRequest plan;
  plan.program = static_cast<gnc::talaris::Program>(wanted.program);
  plan.height_m = wanted.height_m;
  plan.distance_m = wanted.distance_m;
  plan.turn_rad = wanted.turn_rad;
  plan.time_s = wanted.time_s;
  const bool wall = parameters_.navigation.pointing == gnc::talaris::Pointing::sideways;
  if (wall && !sensors_.altimeter_lost()) plan.range_m = sensors_.range_m();
  return plan;
}

// ---- act

void Vehicle::act(lc::ActionSet actions, const Request* request) noexcept {
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff | kShut)) {
    if (actions & lc::kEmergencyStop) end_script();
    script_.end();
    hand_.shut();
    if (flight_.active()) flight_.all_stop();
    gate_failed_ = 0;
  }
  if (actions & lc::kEndSolve) solver_.end();
  if (actions & lc::kPublishData) data_requested_ = true;
  if (actions & (kGncOff | kCalibrate)) navigation_.begin_calibration();
  if (actions & kCalibrate) sensors_.forget_difference();
  if (actions & kLand) flight_.land();
  if (actions & kExecute) {
    output_ = {};
    phase_ = gnc::talaris::Phase::ready;
    reaction_ = gnc::talaris::Reaction::none;
    faults_ = pending_ = 0;
    executed_ns_ = now_ns_;
    begun_ = flight_.execute();
  }
  if (actions & kArm) hand_.arm();
  if (actions & kRunScript) {
    script_.run();
    script_told_ = 0;
    tell(events::script_begun, script_.id(), script_.steps(), kScriptLead_s);
  }
  if (request == nullptr) return;
  if (actions & lc::kResetModule) {
    const int number = arguments<Reset>(*request).module;
    constexpr unsigned kNodes = 0b11100;
    const unsigned modules = number == 0 ? kNodes : 1u << (number - 1);
    reset_modules(static_cast<std::uint16_t>(modules));
    for (std::size_t i = 0; i < kHopperNodes; ++i) {
      const std::size_t module = kValveModule - 1 + i;
      const bool there = i != kLoadCellNode || parameters_.buses.can.load_cell;
      if (there && (modules >> module & 1u) != 0)
        resets_.begin(module, now_ns_, link(i).node.boots);
    }
  }
  carry_out(*request);
  // Its completion is checked at once.
  if (supervisor_ != nullptr) tell_sense(*supervisor_);
}

void Vehicle::carry_out(const Request& r) noexcept {
  if (r.kind == kind_of(lss::CommandKind::start)) {
    const double full_kPa = parameters_.flight.gas.full_kPa;
    if (sensors_.tank_kPa() >= parameters_.refuelled * full_kPa) flight_.refuel();
    return;
  }
  switch (static_cast<CommandKind>(r.kind)) {
    case CommandKind::valve: {
      const auto valve = arguments<OpenValves>(r);
      return hand_.valve(valve.valves, valve.open, valve.time_s);
    }
    case CommandKind::pulse: {
      const auto pulse = arguments<DutyCycle>(r);
      return hand_.pulse(pulse.valves, pulse.on_s, pulse.delay_s, pulse.frames);
    }
    case CommandKind::enable:
      enabled_ = arguments<EnableValves>(r).valves;
      return hand_.limit(enabled_);
    case CommandKind::edf_throttle: {
      const auto fan = arguments<FanThrottle>(r);
      return hand_.throttle(fan.fans, fan.throttle);
    }
    case CommandKind::edf_rpm: {
      const auto fan = arguments<FanSpeed>(r);
      return hand_.rpm(fan.fans, fan.rpm, fan.ramp_rpm_s);
    }
    case CommandKind::plan: return plan(r);
    case CommandKind::gains: {
      const unsigned set = arguments<SelectGains>(r).set;
      flight_.select_gains(set);
      hand_.set_gains(parameters_.flight.gains[set - 1]);
      tell(events::gains_selected, set);
      return;
    }
    case CommandKind::script_begin: return script_.begin(r);
    case CommandKind::script_step: return script_.add(r);
    default: return;
  }
}

void Vehicle::plan(const Request& r) noexcept {
  const g::PlanResult result = flight_.plan(plan_request(r));
  program_ = static_cast<std::uint8_t>(arguments<PlanFlight>(r).program);
  tell(EventId::planned, program_, result.plan.total_s, result.plan.gas_s, flight_.gas().left_s());
}

void Vehicle::tell(EventId id, double a, double b, double c, double d) const noexcept {
  if (supervisor_ != nullptr) supervisor_->note(id, 0, a, b, c, d);
}

// An emergency ends a running script.
void Vehicle::end_script() noexcept {
  if (script_.running())
    tell(events::script_aborted, script_.id(), script_.done(), script_.steps());
}

}  // namespace lss::talaris
