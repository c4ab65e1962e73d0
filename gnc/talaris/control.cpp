#include "gnc/talaris/control.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kCollectBelow_rad = 5 * kDegree;  // by the integral
// Of the disturbance: 10 mm of the centre of mass with 30 % less inertia. Off the ground the
// observer follows by a share of the difference over the second, up to the third.
constexpr double kMostDisturbance_rad_s2 = 4, kSurprise_rad_s2 = 1, kMostShare = 0.8;

}  // namespace

double wrapped(double angle_rad) noexcept {
  return std::isfinite(angle_rad) ? std::remainder(angle_rad, 2 * std::numbers::pi) : 0;
}

Attitude attitude_of(const Quaternion& q_NB) noexcept {
  // the vertical in the body frame: (cos, -sin about z, sin about y) for small tilts
  const Vector3 up_B = q_NB.conjugate() * Vector3::UnitX();
  Attitude a;
  a.cosine = up_B.x();
  a.tilt_y_rad = math::atan2(up_B.z(), up_B.x());
  a.tilt_z_rad = math::atan2(-up_B.y(), up_B.x());
  a.roll_rad = wrapped(2 * math::atan2(q_NB.x(), q_NB.w()));
  return a;
}

void Control::begin() noexcept {
  jets_.reset();
  integral_y_ = integral_z_ = 0;
  saturated_ = 0;
  last_ = before_ = {};
  disturbance_y_ = disturbance_z_ = 0;
  observed_ = false;
}

// Of pulses of a frame: the part after that frame's end, or the part in it.
Vector3 Control::impulse_N_m_s(const std::array<Pulse, kValves>& pulses, bool late) const noexcept {
  const Thrusters& t = parameters_.thrusters;
  const auto open = [&](const Pulse& pulse) {
    const double rest = remaining_s(pulse, parameters_.offset_s, t.lag_s);
    return t.force_N * (late ? rest : pulse.on_s - rest);
  };
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < 4; ++i) {
    const double lift = open(pulses[2 * i]), side = open(pulses[2 * i + 1]);
    sum += Vector3(kSideY[i] * kSidePush[i] * t.side_y_m * side, kLiftZ[i] * t.lift_z_m * lift,
                   -kLiftY[i] * t.lift_y_m * lift);
  }
  return sum;
}

double Control::side_N() const noexcept {
  const Thrusters& t = parameters_.thrusters;
  double sum_N_s = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    const Pulse &last = last_[2 * i + 1], &before = before_[2 * i + 1];
    const double open_s = last.on_s - remaining_s(last, parameters_.offset_s, t.lag_s) +
                          remaining_s(before, parameters_.offset_s, t.lag_s);
    sum_N_s += kSidePush[i] * t.force_N * open_s;
  }
  return sum_N_s / kFrame_s;
}

// Unequal fans and a CM off the centre turn the vehicle before the integral has seen much of an
// angle. The change of rate in the last frame, less that of its pulses, shows it at once.
void Control::observe(const Vector3& rate, bool fresh, bool unheard) noexcept {
  const Vector3 pulses = impulse_N_m_s(last_, false) + impulse_N_m_s(before_, true);
  if (observed_ && !unheard) {
    const double share = gains_.attitude_observer;
    const auto follow = [&](double& known, double changed, double impulse, double inertia) {
      const double now = (changed - impulse / inertia) / kFrame_s;
      if (!std::isfinite(now)) return;
      const double surprise = std::min(std::abs(now - known) / kSurprise_rad_s2, kMostShare);
      const double learned = fresh && share > 0 ? std::max(share, surprise) : share;
      known = std::clamp(known + learned * (now - known), -kMostDisturbance_rad_s2,
                         kMostDisturbance_rad_s2);
    };
    follow(disturbance_y_, rate.y() - rate_before_.y(), pulses.y(),
           parameters_.body.inertia_y_kg_m2);
    follow(disturbance_z_, rate.z() - rate_before_.z(), pulses.z(),
           parameters_.body.inertia_z_kg_m2);
  }
  rate_before_ = rate;
  observed_ = true;
}

