#include "gnc/ardito/estimate.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::ardito {
namespace {

constexpr double kSpotSin = 0.7;  // sigma above 45 deg is turning on the spot

double dot(const Direction& a, const Direction& b) noexcept {
  return a.sin * b.sin + a.cos * b.cos;
}

// Directions are lines: each is taken in the sense that fits the first one.
struct MeanDirection {
  Direction sum{0, 0};
  int count = 0;

  void add(const Direction& d) noexcept {
    const double sign = count > 0 && dot(sum, d) < 0 ? -1 : 1;
    sum = {sum.sin + sign * d.sin, sum.cos + sign * d.cos};
    ++count;
  }
  Direction value() const noexcept {
    const double length = std::sqrt(dot(sum, sum));
    if (count == 0 || !(length > 0)) return {};
    Direction d{sum.sin / length, sum.cos / length};
    // on the spot sigma is +90 deg; (sigma, v) and (-sigma, -v) are the same there
    const bool spot = std::abs(d.sin) > kSpotSin;
    if (spot ? d.sin < 0 : d.cos < 0) d = {-d.sin, -d.cos};
    return d;
  }
};

double plane_hub_m_s(std::size_t wheel, double wheel_rad_s, const Feedback& feedback,
                     const Inputs& inputs, bool correction, const Parameters& p) noexcept {
  const double rim = wheel_rad_s * p.geometry.wheel_radius_m;
  if (!correction || !inputs.rocker) return rim;
  return plane_speed_m_s(rim, feedback.steering[wheel], inputs.vx_m_s[wheel], inputs.vz_m_s[wheel],
                         p.correction_sign);
}

// The IMU's speed on the scale of Motion::v_to_hub: on the spot by its yaw rate.
double imu_speed_m_s(const Motion& motion, const Inputs& inputs, const Parameters& p) noexcept {
  if (motion.v_to_hub != 1) return inputs.imu.yaw_rate_rad_s.value * p.parking_length_m;
  return inputs.imu.speed_m_s.value;
}

// Along the motion of the wheels, on the same scale.
double imu_along_m_s(const Motion& motion, const Inputs& inputs, const Parameters& p) noexcept {
  const double speed = imu_speed_m_s(motion, inputs, p);
  if (motion.v_to_hub != 1) return speed;
  return speed * math::cos(motion.sigma_rad - inputs.imu.sigma_rad.value);
}

bool slips(const Motion& motion, const Inputs& inputs, const Parameters& p) noexcept {
  if (!inputs.imu.usable) return false;
  const double v = motion.mean.v_m_s * motion.v_to_hub;
  if (std::abs(v - imu_speed_m_s(motion, inputs, p)) > p.slip_m_s) return true;
  // a direction is defined only with speed
  if (motion.v_to_hub != 1 || std::abs(v) < p.slip_m_s) return false;
  return std::abs(motion.sigma_rad - inputs.imu.sigma_rad.value) > p.slip_sigma_rad;
}

// A rover that slides down across a slope moves in another direction than its wheels, and the IMU
// is right to report it: the velocities must differ by more than that before the IMU is wrong.
bool contradicts(const Motion& motion, const Inputs& inputs, const Parameters& p) noexcept {
  if (!inputs.imu.usable) return false;
  const double v = motion.mean.v_m_s * motion.v_to_hub, imu = imu_speed_m_s(motion, inputs, p);
  if (motion.v_to_hub != 1) return std::abs(v - imu) > p.slip_m_s;
  const double turned_rad = motion.sigma_rad - inputs.imu.sigma_rad.value;
  return v * v + imu * imu - 2 * v * imu * math::cos(turned_rad) > p.slip_m_s * p.slip_m_s;
}

}  // namespace

double v_to_hub(const Direction& d, const Parameters& p) noexcept {
  return std::abs(d.sin) > kSpotSin ? p.parking_length_m / p.geometry.f_m : 1;
}

