#pragma once

// Sensor data of TALARIS, per frame: the batch for navigation in the axes of the body; the newest
// of all other values, filtered as in the thesis (4.5.2, 5.2.5), with its age; and sensor faults.
// Frame thread; time is data; no allocation.

#include <algorithm>
#include <array>
#include <cstdint>

#include "daemon/vehicles/talaris/config.h"
#include "daemon/vehicles/talaris/standby_imu.h"
#include "gnc/talaris/filters.h"
#include "gnc/talaris/types.h"

namespace lss::talaris {

class Sensors {
 public:
  explicit Sensors(const Parameters& parameters) noexcept;
  void configure(const Parameters& parameters) noexcept;  // the fault thresholds

  // One frame: begin, then each sample; then the other functions may be called.
  void begin(TimeNs now, bool stands) noexcept;
  void take(const TalarisSample& sample) noexcept;

  // For navigation, of both IMUs; without samples that only repeat. Valid until the next call.
  gnc::talaris::Batch batch() noexcept;

  // IMU: data of none is reliable.
  bool imu_lost() const noexcept { return (imu_silent() || imu_stuck()) && !standby_.usable(); }
  const StandbyImu& standby() const noexcept { return standby_; }
  bool imu_silent() const noexcept;
  bool imu_stuck() const noexcept { return same_ >= same_limit_; }
  bool imu_known() const noexcept { return imu_ns_ != 0; }
  bool imu_heard() const noexcept {  // in the frame, either
    return imu_count_ != 0 || standby_.heard();
  }
  std::uint64_t imu_lost_packets() const noexcept { return lost_in_frame_; }
  std::uint64_t imu_lost_in_all() const noexcept { return lost_; }
  bool imu_lossy() const noexcept { return lossy_ > lossy_limit_; }
  bool imu_test_failed() const noexcept { return test_flags_ != 0; }  // as it says itself
  // Its new scale, when it changed in the frame.
  bool scale_changed() const noexcept { return scale_changed_; }
  double scale_before() const noexcept { return scale_before_; }
  double scale() const noexcept { return scale_; }
  void forget_imu() noexcept;
  void forget_difference() noexcept { standby_.forget(); }  // of both IMUs
  TimeNs imu_ns() const noexcept { return imu_ns_; }
  double imu_age_s() const noexcept {  // of the newest reliable one
    const TimeNs second_ns = standby_.usable() ? standby_.heard_ns() : 0;
    return age_s(std::max(imu_stuck() ? 0 : imu_ns_, second_ns));
  }

  // Altimeter.
  bool altimeter_lost() const noexcept;
  double range_m() const noexcept { return range_m_; }  // last good one; NaN: none yet
  double range_age_s() const noexcept { return age_s(range_ns_); }
  int range_repeats() const noexcept { return repeats_; }  // identical to the one before, in a row
  std::uint8_t range_errors() const noexcept { return errors_in_frame_; }
  std::uint8_t range_error() const noexcept { return error_; }  // last one
  std::uint64_t range_errors_in_all() const noexcept { return errors_; }
  TimeNs altimeter_ns() const noexcept { return altimeter_ns_; }  // also of errors

  bool corner_lost(std::size_t corner) const noexcept;  // an altimeter there, 0 to 3

  // Camera.
  bool camera_lost() const noexcept;  // silent, or out of its rhythm
  TimeNs camera_ns() const noexcept { return camera_ns_; }

  // Actuators.
  double gas_age_s() const noexcept { return age_s(gas_ns_); }
  double tank_kPa() const noexcept;  // filtered; NaN: never received
  double regulated_kPa() const noexcept;
  const GasState& gas() const noexcept { return gas_; }  // unfiltered
  double fan_age_s() const noexcept { return age_s(fans_ns_); }
  const std::array<double, kHopperFans>& rpm() const noexcept { return rpm_; }
  std::array<double, 3> load_N() const noexcept;
  std::array<double, 3> load_Nm() const noexcept;

 private:
  static constexpr std::size_t kMaxImu = 64, kMaxRanges = 8, kMaxFlows = 32;
  static constexpr std::size_t kMostOfCorner = 5, kMaxCorners = kCornerAltimeters * kMostOfCorner;

  void take(const ImuPacket& packet, TimeNs time) noexcept;
  void take(const ImuStatus& status, TimeNs time) noexcept;
  void take(const Range& range, TimeNs time) noexcept;
  void take_corner(const Range& range, TimeNs time) noexcept;
  void take(const StandbyPacket& second, TimeNs time) noexcept {
    standby_.take(second.packet, time);
  }
  void take(const Flow& flow, TimeNs time) noexcept;
  void take(const GasState& gas, TimeNs time) noexcept;
  void take(const FanSpeeds& fans, TimeNs time) noexcept;
  void take(const Load& load, TimeNs time) noexcept;
  double age_s(TimeNs since) const noexcept;
  gnc::talaris::Vector3 body(const std::array<double, 3>& sensor) const noexcept;

  std::array<SensorAxis, 3> axes_;
  std::array<SensorAxis, 2> camera_axes_;
  TimeNs imu_silent_ns_, altimeter_silent_ns_, camera_silent_ns_, camera_period_ns_;
  int same_limit_, lossy_limit_;

  TimeNs now_ns_ = 0;
  std::array<gnc::talaris::ImuSample, kMaxImu> imu_{};
  std::size_t imu_count_ = 0;
  StandbyImu standby_;
  std::array<gnc::talaris::RangeSample, kMaxRanges> range_{};
  std::size_t range_count_ = 0;
  std::array<gnc::talaris::FlowSample, kMaxFlows> flow_{};
  std::size_t flow_count_ = 0;

  TimeNs imu_ns_ = 0;
  ImuPacket packet_{};
  int same_ = 0;  // identical packets in a row
  std::uint64_t lost_ = 0, lost_in_frame_ = 0;
  double lossy_ = 0;  // packets lost, mean of about a second
  int scale_ = -1, scale_before_ = -1;
  bool scale_changed_ = false;
  std::uint8_t test_flags_ = 0;

  TimeNs range_ns_ = 0, altimeter_ns_ = 0;
  double range_m_ = gnc::talaris::kNaN;
  int repeats_ = 0;
  std::uint8_t error_ = 0, errors_in_frame_ = 0;
  std::uint64_t errors_ = 0;

  std::array<gnc::talaris::RangeSample, kMaxCorners> corner_{};  // in the order of time
  std::size_t corner_count_ = 0;
  std::array<TimeNs, kCornerAltimeters> corner_ns_{};

  TimeNs camera_ns_ = 0, frame_of_camera_ns_ = 0;

  TimeNs gas_ns_ = 0, fans_ns_ = 0;
  GasState gas_{};
  gnc::talaris::Filter tank_, regulated_;
  std::array<double, kHopperFans> rpm_{};
  std::array<gnc::talaris::Filter, 6> load_;
};

}  // namespace lss::talaris
