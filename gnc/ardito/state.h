#pragma once

// The state of the mobility controller between frames. All of it is voted (vote.h), so it has only
// whole words and every member is tied.

#include "gnc/ardito/diagnosis.h"
#include "gnc/ardito/rocker_bogie.h"

namespace lss::gnc::ardito {

// engaged -> testing: clutch open, motor runs on: does it turn? -> isolated: clutch open, motor
// stopped, until retried.
enum class WheelService : std::uint32_t { engaged, testing, isolated };
// Of the clutch: watch -> probe (a little slower) -> watch after a pause, or the part is lost.
enum class ClutchTest : std::uint32_t { watch, probe };

struct WheelHealth {
  std::uint32_t lost = 0;       // Part bits, latched
  std::uint32_t candidate = 0;  // Part bits that are being counted
  std::uint32_t count = 0;
  std::uint32_t inconclusive = 0;
  WheelService service = WheelService::engaged;
  std::uint32_t service_frames = 0;  // testing: since the clutch opened
  std::uint32_t error_frames = 0;    // since a part was lost that is an error when it lasts
  std::uint32_t error = 0;
  std::uint32_t hot = 0;          // frames of the motor above its limit, counted up and down
  std::uint32_t overcurrent = 0;  // the same
  ClutchTest test = ClutchTest::watch;
  std::uint32_t quiet = 0;  // frames at no load: in a row, or in the probe
  std::uint32_t probed = 0;
  std::uint32_t pause = 0;
  double drift_rad = 0;     // motor ahead of wheel, since the probe began
  double astray_rad_s = 0;  // of the motor from its order, in the probe's second half

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.lost, self.candidate, self.count, self.inconclusive, self.service,
                    self.service_frames, self.error_frames, self.error, self.hot, self.overcurrent,
                    self.test, self.quiet, self.probed, self.pause, self.drift_rad,
                    self.astray_rad_s);
  }
};

struct SteeringHealth {
  std::uint32_t lost = 0;  // bit 0 motor encoder, bit 1 reduction encoder, latched
  std::uint32_t critical = 0;
  SteeringFailure candidate = SteeringFailure::none;
  std::uint32_t count = 0;
  std::uint32_t error = 0;
  std::uint32_t compared =
      0;  // both encoders were usable in the frame before: motor_rad, reduction_rad
  std::uint32_t overcurrent = 0;  // frames of the motor above its limit, counted up and down
  std::uint32_t reserved = 0;
  double motor_rad = 0;
  double reduction_rad = 0;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.lost, self.critical, self.candidate, self.count, self.error, self.compared,
                    self.overcurrent, self.reserved, self.motor_rad, self.reduction_rad);
  }
};

inline constexpr std::size_t kWheelDelay = 2;     // frames in which a wheel's drive has obeyed
inline constexpr std::size_t kSteeringDelay = 5;  // a steering drive turns round, too

// Frames in a row in which wheels and IMU contradict each other, and the evidence of all of them:
// who is right?
struct SlipWatch {
  std::uint32_t frames = 0;
  std::uint32_t stuck_frames = 0;  // of them those above Parameters::slip_share
  double load = 0;                 // sums
  double wheels_m_s = 0;           // without signs
  double imu_m_s = 0;              // the same
  double wheels_yaw_rad_s = 0;
  double imu_yaw_rad_s = 0;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.frames, self.stuck_frames, self.load, self.wheels_m_s, self.imu_m_s,
                    self.wheels_yaw_rad_s, self.imu_yaw_rad_s);
  }
};

// Slip over about a second, and what it makes of the requested speed. Of the drive that goes on: a
// stop forgets it.
struct SlipSpeed {
  double lost_m_s = 0;    // filtered: of the wheels' speed
  double wheels_m_s = 0;  // filtered, without a sign
  double load = 0;        // filtered
  double factor = 1;      // of the requested speed
  std::uint32_t slows = 0;
  std::uint32_t above = 0;       // frames with more slip than allowed
  std::uint32_t unmeasured = 0;  // frames without an IMU
  std::uint32_t reserved = 0;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.lost_m_s, self.wheels_m_s, self.load, self.factor, self.slows, self.above,
                    self.unmeasured, self.reserved);
  }
};

// Of one wheel that digs itself in. `held` and `way` outlast a stop: the wheels that are still in,
// and the sense of the motion that brought them there.
struct SinkWatch {
  std::uint64_t running = 0;         // it was in the frame before
  PerWheel<std::uint32_t> frames{};  // in a row, in which it dug
  PerWheel<double> way{};            // it went in by: 1 ahead, -1 back, 2 unknown; 0: it is up
  PerWheel<double> lower_m{};        // filtered: than the plane of the others
  PerWheel<double> load{};           // filtered

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.running, self.frames, self.way, self.lower_m, self.load);
  }
};

// Of the suspension angles, over a way without turning back.
struct RockerWatch {
  double way_m = 0;                  // the last rocker_way_m at most; negative: backward
  std::array<double, 3> mean_rad{};  // over it
  std::uint64_t off = 0;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.way_m, self.mean_rad, self.off);
  }
};

struct State {
  // decisions
  Mode mode = Mode::stop;
  StopPhase phase = StopPhase::begin;
  std::uint32_t started = 0;         // a frame was stepped
  std::uint32_t steering_known = 0;  // all angles were measured once
  std::uint32_t poses_known = 0;     // of the frame before
  // IMU
  std::uint32_t imu_counter = 0;
  std::uint32_t imu_frozen = 0;         // frames without a new packet
  std::uint32_t imu_contradiction = 0;  // frames
  // suspension angles of the frame before, and frames until they are trusted after a jump
  std::uint32_t rocker_known = 0;
  std::uint32_t rocker_distrust = 0;
  std::array<double, 3> rocker_rad{};
  RockerWatch rocker_watch;
  SlipWatch slip;
  SlipSpeed slip_speed;
  SinkWatch sinking;
  double yaw_error_rad_s = 0;  // IMU against inverse model, filtered
  double imu_speed_m_s = 0;
  double sigma_rad = 0;  // requested in the frame before

  // rover as estimated in the frame before
  double v_m_s = 0;
  double direction_sin = 0;
  double direction_cos = 1;
  WheelPoses poses;

  // ratio blocks, and the orders, latest first
  PerWheel<double> wheel_integral{};
  PerSteered<double> steering_integral{};
  PerSteered<double> steering_held{};
  std::array<PerWheel<double>, kWheelDelay> wheels_ordered{};
  std::array<PerSteered<double>, kSteeringDelay> steering_ordered{};

  PerWheel<WheelHealth> wheels;
  PerSteered<SteeringHealth> steering;

  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.mode, self.phase, self.started, self.steering_known, self.poses_known,
                    self.imu_counter, self.imu_frozen, self.imu_contradiction, self.rocker_known,
                    self.rocker_distrust, self.rocker_rad, self.rocker_watch, self.slip,
                    self.slip_speed, self.sinking, self.yaw_error_rad_s, self.imu_speed_m_s,
                    self.sigma_rad, self.v_m_s, self.direction_sin, self.direction_cos, self.poses,
                    self.wheel_integral, self.steering_integral, self.steering_held,
                    self.wheels_ordered, self.steering_ordered, self.wheels, self.steering);
  }
};

}  // namespace lss::gnc::ardito
