#pragma once

// The locomotion algorithm of Lunar Zebro behind one small interface (Zebro thesis [Conf-2]): six
// legs, their measured angles and the time in; target angle and time of each leg out. Replaceable
// without changes elsewhere. Called from the frame thread; nothing allocates after construction;
// time is data; the same calls give the same bits.
//
// Frames: body x forward, y left, z up. Leg angle theta: 0 = straight down, positive = toe ahead of
// the hip; walking forward turns theta downwards. Legs 0..5 = LF, RF, LM, RM, LH, RH.

#include <array>
#include <cstdint>

#include "gnc/zebro/dragging.h"
#include "gnc/zebro/fewer_legs.h"
#include "gnc/zebro/gait.h"
#include "gnc/zebro/leg.h"
#include "gnc/zebro/rowing.h"
#include "gnc/zebro/schedule.h"

namespace lss::gnc::zebro {

// low: wave, medium: tetrapod-B, high: tripod; with legs out of service see fewer_legs.h, rowing.h.
enum class Speed : std::uint8_t { zero, low, medium, high };

struct LocomotionParameters {
  // gait
  double flight_s = 3.0;                             // tau_f
  double stance_min_s = 3.3;                         // tau_g
  double double_stance_s = 0.3;                      // tau_Delta
  double sweep_rad = 0.6981317007977318;             // phi, 40 deg
  double offset_rad = 0.0;                           // theta_0
  double start_delay_s = 0.5;                        // from walk to the first lift-off
  Coordination coordination = Coordination::groups;  // with legs out of service always by groups
  // stand, lie, stow
  double stand_up_s = 3.0;
  double lay_down_s = 3.0;
  double lift_s = 3.0;   // legs through the air to where the belly carries
  double align_s = 1.0;  // all legs in stance to straight down
  // geometry
  double leg_diameter_m = 0.053;
  double track_m = 0.130;
  double belly_height_m = 0.025;  // hip above ground when lying
  HipGeometry hips{};             // from the centre of mass
  // limits
  double swing_limit_rad_s = 2.0943951023931953;  // 120 deg/s, gearbox
  double arrived_rad = 0.05;                      // a leg this close to its target has arrived
  double late_limit_s = 5.0;                      // a primitive this late has failed
};

// nullptr when usable, else a sentence about the error (unsynchronised gait, swing too fast, ...),
// valid until the next call on this thread. Before the loop starts.
const char* check(const LocomotionParameters& parameters) noexcept;

// Is there a way to walk without these legs (bit i = leg i), by creeping or rowing? At most two;
// docs/gait-zebro.md lists the sets.
bool can_walk_without(LegSet isolated, const LocomotionParameters& parameters = {}) noexcept;

struct WalkRequest {
  double direction = 1;    // +1 forward, -1 backward
  double heading_rad = 0;  // [-pi/2, pi/2], clockwise positive; pi/2 turns on the spot
  Speed speed = Speed::medium;
  // By rowing (rowing.h), which also gets on where the belly lies in the soil. Walking, it changes
  // after the step, rowing after the stroke. Ignored with legs out of service, whose gait depends
  // on which they are.
  bool rows = false;
};

struct LegMeasured {
  double angle_rad = 0;  // theta, any multiple of 2 pi
  bool known = false;    // received recently
  bool calibrated = false;
};

// Present target of a leg. A new `segment` is a new movement; unchanged means go on.
struct LegTarget {
  double angle_rad = 0;  // theta at arrival, (-pi, pi]
  double arrive_s = 0;   // same clock as now_s
  // +1 robot-forward (theta falls), -1 backward, 0 no order (never was, or hold).
  std::int8_t rotation = 0;
  std::uint32_t segment = 0;
  bool swing = false;  // in flight
};

enum class Motion : std::uint8_t { hold, stand_up, walk, finish_step, lay_down, stow };
enum class Progress : std::uint8_t { running, done, failed };

class Locomotion {
 public:
  // Parameters must have passed check().
  explicit Locomotion(const LocomotionParameters& parameters) noexcept;

