#pragma once

// Navigation of TALARIS: position, velocity and attitude of the vehicle from the IMU and the
// altimeter, per frame of 200 ms (TALARIS thesis 4.2). Calibrated standing still, then dead
// reckoning with a Kalman filter that the altimeter corrects. No clock: times are data. A plain
// value: copies run independently. Decisions and limits: docs/gnc-talaris.md.

#include "gnc/talaris/calibration.h"
#include "gnc/talaris/ekf.h"
#include "gnc/talaris/navigation_parameters.h"
#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

// Since begin_calibration(), of samples passed to step().
struct NavCounters {
  std::uint32_t imu_used = 0;
  std::uint32_t imu_bad = 0;   // no number, outside the sensor's range, or from the future
  std::uint32_t imu_late = 0;  // not later than the last one used
  std::uint32_t gaps = 0;      // more than 1.5 periods between two samples
  double longest_gap_s = 0;
  std::uint32_t frames_held = 0;  // without a usable sample
  std::uint32_t ranges_used = 0;
  std::uint32_t ranges_bad = 0;      // no number, out of the sensor's range, or too tilted
  std::uint32_t ranges_gated = 0;    // outside the gate
  std::uint32_t gates_reopened = 0;  // used again after many gated ones that agreed
  double innovation_m = 0;           // of the last range: measured - expected
  double innovation_sigma_m = 0;     // expected standard deviation of that
  std::uint32_t flows_used = 0;
  std::uint32_t flows_bad = 0;  // no number, out of the camera's range, too tilted, or after a gap
  std::uint32_t flows_gated = 0;    // outside the gate
  std::uint32_t corners_used = 0;   // times that the altimeters at all corners were used
  std::uint32_t corners_gated = 0;  // and that they contradicted each other
};

class Navigation {
 public:
  Navigation() : Navigation(NavigationParameters{}) {}
  explicit Navigation(const NavigationParameters& parameters) noexcept;

  // Clears everything; calibrate() then takes the frames in which the vehicle stands still.
  void begin_calibration() noexcept;
  const CalibrationStatus& calibrate(const Batch& batch) noexcept;
  const CalibrationStatus& calibration() const noexcept { return calibration_.status(); }
  bool aligned() const noexcept { return calibration().phase == CalibrationPhase::done; }

  // One frame; call it for every frame from then on. `valid` is false before the calibration is
  // done, when the IMU was silent for longer than `hold_s`, and after that until the attitude is
  // known to `lost_attitude_rad` (mostly: until calibrated again). Silence is bridged with the last
  // rate and force. `standing`: it stands on the ground, nothing moves; no drift then.
  // `slides`: light on its legs it may slide, but does not turn.
  const NavState& step(const Batch& batch, bool standing = false, bool slides = false) noexcept;
  const NavState& state() const noexcept { return state_; }  // of the last step, or as calibrated
  const NavCounters& counters() const noexcept { return counters_; }
  // Altimeters at the corners: the four contradict the one in the middle, which is not used until
  // the next calibration; and what that one should measure by them, unless they contradict each
  // other.
  bool range_doubted() const noexcept { return doubted_; }
  // Where it stands the four see other ground than the one in the middle: they are not used.
  bool corners_uneven() const noexcept { return uneven_; }
  const RangeSample& range_by_corners() const noexcept { return by_corners_; }
  const Ekf& filter() const noexcept { return ekf_; }  // at the last IMU sample or range
  const NavigationParameters& parameters() const noexcept { return parameters_; }

 private:
  using Plane = std::array<Ekf::Measurement, kCorners>;
  static constexpr int kLeastFits = 10;  // of the corners at standstill; fewer: they are not used

