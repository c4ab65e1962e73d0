#pragma once

// Inputs and outputs of the mobility controller of D.I.A.N.A. Ardito, as plain structs.
//
// Wheels 0..5 = LF, RF, LM, RM, LR, RR (wheels 1..6 of the Ardito thesis); steering systems 0..3 =
// those of wheels 1, 2, 5, 6. All speeds and angles are at the wheel: values of the motor's side
// are divided by Geometry::gear_ratio on input and multiplied on output. Frames: x forward, y
// right, z down, origin in the centre of mass (CM). sigma > 0 moves the CM to the right. Steering
// angle > 0 turns the wheel to the left, a positive wheel speed drives forward.

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>

namespace lss::gnc::ardito {

inline constexpr double kPi = 3.14159265358979323846;
inline constexpr double kFrame_s = 0.1;
inline constexpr std::size_t kWheels = 6;
inline constexpr std::size_t kSteered = 4;
inline constexpr double kRadPerSecondPerRpm = 2 * kPi / 60;

template <class T>
using PerWheel = std::array<T, kWheels>;
template <class T>
using PerSteered = std::array<T, kSteered>;

// Bit i = wheel i, or steering system i.
using WheelSet = std::uint32_t;
using SteeringSet = std::uint32_t;
inline constexpr WheelSet kAllWheels = 0x3F;
inline constexpr SteeringSet kAllSteered = 0x0F;
inline constexpr bool contains(std::uint32_t set, std::size_t i) noexcept {
  return ((set >> i) & 1U) != 0;
}
inline constexpr std::uint32_t only(std::size_t i) noexcept { return 1U << i; }

// The wheel of a steering system, and back (kSteered for the middle wheels).
inline constexpr PerSteered<std::size_t> kWheelOfSteered = {0, 1, 4, 5};
inline constexpr PerWheel<std::size_t> kSteeredOfWheel = {0, 1, kSteered, kSteered, 2, 3};
inline constexpr bool is_left(std::size_t wheel) noexcept { return wheel % 2 == 0; }

// One value of a sensor. An old one, or one that is not a number, is a fault and never used.
struct Reading {
  double value = std::numeric_limits<double>::quiet_NaN();
  double age_s = std::numeric_limits<double>::infinity();  // never received
};

struct WheelMeasured {
  Reading motor_rad_s;      // motor encoder
  Reading hall_rad_s;       // Hall sensors of the motor
  Reading reduction_rad_s;  // encoder behind gear and clutch, on the wheel's shaft
  // Of the motor, share of the rated current, positive when it drives forward.
  Reading current;
  Reading temperature_C;
  bool drive_fault = false;  // reported by the drive, or it cannot be reached
};

struct SteeringMeasured {
  Reading motor_rad;      // motor encoder
  Reading reduction_rad;  // encoder behind the gear
  Reading current;        // share of the rated current
  bool drive_fault = false;
};

struct ImuMeasured {
  Reading speed_m_s;  // Vtan: of the CM, along sigma
  Reading sigma_rad;
  Reading yaw_rate_rad_s;     // clockwise seen from above positive (about z, down)
  std::uint32_t counter = 0;  // must change from frame to frame; may wrap
};

struct Measured {
  PerWheel<WheelMeasured> wheels;
  PerSteered<SteeringMeasured> steering;
  Reading beta_rad;  // left rocker against nominal, positive lifts the left front wheel
  Reading rho1_rad;  // left bogie
  Reading rho2_rad;  // right bogie
  ImuMeasured imu;
};

// The requested motion. Values out of range are clipped; a value that is not a number means stop.
struct Request {
  double sigma_rad = 0;          // direction of the CM's velocity, +-5 deg; ignored when parking
  double speed = 0;              // Vtan, [-1, 1], share of speed_limit_m_s; below 1 % is a stop
  double speed_limit_m_s = 0.5;  // 1.0 URC, 0.5 ERC; never more than Parameters::top_speed_m_s
  bool parking = false;          // turn on the spot
  bool run = false;              // false: stop, at any speed
  bool enable_correction = true;
  bool error = false;  // of the levels above: stop
  // Drives have power and received the last command. false (booting, emergency stop, gate shut):
  // nothing is counted or latched, and the command is to stand.
  bool powered = true;
  // SolveErrors. Clears all findings about these: sensors count again, clutches close again, motors
  // run again.
  WheelSet retry_wheels = 0;
  SteeringSet retry_steering = 0;
  // These wheels are isolated (clutch open, motor stopped) and the decision is to go on without
  // them: they raise no error any more.
  WheelSet accept_lost_wheels = 0;
};

// Ardito thesis 11.1 and, inside Stop, 11.2.4.
enum class Mode : std::uint32_t { stop, running, parking };
enum class StopPhase : std::uint32_t {
  begin,         // after the start, until measured speeds and angles show the motion
  rover_stop,    // stands, steered as requested; the only phase from which modes change
  rover_steer,   // stands and steers
  deceleration,  // slows down, steering held
};

// Ardito thesis 17.2.1, with its numbers.
enum class WheelFailure : std::uint32_t {
  none = 0,
  motor_sensor = 1,       // E-TM or H-TM: one of the two sensors of the motor
  reduction_encoder = 2,  // E-TRG
  motor = 3,              // TM: clutch open, motor stopped
  reduction = 4,          // TRG: the same, and an error when it lasts
  clutch = 5,             // TC: transmits nothing
  two_sensors = 6,        // drives on with the one that is left
  clutch_and_sensor = 7,  // TC with E-TM or H-TM
  all_sensors = 8,        // clutch open, motor stopped, then an error
};

// Ardito thesis 17.4.
enum class SteeringFailure : std::uint32_t {
  none = 0,
  motor_encoder = 1,      // E-SM
  reduction_encoder = 2,  // E-SRG
  critical = 3,           // SM or SRG: does not follow; error
  both_encoders = 4,      // or one encoder and the motor; error
};

// Bits of Command::faults: faults other than those of wheels and steering systems.
enum Fault : std::uint32_t {
  kImuSilent = 1U << 0,       // old or frozen
  kImuImplausible = 1U << 1,  // out of range, jumps, or contradicts coherent wheels for long
  kRockerStale = 1U << 2,     // beta, rho1 or rho2 old or impossible: no correction to 3-D
  kSlip = 1U << 3,            // wheels and IMU disagree
  kIncoherentSpeed = 1U << 4,
  kIncoherentSigma = 1U << 5,
  kTooFewWheels = 1U << 6,   // more wheels lost than Parameters::max_lost_wheels
  kWheelsSlip = 1U << 7,     // wheels turn and the rover does not follow, by load or yaw rate
  kStuck = 1U << 8,          // the same, above Parameters::slip_share and for stuck_frames
  kRockerJump = 1U << 9,     // beta, rho1 or rho2 jumped: not trusted for rocker_frames
  kYawDisagrees = 1U << 10,  // yaw rate of IMU and inverse model, for long (7.2.1)
  kSlipSlows = 1U << 11,     // it drives slower than requested: more slip than allowed
  kWheelSinks = 1U << 12,    // one wheel digs itself in: Command::sinking
  kRockerOff = 1U << 13,     // beta, rho1 or rho2 is not 0 on average over a long way
};

struct Estimate {
  // From trusted wheels and steering systems. Turning on the spot sigma = +pi/2 and speed_m_s is
  // that of the CM, yaw rate * f.
  double speed_m_s = 0;
  double sigma_rad = 0;
  double yaw_rate_rad_s = 0;
  double slip_m_s = 0;  // by how much the wheels go faster than the rover, by the IMU; 0 without it
  double ground_m_s = 0;  // speed over the ground: the IMU's while wheels slip, else speed_m_s
  // Of the wheels' speed that is lost, by the IMU, over about a second; negative: the rover pushes
  // its wheels. 0: not measured.
  double slip_share = 0;
  double speed_share = 1;   // of the requested speed that it drives with: less when it slips
  double sunk_m = 0;        // of Command::sinking, when there is one: lower than the others' plane
  double strain = 0;        // the same: its motor's load, times that of the others
  double strain_limit = 0;  // the same
  double load = 0;  // mean of the motors that drive: share of the rated current above no load
  PerWheel<double> wheel_rad_s{};      // the feedback that control uses
  PerSteered<double> steering_rad{};   // the same
  PerWheel<double> wheel_speed_m_s{};  // Vtan by each wheel alone

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.speed_m_s, self.sigma_rad, self.yaw_rate_rad_s, self.slip_m_s,
                    self.ground_m_s, self.slip_share, self.speed_share, self.sunk_m, self.strain,
                    self.strain_limit, self.load, self.wheel_rad_s, self.steering_rad,
                    self.wheel_speed_m_s);
  }
};