  // Begin a motion; it takes effect with the next update(). Legal at any time (swings in the air
  // come down first); the locomotion controller decides what is allowed. hold: no movement and no
  // order, rotation 0. stand_up: turns uncalibrated legs until they pass their sensor or once
  // round, puts all legs where the belly carries, then pushes the body up; a standing robot only
  // aligns its legs. lay_down, stow: the way back, to the same posture; lost legs are searched
  // first, unless the robot stands on them. finish_step: no new swing, all legs to straight down.
  // walk while walking: the gait changes with the next cycle, by the guarded switching cycle, at
  // most once per cycle; heading and direction leg by leg with the next swing; where a side
  // reverses, the step is finished first; rowing, all of it with the next stroke. walk at speed
  // zero: finish_step, then done.
  void hold(double now_s) noexcept;
  void stand_up(double now_s) noexcept;
  void walk(double now_s, const WalkRequest& request) noexcept;
  void finish_step(double now_s) noexcept;
  void lay_down(double now_s) noexcept;
  void stow(double now_s) noexcept;

  // Exactly these legs are out of service: they are never ordered, nothing waits for them, and
  // their angles are ignored. Their gears keep them in place; the caller has to know that they are
  // clear of the ground. Only while no motion runs, at most two legs; else false, and nothing
  // changes. Without legs that can_walk_without() refuses, walk fails at once and the other motions
  // still do what they can.
  bool isolate(LegSet legs) noexcept;
  LegSet isolated() const noexcept { return isolated_; }

  // Other times, speeds and limits, from the next motion on; geometry, sweep and offset stay as
  // constructed. They must have passed check(). Only while no motion runs; else false, and nothing
  // changes.
  bool configure(const LocomotionParameters& parameters) noexcept;

  // Once per frame. Targets are for segments that began at or before now_s.
  void update(double now_s, const std::array<LegMeasured, kLegs>& measured) noexcept;

  const std::array<LegTarget, kLegs>& targets() const noexcept { return targets_; }
  Motion motion() const noexcept { return motion_; }
  Progress progress() const noexcept { return progress_; }
  // Legs that made the motion fail: they did not arrive. 0: another reason.
  LegSet late() const noexcept { return late_; }

  // Dead reckoning since construction or reset_odometry(): along the body, yaw clockwise positive.
  // Legs out of service count where they were last known to be: on the ground they drag. Standing
  // up rolls the body ahead, lying down rolls it back; turning on the spot slips, and is
  // overestimated.
  double distance_m() const noexcept { return distance_m_; }
  double yaw_rad() const noexcept { return yaw_rad_; }
  double speed_m_s() const noexcept { return speed_m_s_; }
  std::uint32_t steps() const noexcept { return steps_; }
  const WalkRequest& walking() const noexcept { return request_; }
  bool rows() const noexcept { return rows_; }  // instead of stepping, when it walks
  void reset_odometry() noexcept;

 private:
  // A motion is a few stages, one after the other; each but `step` ends when all legs it ordered
  // have arrived.
  enum class Stage : std::uint8_t {
    rest,       // no movement
    decide,     // choose the first stage from the angles of the legs
    land,       // swings in the air come down as planned, nothing lifts off; to decide
    calibrate,  // uncalibrated legs look for their sensor (Search); to decide
    align,      // all legs to straight down; next: rest, lower, step
    lift,       // all legs through the air to where the belly carries; next: rest, push
    push,       // all legs together to straight down, the body rises; next: rest
    lower,      // the way back, the body goes down; next: rest
    sink,       // rowing: all legs together on to the end of their stroke; to lift
    step,       // walking; to land
  };
  // How legs without a reference search their sensor, at the top. Stowed legs find it on a short
  // way back through the air, without moving the body; the others make a full turn.
  enum class Search : std::uint8_t { back, first_tripod, second_tripod };
  struct Leg {
    // the present movement, theta unwrapped: from at start_s, to at the target's arrive_s
    double from_rad = 0;
    double to_rad = 0;
    double start_s = 0;
    bool ordered = false;  // by the present stage
    // measured
    bool known = false;
    bool calibrated = false;  // as last reported
    bool usable = false;      // known and calibrated
    double measured_rad = 0;
    double estimate_rad = 0;  // measured when usable, else expected
    double hangs_rad = kPi;   // where it was usable last; never: clear of the ground
    // walking
    double half_sweep_rad = 0;  // signed; of the present or next stance
    double top_s = 0;  // a swing of nearly a full turn is ordered in two halves; 0: no half to come
    double top_to_rad = 0;
    bool lifted = false;  // in the current cycle
    bool landed = false;
    bool late = false;
    // calibrating
    bool searching = false;
    std::uint8_t turns_left = 0;
  };

  void begin(Motion motion) noexcept;
  void sense(double now_s, const std::array<LegMeasured, kLegs>& measured) noexcept;
  void dead_reckon(double now_s, const PerLeg<double>& last_rad,
                   const PerLeg<bool>& comparable) noexcept;
  Moved drag(double elapsed_s, const PerLeg<double>& last_rad,
             const PerLeg<bool>& comparable) noexcept;
  void reckon(const Moved& moved, double elapsed_s) noexcept;