Motion estimate_motion(const Feedback& feedback, const Inputs& inputs, WheelSet trusted,
                       SteeringSet trusted_steering, bool correction,
                       const Parameters& p) noexcept {
  Motion motion;
  if ((trusted & kAllWheels) == 0) trusted = kAllWheels;
  PerSteered<Direction> directions;
  MeanDirection mean;
  for (std::size_t i = 0; i < kSteered; ++i) {
    const std::size_t wheel = kWheelOfSteered[i];
    directions[i] = direction_from_steering(wheel, feedback.steering[wheel], p.geometry);
    if (contains(trusted_steering, i)) mean.add(directions[i]);
  }
  motion.mean.direction = mean.value();
  const Direction& d = motion.mean.direction;
  motion.sigma_rad = sigma_rad(d);
  motion.v_to_hub = v_to_hub(d, p);
  const bool spot = motion.v_to_hub != 1;

  // least squares: a wheel near the centre of rotation has little weight
  const PerWheel<double> ratio = hub_ratios(d, p.geometry);
  PerWheel<double> hub{};
  double sum = 0, weight = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    hub[i] = plane_hub_m_s(i, feedback.wheel_rad_s[i], feedback, inputs, correction, p);
    if (!contains(trusted, i)) continue;
    sum += hub[i] * ratio[i];
    weight += ratio[i] * ratio[i];
  }
  motion.mean.v_m_s = weight > 0 ? sum / weight : 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const bool says = ratio[i] * ratio[i] * kWheels > 0.1 * weight;
    motion.v_m_s[i] = says ? hub[i] / ratio[i] : motion.mean.v_m_s;
  }

  // E13. As in the thesis, fit wheels are not counted: the mean is made of them.
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (!contains(trusted, i) && incoherent(motion, i, p)) motion.incoherent_speed = true;
  }
  double sine = 0;
  for (const Direction& one : directions) {
    sine = std::max(sine, std::abs(one.sin * d.cos - one.cos * d.sin));
  }
  double apart_rad = math::asin(std::min(sine, 1.0));
  if (spot) apart_rad /= 4;
  motion.incoherent_sigma =
      apart_rad >= p.coherent_sigma_rad && std::abs(motion.mean.v_m_s) * motion.v_to_hub >= 0.010;
  motion.slip = slips(motion, inputs, p);
  motion.ground_m_s = motion.mean.v_m_s;
  if (inputs.imu.usable) {
    const double along = imu_along_m_s(motion, inputs, p);
    motion.slip_m_s = motion.mean.v_m_s * motion.v_to_hub - along;
    motion.ground_m_s = along / motion.v_to_hub;
    const double speed = imu_speed_m_s(motion, inputs, p);
    motion.sliding_m_s = std::sqrt(std::max(speed * speed - along * along, 0.0));
  }
  motion.imu_contradicts = contradicts(motion, inputs, p);
  return motion;
}

bool incoherent(const Motion& motion, std::size_t wheel, const Parameters& p) noexcept {
  const double mean = std::abs(motion.mean.v_m_s) * motion.v_to_hub;
  const double apart = std::abs(motion.mean.v_m_s - motion.v_m_s[wheel]) * motion.v_to_hub;
  const double least = p.agree_rad_s * p.geometry.wheel_radius_m;
  return apart >= std::max(std::min(p.coherent_m_s, p.coherent_share * mean), least);
}

bool imu_confirms(const Motion& motion, std::size_t wheel, double wheel_rad_s,
                  const Feedback& feedback, const Inputs& inputs, bool correction,
                  const Parameters& p) noexcept {
  const double hub = plane_hub_m_s(wheel, wheel_rad_s, feedback, inputs, correction, p);
  const double v = v_from_hub_m_s(wheel, hub, motion.mean.direction, p.geometry) * motion.v_to_hub;
  const double imu = imu_speed_m_s(motion, inputs, p);
  // a wheel that is towed through soil turns more slowly than it moves
  return std::abs(v - imu) <= std::max(p.imu_agree_m_s, p.agree_share * std::abs(imu));
}

}  // namespace lss::gnc::ardito
