#pragma once

// Flies the plan: guidance, control and reactions to failures, behind one call a frame. Called from
// the frame thread every 200 ms, also on the ground; time is data; nothing allocates; the same
// calls give the same bits. For any input, pulses and throttles are numbers within their limits.
//
//   plan() -> ready -> execute() -> spin_up ... touchdown -> landed -> (plan() again)
//
// Contingencies: the worst reaction wins and stays (only hold ends by itself). In flight:
//
//   fault                                 | reaction
//   IMU silent for <= imu_hold_s          | hold: goes on by dead reckoning
//   IMU silent for longer                 | parachute without attitude: valves shut, fans alike
//   altimeter silent > range_age_s        | escape; blind end at blind_m_s, contact by acceleration
//   valve node silent, gas pressure gone  | parachute
//   fan node silent                       | escape with all lift that the gas has
//   gas left < what landing takes + half the reserve | escape
//   frame overruns (two in a row)         | escape
//   tilt or rate above the limits         | parachute; escape when the fans are lost
//   fans run for max_run_s                | escape; 10 s later parachute, at level_m_s; 15 s later
//                                         | ever less lift while it does not sink; 40 s: all-stop
//   a valve or a fan failed               | escape by all actuators that are left (allocation.h)
//   corridor left, wind too strong        | land (corridor.h)
//   gas left < what the plan still takes  | shorten: it stops, then descends
//   far off the plan, with gas to go on   | hold: waits in the traverse until it is back
//   valves and fans, IMU and fans         | all-stop: nothing is left to do
//   land()                                | controlled descent, here
//
// On the ground, on rails or sled: IMU or valve loss, tilt: all-stop; altimeter, gas, overruns,
// land(): brake to standstill, end. Needed parts only: a program without fans ignores them.

#include "gnc/talaris/actuator_watch.h"
#include "gnc/talaris/altitude.h"
#include "gnc/talaris/control.h"
#include "gnc/talaris/corridor.h"
#include "gnc/talaris/fans.h"
#include "gnc/talaris/gas.h"
#include "gnc/talaris/guidance.h"
#include "gnc/talaris/parameters.h"
#include "gnc/talaris/plan.h"
#include "gnc/talaris/touchdown.h"
#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

// Numbers as in telemetry.
enum class Phase : std::uint8_t {
  none,     // nothing planned
  ready,    // planned, on the ground
  spin_up,  // fans come to their speed
  ascend,
  hover,
  traverse,
  brake,  // comes to standstill after the traverse
  descend,
  touchdown,  // contact: valves shut, fans run down
  landed,     // the end, also of programs on the ground
  hold,
  escape,
  parachute,
  turn,
  keep,
};

// Bits of a set; faults of the caller and of Flight are combined.
enum Fault : std::uint32_t {
  kImuLost = 1U << 0,
  kAltimeterLost = 1U << 1,
  kValvesLost = 1U << 2,
  kFansLost = 1U << 3,
  kPressureLost = 1U << 4,
  kGasLow = 1U << 5,
  kUpset = 1U << 6,     // tilt or rates
  kOverruns = 1U << 7,  // frames: only the caller knows
  kSpinUpFailed = 1U << 8,
  kRunTime = 1U << 9,          // fans run for too long
  kImuGap = 1U << 10,          // short; cleared when packets of the IMU come again
  kOffCourse = 1U << 11,       // the corridor was left
  kOffTrack = 1U << 12,        // far off the plan; cleared when it is back
  kGasShort = 1U << 13,        // not enough for the rest of the plan
  kOverTime = 1U << 14,        // fans run much too long
  kActuatorFailed = 1U << 15,  // a valve or a fan: FlightOutput::health
};
using FaultSet = std::uint32_t;

// In order of severity.
enum class Reaction : std::uint8_t { none, hold, shorten, land, escape, parachute, all_stop };

// Why a flight did not succeed.
enum class Shortfall : std::uint8_t {
  none,
  cut_short,    // by a reaction or a command
  unsettled,    // a turn or a place was not reached
  no_lift_off,  // it stood when it should fly
  fallen,       // tilted at the end
  hard,         // too fast down at touchdown
  sideways,     // too fast sideways at touchdown
  place,        // too far from the target, with 3 sigma
};

