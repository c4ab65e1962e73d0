#pragma once

// A second IMU (TALARIS thesis 2.3.6, 5.3: LandMark 30 and Crossbow), whose samples take the place
// of those that the first one does not give. What both measure differently by their biases and
// mounting is learnt while both are heard, so that navigation, which knows the biases of the first,
// goes on with either. Frame thread; time is data; no allocation.

#include <array>
#include <span>

#include "daemon/vehicles/talaris/config.h"
#include "gnc/talaris/types.h"

namespace lss::talaris {

class StandbyImu {
 public:
  using Sample = gnc::talaris::ImuSample;
  static constexpr std::size_t kMax = 64;  // of each in a frame; longer than a frame of either

  explicit StandbyImu(const Parameters& parameters) noexcept;

  // The frame that ends at `now` begins. `first`: what the first IMU gave in the frame before,
  // without doubtful samples. Learnt is only while it `stands`: what moves is felt by one earlier.
  void begin(TimeNs now, std::span<const Sample> first, bool stands) noexcept;
  void take(const ImuPacket& packet, TimeNs time) noexcept;

  // Samples of both in the order of time: the second's only where the first has none. Valid until
  // the next call.
  std::span<const Sample> with(std::span<const Sample> first) noexcept;
  void forget() noexcept;  // what was learnt: for a calibration
  bool silent() const noexcept;
  bool usable() const noexcept;  // heard, its values change, and its difference is known
  bool heard() const noexcept { return count_ != 0 && usable(); }  // in the frame
  TimeNs heard_ns() const noexcept { return time_ns_; }
  bool disagrees() const noexcept { return odd_frames_ >= kOddFrames; }  // for a second

 private:
  static constexpr int kOddFrames = 5;

  void compare(std::span<const Sample> first, bool stands) noexcept;

  std::array<SensorAxis, 3> axes_;
  TimeNs silent_after_ns_, first_period_ns_;
  int same_limit_;

  TimeNs now_ns_ = 0, time_ns_ = 0;
  ImuPacket packet_{};
  int same_ = 0;
  std::array<Sample, kMax> sample_{};
  std::size_t count_ = 0;
  std::array<Sample, 3 * kMax> both_{};

  int learnt_ = 0;  // frames
  int odd_frames_ = 0;
  gnc::talaris::Vector3 rate_off_rad_s_ = gnc::talaris::Vector3::Zero();
  gnc::talaris::Vector3 force_off_m_s2_ = gnc::talaris::Vector3::Zero();
};

}  // namespace lss::talaris