  void order_again(std::size_t leg) noexcept;
  void fail(LegSet late) noexcept;

  bool in_service(std::size_t leg) const noexcept { return !contains(isolated_, leg); }
  bool walks() const noexcept { return motion_ == Motion::walk && request_.speed != Speed::zero; }
  bool run_stage(double now_s) noexcept;
  Stage first_stage() const noexcept;
  Stage stage_after(Stage stage) const noexcept;
  void enter(Stage stage, double now_s) noexcept;
  void move_together(double now_s) noexcept;
  double travel_rad(std::size_t leg) const noexcept;
  bool ordered_legs_arrived(double now_s) noexcept;
  bool upright() const noexcept;
  void begin_calibration(double now_s) noexcept;
  bool calibration_over(double now_s) noexcept;
  void turn_on(std::size_t leg, double now_s) noexcept;
  void turn(std::size_t leg, double way_rad, double now_s) noexcept;

  void choose_rowing() noexcept;
  void begin_rowing() noexcept;
  void choose_strokes() noexcept;
  Stroke stroke_of(std::size_t leg) const noexcept;
  double swing_to_stroke_rad(std::size_t leg) const noexcept;
  double rowing_slowness() const noexcept;

  bool choose_gait() noexcept;
  bool gait_stays(const SideSpeeds& wanted) const noexcept;
  Roll roll_of(const SideSpeeds& sides) const noexcept;
  void begin_stepping(double now_s) noexcept;
  void step(double now_s) noexcept;
  void change_walk() noexcept;
  void push_off() noexcept;
  double end_of_first_cycle_rad(std::size_t leg) const noexcept;
  double touchdown_rad(std::size_t leg) const noexcept;
  bool next_cycle_begins(double now_s) const noexcept;
  void begin_next_cycle(double now_s) noexcept;
  void lift_off(std::size_t leg) noexcept;
  void swing(std::size_t leg, double from_rad, double to_rad, double start_s,
             double arrive_s) noexcept;
  bool swing_over(std::size_t leg, double now_s) noexcept;
  void touch_down(std::size_t leg) noexcept;
  void stance(std::size_t leg) noexcept;
  void roll(std::size_t leg, double from_rad, double start_s, double lift_off_s) noexcept;
  void slow_stances(double now_s) noexcept;
  bool group_landed() noexcept;
  void roll_body() noexcept;
  bool landed(double now_s) noexcept;

  void order(std::size_t leg, double from_rad, double to_rad, double start_s, double arrive_s,
             bool swing) noexcept;
  double reference_rad(std::size_t leg, double now_s) const noexcept;
  bool arrived(std::size_t leg) const noexcept;
  double requested_half_sweep_rad(std::size_t leg) const noexcept;

  LocomotionParameters parameters_;
  StrokeEnds ends_;
  // With the legs that are in service.
  GaitTimes times_;
  double sweep_rad_;
  double offset_rad_;
  LegSet isolated_ = 0;
  bool can_walk_ = true;
  bool rows_ = false;  // instead of stepping
  bool can_row_;       // with all legs
  // For the present walk, when legs are isolated.
  Creep creep_{};
  Speed creep_speed_ = Speed::zero;
  int landing_group_ = 0;  // the first one whose landing has not been handled
  std::array<LegTarget, kLegs> targets_{};
  std::array<Leg, kLegs> legs_{};
  Schedule schedule_{};
  Motion motion_ = Motion::hold;
  Progress progress_ = Progress::done;
  Stage stage_ = Stage::rest;
  WalkRequest request_{};
  SideSpeeds sides_{};               // of the present walk
  SideSpeeds owed_{};                // rowing: requested and not yet rowed, in strokes
  std::array<Stroke, 2> strokes_{};  // left, right
  double stage_due_s_ = 0;
  double last_update_s_ = 0;
  bool updated_ = false;
  bool standing_ = false;  // result of our own motions, for legs without a report
  bool calibration_tried_ = false;
  Search search_ = Search::back;  // calibrating
  bool pushed_off_ = false;
  bool first_cycle_ = false;
  LegSet late_ = 0;
  bool walk_changed_ = false;
  bool gait_changed_ = false;  // in this cycle, with the next
  Dragging dragging_{};
  double distance_m_ = 0, yaw_rad_ = 0, speed_m_s_ = 0;
  std::uint32_t steps_ = 0;
};

}  // namespace lss::gnc::zebro