  void align() noexcept;
  std::int64_t measured_ns(const RangeSample& sample) const noexcept;
  void advance(std::int64_t until_ns) noexcept;
  void reckon(std::int64_t until_ns) noexcept;
  void come_to(std::int64_t at_ns) noexcept;
  void blur_ground(double slope, double since_s) noexcept;
  ExpectedRange compare(const RangeSample& sample, const Beam& beam,
                        Ekf::Measurement& m) const noexcept;
  void use_range(const RangeSample& sample) noexcept;
  void use_corner(const RangeSample& sample) noexcept;
  void fit_corners(std::int64_t at_ns) noexcept;
  double apart_m(double slope) const noexcept;
  void learn_corners(double slope) noexcept;
  void use_slopes(const Plane& plane, double slope, double way_m) noexcept;
  void use_height(const Ekf::Measurement& height, bool overrules) noexcept;
  void use_flow(const FlowSample& sample) noexcept;
  void reopen(const Ekf::Measurement& m, std::int64_t at_ns) noexcept;
  void stand_still(bool slides) noexcept;
  void level(bool slides) noexcept;
  void hold_to_stand() noexcept;
  void hold_axis(int axis, int component) noexcept;
  void publish(std::int64_t end_ns) noexcept;

  NavigationParameters parameters_;
  Calibration calibration_;
  Ekf ekf_;
  Nominal start_;  // as calibrated
  NavState state_;
  NavCounters counters_;
  std::int64_t filter_ns_ = 0;        // time of the filter's state
  std::int64_t last_imu_ns_ = 0;      // of the last sample that was used
  std::int64_t last_range_ns_ = 0;    // as above
  Vector3 rate_m_ = Vector3::Zero();  // last sample, with bias
  Vector3 force_m_ = Vector3::Zero();
  bool lost_ = false;
  struct Way {
    double time_s = 0;
    Vector3 velocity_m_s = Vector3::Zero();  // by acceleration, without corrections
    Vector3 turned_rad = Vector3::Zero();    // as measured, with bias, B
    Vector3 force_m_s2 = Vector3::Zero();    // the same, times its time
    Vector3 least_m_s = Vector3::Zero(), most_m_s = Vector3::Zero();  // of the velocity, each axis
    double foot_down_m_s = 0;                                         // the most
  };
  Way way_;                                    // of this frame
  Vector3 rest_force_m_s2_ = Vector3::Zero();  // at the last standstill, with bias, B
  struct Passed {
    double time_s = 0;
    Vector3 moved_m = Vector3::Zero();     // N
    Vector3 turned_rad = Vector3::Zero();  // as measured, with bias, B
  };
  Passed passed_;  // since the last flow
  // Consecutive ranges outside the gate that agree with each other.
  struct Gate {
    int gated = 0;
    std::int64_t first_ns = 0;
    double first_m = 0, last_m = 0;  // innovations
  };
  Gate gate_;
  // Altimeters at the corners: residuals of the four, those of standstill, and what came of them.
  Plane corner_;
  std::array<double, kCorners> at_rest_m_{};
  Matrix3 rest_C_ = Matrix3::Identity();  // N from B then
  Vector3 rest_bias_m_s2_ = Vector3::Zero();
  std::array<std::int64_t, kCorners> corner_ns_{};  // 0: none since the last fit
  int other_ground_ = 0, rest_fits_ = 0, contradicted_ = 0, height_gated_ = 0;
  std::int64_t fitted_ns_ = 0, used_range_ns_ = 0;
  RangeSample by_corners_;
  std::int64_t corners_agree_ns_ = 0;  // with the filter, without the one in the middle
  double twist_m_ = 0;                 // mean
  double off_m_ = 0;                   // residual of the one in the middle, after its correction
  bool doubted_ = false, standing_ = false, uneven_ = false;
  Beam beam_;
  double least_cosine_ = 0;  // between beam and the plane's normal
};

// The state `ahead_s` later at constant rate and acceleration: control uses the centre of the frame
// that it commands.
NavState predict(const NavState& state, double ahead_s) noexcept;

}  // namespace lss::gnc::talaris