// The contingency table; pure. `flying`: off the ground, or about to be; `fans`, `gas`: the program
// uses them.
Reaction react(FaultSet faults, bool flying, bool fans, bool gas) noexcept;

struct FlightInputs {
  std::int64_t time_ns = 0;  // T_k
  NavState nav;              // valid false: no packet of the IMU in this frame
  double range_m = kNaN;     // last good reading of the altimeter
  // s since the last good message of each at T_k
  double imu_age_s = 1e9;
  double range_age_s = 1e9;
  double valve_age_s = 1e9;
  double fan_age_s = 1e9;
  std::array<double, kFans> rpm{};
  double tank_kPa = kNaN;  // NaN: no sensor, ignored
  double regulated_kPa = kNaN;
  bool contact = false;  // on the way down: the ground carries (contact.h)
  bool shock = false;    // and just now: a shock
  bool jolt = false;     // or one foot that turned it
  bool unheard = false;  // the last orders may not have reached valves and fans
  FaultSet faults = 0;   // known to the caller, now
};

struct FlightOutput {
  Actuation actuation;  // value-initialised: everything shut, fans off
  Phase phase = Phase::none;
  Reaction reaction = Reaction::none;
  FaultSet faults = 0;                    // since execute()
  bool airborne = false;                  // a fault must not cut the actuators off
  bool finished = false;                  // landed, valves shut, fans off
  bool succeeded = false;                 // and as planned: Shortfall::none
  bool stands = false;                    // on the ground and still: its velocity is zero
  bool still = false;                     // no motion in the last two frames
  Shortfall shortfall = Shortfall::none;  // once finished
  Judgement judgement;                    // of the corridor, that ended the flight
  double off_target_m = 0;                // at the end, by navigation
  double off_target_sigma_m = 0;
  double touchdown_m_s = 0;  // down, and
  double touchdown_side_m_s = 0;
  bool all_stop = false;                   // the caller shall stop everything at once
  double phase_s = 0;                      // since the phase began
  Vector3 target_N_m = Vector3::Zero();    // target of guidance, also after the end
  Vector3 target_N_m_s = Vector3::Zero();  // and the target velocity
  double target_roll_rad = 0;
  double height_m = 0;                           // used by the flight
  Vector3 attitude_error_rad = Vector3::Zero();  // about the axes of B, at the centre of the pulses
  Vector3 force_N = Vector3::Zero();             // requested from cold gas, along the axes of N
  double lift_m_s2 = 0;  // expected of fans and lift valves in the frame that just ended
  std::array<double, kFans> rpm_target{};
  Healths health{};         // of valves and fans, since execute()
  ActuatorVerdict verdict;  // a new one, in this frame
  double suspicion = 0;     // of a failed actuator, as a share of what condemns it
  double gas_used_s = 0;    // thruster-seconds since full tanks
  double gas_left_s = 0;    // the lower one by pulses and by pressure
  double gas_needed_s = 0;  // to the planned end from here
};

class Flight {
 public:
  // Parameters must have passed check().
  explicit Flight(const Parameters& parameters = {}) noexcept;

  // Set 1..gain_sets; false while something is flown, or there is no such set.
  bool select_gains(std::size_t set) noexcept;
  std::size_t gains() const noexcept { return set_ + 1; }
  // Limits, profile, reserves, times and gains, from now on; body, thrusters and abilities of the
  // fans stay as constructed. They must have passed check(). The plan is dropped. False while
  // something is flown, and nothing changes.
  bool configure(const Parameters& parameters) noexcept;
  // Keeps the plan when it is feasible; while something is flown: Guard::request, nothing changes.
  PlanResult plan(const PlanRequest& request) noexcept;
  void drop_plan() noexcept;  // on the ground only
  // From the next step() on; false: nothing planned. Takes place and attitude from that step.
  bool execute() noexcept;
  void land() noexcept;          // flying: down, here; else ends
  void all_stop() noexcept;      // everything shut and off, now; the next step() says so, too
  bool active() const noexcept;  // something is flown