ControlOutput Control::step(const NavState& state, const ControlTarget& target) noexcept {
  const Thrusters& t = parameters_.thrusters;
  const Body& body = parameters_.body;
  const double ahead = parameters_.offset_s + kFrame_s / 2;
  ControlOutput out;

  const Attitude now = attitude_of(state.q_NB);
  observe(state.rate_B_rad_s, target.fresh, target.unheard);
  const Vector3 pending = impulse_N_m_s(last_, true);
  const Vector3 rate = state.rate_B_rad_s + Vector3(pending.x() / body.inertia_x_kg_m2,
                                                    pending.y() / body.inertia_y_kg_m2,
                                                    pending.z() / body.inertia_z_kg_m2);
  out.error_rad.x() = wrapped(now.roll_rad + rate.x() * ahead - target.roll_rad);
  out.error_rad.y() = now.tilt_y_rad + rate.y() * ahead - target.tilt_y_rad;
  out.error_rad.z() = now.tilt_z_rad + rate.z() * ahead - target.tilt_z_rad;

  const double wn = gains_.attitude_wn_rad_s, zeta = gains_.attitude_zeta;
  if (target.lift) {
    double alpha_y = 0, alpha_z = 0;
    if (target.attitude) {
      // an error that cannot be corrected now, or is a commanded turn, is not integrated
      const double limit = gains_.attitude_max_integral_rad_s2 / gains_.attitude_ki_1_s3;
      const auto collect = [&](double& integral, double error) {
        const bool grows = integral * error > 0;
        if (std::abs(error) < kCollectBelow_rad && !(saturated_ > 0.5 && grows)) {
          integral = std::clamp(integral + error * kFrame_s, -limit, limit);
        }
      };
      collect(integral_y_, out.error_rad.y());
      collect(integral_z_, out.error_rad.z());
      const auto pid = [&](double error, double w, double integral) {
        return -wn * wn * error - 2 * zeta * wn * w - gains_.attitude_ki_1_s3 * integral;
      };
      alpha_y = pid(out.error_rad.y(), rate.y(), integral_y_) - disturbance_y_;
      alpha_z = pid(out.error_rad.z(), rate.z(), integral_z_) - disturbance_z_;
    }
    const double cosine = std::max(now.cosine, 0.5);
    const LiftPulses lift =
        allocate_lift(target.force_N.x() / cosine, body.inertia_y_kg_m2 * alpha_y,
                      body.inertia_z_kg_m2 * alpha_z, t, target.full);
    saturated_ = 1 - lift.share;
    out.lift_N = 4 * t.force_N * lift.mean_s / kFrame_s;
    for (std::size_t i = 0; i < 4; ++i)
      out.valve[2 * i] = spaced(lift.on_s[i], last_[2 * i], t.min_on_s);
  }

  if (target.side || target.roll) {
    const double c = math::cos(now.roll_rad), s = math::sin(now.roll_rad);
    const double force_z = target.side ? c * target.force_N.z() - s * target.force_N.y() : 0;
    RollFire fire;
    double alpha_x = 0;
    if (target.roll) {
      fire = phase_plane(out.error_rad.x(), rate.x(), t.force_N, body, t, gains_);
      alpha_x = -wn * wn * out.error_rad.x() - 2 * zeta * wn * rate.x();
    }
    const std::array<double, 4> on = jets_.step(force_z, alpha_x, fire, body, t, gains_);
    for (std::size_t i = 0; i < 4; ++i)
      out.valve[2 * i + 1] = spaced(on[i], last_[2 * i + 1], t.min_on_s);
  } else {
    jets_.reset();
  }
  before_ = last_;
  last_ = out.valve;
  return out;
}

}  // namespace lss::gnc::talaris
