#pragma once

// Calibration standing still (TALARIS thesis 4.5.1, 30 s): biases of the gyroscopes, direction of
// the vertical, height or distance to the wall. Movement is detected and reported with its value.

#include "gnc/talaris/navigation_parameters.h"
#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

enum class CalibrationPhase : std::uint8_t { idle, running, done, failed };

enum class CalibrationFault : std::uint8_t {
  none,
  turning,       // mean rate of a frame against the mean so far, rad/s
  rate_spread,   // standard deviation of the rate within a frame, rad/s
  shaking,       // mean force of a frame against the mean so far, m/s2
  force_spread,  // standard deviation of the force within a frame, m/s2
  rate_bias,     // mean rate, rad/s
  force_size,    // |mean force| - g, m/s2
  tilted,        // from the vertical, rad
  imu_silent,    // received share of the samples; `limit`: at least, or at most
  few_ranges,    // readings of the altimeter; `limit`: at least
  range_spread,  // between the quartiles of the ranges, m
};

struct CalibrationStatus {
  CalibrationPhase phase = CalibrationPhase::idle;
  double progress = 0;  // 0..1, share of the time; back to 0 at a restart
  int restarts = 0;
  CalibrationFault fault = CalibrationFault::none;  // reason of the last restart or failure
  double measured = 0;                              // of the fault, in its unit
  double limit = 0;
};

// In words, with the unit of `measured` and `limit`: "the vehicle turns (rad/s)".
const char* describe(CalibrationFault fault) noexcept;

// Results.
struct Alignment {
  std::int64_t time_ns = 0;
  Quaternion q_NB = Quaternion::Identity();
  Vector3 gyro_bias_rad_s = Vector3::Zero();
  Vector3 accelerometer_bias_m_s2 = Vector3::Zero();  // along the vertical only
  double range_m = kNaN;                              // median; NaN without altimeter
  int ranges = 0;
  Vector3 up_B = Vector3::UnitX();  // unit vector
  double seconds = 0;
};

class Calibration {
 public:
  Calibration() = default;

  void begin() noexcept;  // from the beginning, with restarts at 0
  const CalibrationStatus& step(const Batch& batch,
                                const NavigationParameters& parameters) noexcept;
  const CalibrationStatus& status() const noexcept { return status_; }
  const Alignment& result() const noexcept { return result_; }  // once done

 private:
  // Mean and sum of squared deviations of rate and force (Welford).
  struct Mean {
    int count = 0;
    Vector3 rate = Vector3::Zero(), force = Vector3::Zero();
    Vector3 rate_square = Vector3::Zero(), force_square = Vector3::Zero();
    void add(const ImuSample& sample) noexcept;
    void add(const Mean& other) noexcept;  // the means only
  };
  static constexpr std::size_t kMaxRanges = 1024;

  void start_over() noexcept;
  void moved(CalibrationFault fault, double measured, double limit,
             const NavigationParameters& p) noexcept;
  bool still(const Mean& frame, const NavigationParameters& p) noexcept;
  void collect(const Batch& batch, const Mean& frame, std::int64_t first_ns,
               const NavigationParameters& p) noexcept;
  void finish(double collected_s, const NavigationParameters& p) noexcept;
  void fail(CalibrationFault fault, double measured, double limit) noexcept;

  CalibrationStatus status_;
  Alignment result_;
  Mean mean_;
  std::int64_t called_ns_ = 0, first_ns_ = 0, last_ns_ = 0;
  bool called_ = false;  // called_ns_ is known: end of the first frame
  bool heard_ = false;   // last_ns_ is known: of the last usable sample
  bool begun_ = false;   // first_ns_ is known: of the first sample that counts
  std::array<double, kMaxRanges> range_m_{};
  std::size_t ranges_ = 0;
};

// A sample that can be used at all: numbers, within the range of the sensor.
bool usable(const ImuSample& sample, const NavigationParameters& parameters) noexcept;
bool usable(const RangeSample& sample, const NavigationParameters& parameters) noexcept;

}  // namespace lss::gnc::talaris
