#include "gnc/talaris/checked_navigation.h"

#include <cmath>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

constexpr int kGatedFrames = 10;      // without a sample that is used; later it might pass again
constexpr double kUnsure_m_s = 0.03;  // beside sigma: shocks and slipping at lift-off

bool contradict(const NavState& a, const NavState& b, double sigmas) noexcept {
  for (const int axis : {1, 2}) {
    const double sigma = math::hypot(b.velocity_sigma_m_s(axis), kUnsure_m_s);
    if (!(std::abs(a.velocity_N_m_s(axis) - b.velocity_N_m_s(axis)) <= sigmas * sigma)) return true;
  }
  return false;
}

}  // namespace

void CheckedNavigation::begin_calibration() noexcept {
  with_.begin_calibration();
  doubted_ = false;
  gated_ = 0;
}

const CalibrationStatus& CheckedNavigation::calibrate(const Batch& batch) noexcept {
  with_.calibrate(batch);
  without_ = with_;
  return with_.calibration();
}

const NavState& CheckedNavigation::step(const Batch& batch, bool standing, bool slides) noexcept {
  const NavigationParameters& p = with_.parameters();
  Batch blind = batch;
  blind.flows = {};
  const NavCounters before = with_.counters();
  with_.step(doubted_ ? blind : batch, standing, slides);
  if (!p.camera || doubted_ || !with_.aligned()) return with_.state();
  without_.step(blind, standing, slides);
  if (with_.counters().flows_gated != before.flows_gated) ++gated_;
  if (with_.counters().flows_used != before.flows_used) gated_ = 0;
  doubted_ = gated_ >= kGatedFrames || contradict(with_.state(), without_.state(), p.gate_sigma);
  if (doubted_) with_ = without_;
  return with_.state();
}

}  // namespace lss::gnc::talaris