  FlightOutput step(const FlightInputs& inputs) noexcept;

  // Opening times in the last frame by others (manual, duty cycle, script), s each.
  void count_gas(const std::array<double, kValves>& open_s) noexcept;
  void refuel() noexcept { gas_.refuel(); }  // tanks were filled
  const GasBudget& gas() const noexcept { return gas_; }
  const Plan& planned() const noexcept { return plan_; }
  const Parameters& parameters() const noexcept { return parameters_; }

 private:
  // At the end (flight_judge.cpp).
  void watch_corridor() noexcept;
  void note_contact() noexcept;
  void note_touchdown() noexcept;
  double falls_m_s() const noexcept;
  void judge_landing() noexcept;
  void fall_short(Shortfall why) noexcept;

  // The stages of step().
  void take_state(const FlightInputs& inputs) noexcept;
  FaultSet find_faults(const FlightInputs& inputs) const noexcept;
  void respond(Reaction reaction) noexcept;
  void advance(const FlightInputs& inputs) noexcept;
  void advance_in_air() noexcept;
  void advance_on_ground() noexcept;
  void next_leg() noexcept;
  void turn_or_go() noexcept;  // the turn of the plan first, when it has one
  void resume() noexcept;
  void act(const FlightInputs& inputs, FlightOutput& output) noexcept;
  void act_gas(FlightOutput& output) noexcept;
  void trim_fans() noexcept;
  void trim_moments() noexcept;
  void yield_fans(double later_m_s2) noexcept;
  void act_fans(const FlightInputs& inputs, FlightOutput& output) noexcept;
  // flight_failed.cpp
  void watch_actuators(const FlightInputs& inputs) noexcept;
  void act_allocated(const FlightInputs& inputs, FlightOutput& output) noexcept;
  bool allocates() const noexcept;
  std::array<double, kValves> open_in_frame_s() const noexcept;
  void fly_by_fans(const FlightInputs& inputs, FlightOutput& output) noexcept;

  void enter(Phase phase) noexcept;
  void leave_ground() noexcept;
  void begin_leg() noexcept;  // traverse, from its planned position
  void descend_to(const Vector3& place_m) noexcept;
  void come_down(double peak_m_s2, double end_speed_m_s, double end_height_m) noexcept;
  void stop_here() noexcept;  // guidance: comes to standstill sideways
  bool touches(const FlightInputs& inputs) noexcept;
  void observe(const PerFan& rpm) noexcept;
  void observe_wind(double lift_N, double mass_kg) noexcept;
  double ground_due_s() const noexcept;
  bool brakes() const noexcept;  // parachute: sideways first, height is kept
  bool turned() noexcept;
  void wait_for_calm() noexcept;
  bool by_fans() const noexcept;
  bool rests() const noexcept;
  double leg_left_s(const Vector3& from_m) const noexcept;
  double after_traverse_s() const noexcept;
  double hold_gas_s() const noexcept;
  double needed_gas_s() const noexcept;
  double landing_gas_s() const noexcept;
  bool imu_usable() const noexcept { return (faults_ & kImuLost) == 0; }
  const Gains& gain() const noexcept { return parameters_.gains[set_]; }

  Parameters parameters_;
  std::size_t set_ = 0;
  Plan plan_;
  GasBudget gas_;
  Guidance guidance_;
  Control control_;
  FanSpeed fan_speed_;
  FanFlight fan_flight_;

  Phase phase_ = Phase::none;
  double phase_s_ = 0, flown_s_ = 0, fans_s_ = 0;
  Reaction reaction_ = Reaction::none;
  FaultSet faults_ = 0;
  bool airborne_ = false, begun_ = false, stopped_ = false, settled_ = true;
  double settle_s_ = 0;

  // its start, and the leg in progress
  Vector3 start_m_ = Vector3::Zero(), leg_m_ = Vector3::Zero();
  double start_roll_rad_ = 0, roll_rad_ = 0, start_range_m_ = kNaN;
  bool start_known_ = false;

