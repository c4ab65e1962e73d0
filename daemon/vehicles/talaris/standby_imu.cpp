#include "daemon/vehicles/talaris/standby_imu.h"

#include <algorithm>
#include <cmath>

#include "idl/angles.h"

namespace lss::talaris {
namespace {

using gnc::talaris::Vector3;

constexpr int kKnownAfter = 25;  // frames: 5 s
constexpr double kLearn = 0.02;  // of a frame, later: a mean of 10 s
constexpr double kOddRate_rad_s = 1 * kDegree, kOddForce_m_s2 = 0.25;  // between means of a frame
constexpr std::size_t kEnough = 10;                                    // samples for a mean

struct Mean {
  Vector3 rate_rad_s = Vector3::Zero(), force_m_s2 = Vector3::Zero();
};

Mean mean_of(std::span<const StandbyImu::Sample> samples) noexcept {
  Mean mean;
  for (const auto& s : samples) {
    mean.rate_rad_s += s.rate_B_rad_s;
    mean.force_m_s2 += s.force_B_m_s2;
  }
  const double share = 1 / static_cast<double>(samples.size());
  return {share * mean.rate_rad_s, share * mean.force_m_s2};
}

}  // namespace

StandbyImu::StandbyImu(const Parameters& p) noexcept
    : axes_(p.standby_axes),
      silent_after_ns_(p.imu_silent_ns),
      first_period_ns_(static_cast<TimeNs>(std::llround(p.navigation.imu_period_s * 1e9))),
      same_limit_(std::max(
          2, static_cast<int>(std::lround(p.imu_stuck_s * 1e9 /
                                          static_cast<double>(p.buses.standby.period_ns))))) {}

void StandbyImu::begin(TimeNs now, std::span<const Sample> first, bool stands) noexcept {
  compare(first, stands);
  now_ns_ = now;
  count_ = 0;
}

void StandbyImu::take(const ImuPacket& packet, TimeNs time) noexcept {
  const bool same = time_ns_ != 0 && packet.rate_rad_s == packet_.rate_rad_s &&
                    packet.force_m_s2 == packet_.force_m_s2;
  same_ = same ? same_ + 1 : 0;
  packet_ = packet;
  time_ns_ = time;
  if (count_ == kMax) return;
  const auto body = [&](const std::array<double, 3>& v) {
    const auto along = [&](std::size_t i) { return axes_[i].sign * v[axes_[i].axis]; };
    return Vector3(along(0), along(1), along(2));
  };
  sample_[count_++] = {time, body(packet.rate_rad_s), body(packet.force_m_s2)};
}

// Until they differ by more than they can: then one of them is wrong, and nothing is learnt.
void StandbyImu::compare(std::span<const Sample> first, bool stands) noexcept {
  if (first.size() < kEnough || count_ < kEnough || same_ >= same_limit_) return;
  const Mean a = mean_of(first), b = mean_of(std::span(sample_).first(count_));
  const Vector3 rate = b.rate_rad_s - a.rate_rad_s, force = b.force_m_s2 - a.force_m_s2;
  if (!rate.allFinite() || !force.allFinite()) return;
  const bool odd = learnt_ >= kKnownAfter && ((rate - rate_off_rad_s_).norm() > kOddRate_rad_s ||
                                              (force - force_off_m_s2_).norm() > kOddForce_m_s2);
  odd_frames_ = odd ? std::min(odd_frames_ + 1, kOddFrames) : 0;
  if (odd || !stands) return;
  learnt_ = std::min(learnt_ + 1, 1'000'000);
  const double share = std::max(1.0 / learnt_, kLearn);
  rate_off_rad_s_ += share * (rate - rate_off_rad_s_);
  force_off_m_s2_ += share * (force - force_off_m_s2_);
}

void StandbyImu::forget() noexcept {
  learnt_ = odd_frames_ = 0;
  rate_off_rad_s_ = force_off_m_s2_ = Vector3::Zero();
}

bool StandbyImu::silent() const noexcept {
  return time_ns_ == 0 || now_ns_ - time_ns_ > silent_after_ns_;
}

bool StandbyImu::usable() const noexcept {
  return !silent() && same_ < same_limit_ && learnt_ >= kKnownAfter;
}

std::span<const StandbyImu::Sample> StandbyImu::with(std::span<const Sample> first) noexcept {
  if (!usable() || count_ == 0) return first;
  std::size_t size = 0, next = 0;
  TimeNs last_ns = 0;  // of the first
  const auto put = [&](const Sample& sample) {
    if (size < both_.size()) both_[size++] = sample;
  };
  const TimeNs gap_ns = first_period_ns_ + first_period_ns_ / 2;
  for (const Sample& s : std::span(sample_).first(count_)) {
    for (; next < first.size() && first[next].time_ns <= s.time_ns; ++next) {
      last_ns = first[next].time_ns;
      put(first[next]);
    }
    const bool before = last_ns != 0 && s.time_ns - last_ns <= gap_ns;
    const bool behind =
        next < first.size() && first[next].time_ns - s.time_ns <= first_period_ns_ / 2;
    if (before || behind) continue;
    Sample of_second = s;
    of_second.rate_B_rad_s -= rate_off_rad_s_;
    of_second.force_B_m_s2 -= force_off_m_s2_;
    // It covers more of the first's periods: the same again for each.
    const TimeNs since_ns = size != 0 ? both_[size - 1].time_ns : s.time_ns - 2 * first_period_ns_;
    for (TimeNs t = s.time_ns - first_period_ns_;
         t > since_ns + first_period_ns_ / 2 && t > s.time_ns - 2 * first_period_ns_;
         t -= first_period_ns_) {
      Sample earlier = of_second;
      earlier.time_ns = t;
      put(earlier);
    }
    put(of_second);
  }
  for (; next < first.size(); ++next) put(first[next]);
  return std::span(both_).first(size);
}

}  // namespace lss::talaris