struct Command {
  PerWheel<double> wheel_rad_s{};
  PerSteered<double> steering_rad{};
  // false until the angles were measured once: steering drives must not be ordered before.
  std::uint32_t steering_known = 0;
  WheelSet clutches_engaged = kAllWheels;
  WheelSet motors_stopped = 0;  // no torque; wheel_rad_s is 0 there
  Mode mode = Mode::stop;
  StopPhase phase = StopPhase::begin;  // used in Mode::stop
  std::uint32_t busy = 1;              // 1: no change of mode now
  std::uint32_t error = 0;             // 1: for the locomotion controller; stays until retried
  std::uint32_t faults = 0;            // Fault bits of this frame
  // Latched until retried.
  PerWheel<WheelFailure> wheel_failure{};
  PerSteered<SteeringFailure> steering_failure{};
  // Suspected in this frame alone, before counting: may come and go.
  PerWheel<WheelFailure> wheel_suspect{};
  PerSteered<SteeringFailure> steering_suspect{};
  // Sensors considered failed, bit 0 motor encoder, bit 1 Hall, bit 2 reduction.
  PerWheel<std::uint32_t> sensors_lost{};
  PerSteered<std::uint32_t> encoders_lost{};  // bit 0 motor, bit 1 reduction
  WheelSet stale_wheels = 0;                  // a value of this wheel was too old in this frame
  SteeringSet stale_steering = 0;
  WheelSet hot_motors = 0;           // above Parameters::warm_temperature_C; taken out above max_
  WheelSet inconclusive_wheels = 0;  // contradictory sensors for long, no failure fits
  WheelSet probing = 0;              // clutch under test: this wheel runs a little slower
  WheelSet sinking = 0;              // digs itself in, now
  Estimate estimate;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.wheel_rad_s, self.steering_rad, self.steering_known, self.clutches_engaged,
                    self.motors_stopped, self.mode, self.phase, self.busy, self.error, self.faults,
                    self.wheel_failure, self.steering_failure, self.wheel_suspect,
                    self.steering_suspect, self.sensors_lost, self.encoders_lost, self.stale_wheels,
                    self.stale_steering, self.hot_motors, self.inconclusive_wheels, self.probing,
                    self.sinking, self.estimate);
  }
};

}  // namespace lss::gnc::ardito
