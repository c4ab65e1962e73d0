#include "gnc/talaris/corridor.h"

#include <algorithm>
#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kSigmas = 2;

// What navigation cannot exclude; after a gap of the IMU that may be anything, and alone it ends no
// flight.
double unsure(double sigma, double limit) noexcept { return std::min(kSigmas * sigma, limit / 2); }

double horizontal(const Vector3& v) noexcept { return math::hypot(v.y(), v.z()); }

}  // namespace

void Corridor::begin(const Vector3& from, const Vector3& to, double seconds) noexcept {
  from_ = from;
  to_ = to;
  length_s_ = std::max(seconds, kFrame_s);
  passed_s_ = 0;
  stops_ = false;
}

void Corridor::stop(const Vector3& at, const Vector3& speed, double seconds) noexcept {
  begin(at, at, seconds);
  stops_ = true;
  speed_ = speed;
}

void Corridor::step() noexcept { passed_s_ = std::min(passed_s_ + kFrame_s, length_s_); }

Vector3 Corridor::place_N_m() const noexcept {
  const double share = passed_s_ / length_s_;
  if (stops_) return from_ + share * (1 - share / 2) * length_s_ * speed_;
  return from_ + share * share * (3 - 2 * share) * (to_ - from_);
}

Vector3 Corridor::speed_N_m_s() const noexcept {
  const double share = passed_s_ / length_s_;
  if (stops_) return (1 - share) * speed_;
  return 6 * share * (1 - share) / length_s_ * (to_ - from_);
}

Judgement Corridor::judge(const NavState& state, double tilt_rad, double flown_s, double planned_s,
                          double wind_m_s2, const Limits& limits) const noexcept {
  Judgement result;
  double worst = 1;
  const auto look = [&](Off what, double measured, double limit) {
    if (!(measured / limit > worst)) return;
    worst = measured / limit;
    result.off = what;
    result.measured = measured;
    result.limit = limit;
  };
  const Vector3 off_m = state.position_N_m - place_N_m();
  const Vector3 off_m_s = state.velocity_N_m_s - speed_N_m_s();
  const double side_m = horizontal(off_m), speed_m_s = horizontal(off_m_s);
  look(Off::side,
       side_m + unsure(state.position_sigma_m.tail<2>().maxCoeff(), limits.corridor_side_m),
       limits.corridor_side_m);
  look(Off::height,
       std::abs(off_m.x()) + unsure(state.position_sigma_m.x(), limits.corridor_height_m),
       limits.corridor_height_m);
  look(Off::speed,
       speed_m_s + unsure(state.velocity_sigma_m_s.tail<2>().maxCoeff(), limits.corridor_m_s),
       limits.corridor_m_s);
  look(Off::tilt,
       tilt_rad + unsure(state.attitude_sigma_rad.tail<2>().maxCoeff(), limits.corridor_tilt_rad),
       limits.corridor_tilt_rad);
  look(Off::late, flown_s - planned_s, limits.corridor_late_s);
  look(Off::wind, wind_m_s2, limits.wind_m_s2);
  result.wavers = side_m > limits.waver_m || speed_m_s > limits.waver_m_s;
  result.back = side_m < limits.waver_m / 2 && speed_m_s < limits.waver_m_s / 2;
  return result;
}

}  // namespace lss::gnc::talaris