  // the state in use: navigation's, extrapolated while the IMU is silent
  NavState state_;
  double silent_s_ = 0;
  double height_m_ = 0, climb_m_s_ = 0;  // by navigation, or by the altimeter alone
  double range_height_m_ = kNaN, range_climb_m_s_ = 0, range_ahead_s_ = 0;

  // expected and actual values of the last frames
  double lift_N_ = 0, lift_before_N_ = 0, expected_m_s2_ = 0, bias_m_s2_ = 0;
  bool observed_ = false;                  // the bias, in this flight
  double fans_N_ = 0, fans_before_N_ = 0;  // thrust of the fans, now and a frame ago
  double fan_height_m_ = 0;                // commanded, of a flight by fans
  double fan_goal_rpm_ = 0;
  double fan_trim_N_ = 0;   // more than planned, so that the valves have their share of the weight
  double fan_yield_N_ = 0;  // never positive: for what the shortest pulses cannot leave out
  double fan_yield_step_N_ = 0;         // its change, in this frame
  double fan_y_Nm_ = 0, fan_z_Nm_ = 0;  // moments of unequal speeds, against what turns it
  int low_frames_ = 0, contact_frames_ = 0;
  double below_s_ = 0;  // since contact was due; negative: until then
  Touchdown touchdown_;
  double fan_probe_N_ = 0;               // lift taken away to feel the ground
  double weak_s_ = 0;                    // over time, and not sinking
  double more_m_s2_ = 0;                 // upwards, more than lift explains, in the last frame
  double impact_m_s_ = 0;                // the most of it in two frames on the way down
  bool impacted_ = false;                // by a shock that took its speed: on the ground, or nearly
  bool heard_ = false;                   // the state of this frame is measured
  Vector3 wind_m_s2_ = Vector3::Zero();  // horizontal acceleration that nothing explains, N
  double lean_y_rad_ = 0, lean_z_rad_ = 0;  // commanded

  // Valves and fans: what they did, and which failed
  ActuatorWatch watch_;
  std::array<Pulse, kValves> fired_{}, fired_before_{};  // of the last two frames
  Vector3 rate_before_B_rad_s_ = Vector3::Zero();
  PerFan rpm_before_{};
  std::int64_t watched_ns_ = 0;
  bool known_before_ = false;
  bool inputs_unheard_ = false;

  // The corridor, and how it ended
  Corridor corridor_;
  Judgement judgement_, now_judged_;
  Vector3 goal_m_ = Vector3::Zero();  // where it should stand in the end, of height nothing
  double traverse_s_ = 0, brake_s_ = 0, extra_s_ = 0;
  int holds_ = 0;
  bool waits_ = false;  // for calm, near the ground
  double waited_s_ = 0;
  Shortfall shortfall_ = Shortfall::none;
  double off_m_ = 0, off_sigma_m_ = 0;
  // Of the velocity in a frame, axis by axis, and of a foot's speed down.
  struct Swing {
    Vector3 least_m_s = Vector3::Zero(), most_m_s = Vector3::Zero();
    double foot_down_m_s = 0;
  };
  Swing swing() const noexcept {
    return {state_.velocity_least_N_m_s, state_.velocity_most_N_m_s, state_.foot_down_m_s};
  }
  // Of the two frames before this one, before the impact, and before contact was seen.
  struct Speed {
    Vector3 N_m_s = Vector3::Zero();
    // By which all, and one of the feet, may come down faster within the next frame.
    double falls_m_s = 0, foot_m_s = 0;
    Swing in_frame{};
  };
  using Speeds = std::array<Speed, 2>;
  Speeds before_{}, before_impact_{}, before_contact_{};
  std::array<Swing, 16> after_contact_{};  // from the frame of the contact until it stood
  std::size_t moved_frames_ = 0;
  bool speed_noted_ = false;
  double touchdown_m_s_ = 0, touchdown_side_m_s_ = 0;
};

}  // namespace lss::gnc::talaris
