#include "tools/lss-sim/talaris/air.h"

#include <cmath>
#include <numbers>

namespace lss::sim::talaris {
namespace {

constexpr double kFlowAt_rpm = 4 * 29'400.0;  // of AirOptions::fan_flow_kg_s
// A gust: one minus cosine, as in airworthiness codes; lengths and pauses drawn (ours).
constexpr int kShortest_ms = 800, kLongest_ms = 3'000, kMostCalm_ms = 4'000;
constexpr double kLeastSize = 0.4, kTurns_rad = 0.5;  // direction, either way

}  // namespace

Air::Air(const AirOptions& options, unsigned seed) : options_(options), random_(seed) {
  steady_along_ = Vector3(0, std::sin(options.to_rad), std::cos(options.to_rad));
  along_ = steady_along_;
  calm_ms_ = std::uniform_int_distribution(0, kMostCalm_ms)(random_);
}

void Air::blow() {
  if (calm_ms_ > 0) {
    gust_ = 0;
    if (--calm_ms_ > 0) return;
    gust_ms_ = 0;
    length_ms_ = std::uniform_int_distribution(kShortest_ms, kLongest_ms)(random_);
    size_ = std::uniform_real_distribution(kLeastSize, 1.0)(random_);
    const double turned = std::uniform_real_distribution(-kTurns_rad, kTurns_rad)(random_);
    along_ = Eigen::AngleAxisd(-turned, Vector3::UnitX()) * steady_along_;
    return;
  }
  ++gust_ms_;
  gust_ = size_ * (1 - std::cos(2 * std::numbers::pi * gust_ms_ / length_ms_)) / 2;
  if (gust_ms_ >= length_ms_)
    calm_ms_ = 1 + std::uniform_int_distribution(0, kMostCalm_ms)(random_);
}

Wrench Air::step(const BodyState& body, double rpm) {
  blow();
  Wrench wrench;
  if (options_.density_kg_m3 <= 0) return wrench;
  const Vector3 past_B = body.attitude.conjugate() * Vector3(wind_m_s() - body.velocity_m_s);
  Vector3 force_N =
      options_.density_kg_m3 / 2 * past_B.norm() * options_.drag_area_m2.cwiseProduct(past_B);
  // what is sucked in sideways leaves along x
  const double flow_kg_s = options_.fan_flow_kg_s * rpm / kFlowAt_rpm;
  force_N += flow_kg_s * Vector3(0, past_B.y(), past_B.z());
  wrench.add(Vector3(options_.centre_m, 0, 0), force_N);
  return wrench;
}

}  // namespace lss::sim::talaris
