#include "daemon/vehicles/zebro/report_check.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "idl/angles.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

constexpr double kRound_rad = 2 * std::numbers::pi;

// A module turns at 117 deg/s at most. The play covers a reply that a busy machine stamped 250 ms
// late.
constexpr double kFastest_rad_s = 150 * kDegree;
constexpr double kPlay_rad = 30 * kDegree;
constexpr TimeNs kGap = 300 * kMillisecond;  // after a longer silence a status begins again
constexpr TimeNs kWindow = 2 * kSecond;
constexpr int kMostRefused = 2;  // in a window; one more is a fault
// A frame whose check fits by chance is one in a million on a noisy line.

constexpr double kSensor_rad = std::numbers::pi;  // of a leg
constexpr double kAtSensor_rad = 13 * kDegree;    // flag 6 is on 3 deg to either side

// The order is on the wire and in the leg: bus cycle, two re-sends, acceleration.
constexpr TimeNs kReaction = 400 * kMillisecond;
constexpr double kStretch_rad = 6 * kDegree;  // of the ramp, after which it must have moved
constexpr double kLeastShare = 0.25;          // of the stretch
constexpr double kNear_rad = 2 * kStretch_rad;
constexpr double kWrongWay_rad = 20 * kDegree;
constexpr TimeNs kFresh = kLongestPeriod + 10 * kMillisecond;  // age of a status that counts
constexpr TimeNs kStillFor = 150 * kMillisecond;
constexpr double kGoBack_rad = 5 * kDegree;  // docs/icd-zebro.md section 6
constexpr double kHottest_degC = 200;

double off_rad(double a_rad, double b_rad) noexcept {
  return std::abs(std::remainder(a_rad - b_rad, kRound_rad));
}
double turn_limit_rad(TimeNs elapsed) noexcept {
  return kPlay_rad + kFastest_rad_s * static_cast<double>(elapsed) * 1e-9;
}

}  // namespace

FaultId fault_of(ReportCheck::Finding finding) noexcept {
  using Finding = ReportCheck::Finding;
  switch (finding) {
    case Finding::impossible: return faults::report_impossible;
    case Finding::jumps: return faults::position_jumps;
    case Finding::still: return faults::leg_still;
    case Finding::slips: return faults::gear_slips;
    case Finding::none: break;
  }
  return FaultId::none;
}

void Lateness::heard(TimeNs time, double uptime_s) noexcept {
  constexpr TimeNs kNoise = 25 * kMillisecond;  // of a reply in time: within a bus cycle
  constexpr double kClocks = 0.002;             // LC and modules, docs/icd-zebro.md section 1
  const auto up_ns = static_cast<TimeNs>(uptime_s * 1e9);
  const TimeNs booted_ns = time - up_ns;
  const TimeNs apart_ns =
      static_cast<TimeNs>(kClocks * static_cast<double>(time - std::exchange(heard_ns_, time)));
  const bool restarted = booted_ns_ == 0 || up_ns < up_ns_;
  booted_ns_ = restarted ? booted_ns : std::min(booted_ns_ + apart_ns, booted_ns);
  up_ns_ = up_ns;
  late_ns_ = booted_ns - booted_ns_ > kNoise ? booted_ns - booted_ns_ : 0;
}

void ReportCheck::find(Finding finding, double measured, double limit, TimeNs time) noexcept {
  finding_ = finding;
  found_ns_ = time;
  measured_ = measured;
  limit_ = limit;
}

ReportCheck::Use ReportCheck::refuse(Finding finding, double measured, double limit, TimeNs time,
                                     Use use) noexcept {
  if (refused_ == 0 || time - window_ns_ > kWindow) {
    refused_ = 0;
    window_ns_ = time;
  }
  if (++refused_ > kMostRefused) find(finding, measured, limit, time);
  return use;
}

ReportCheck::Use ReportCheck::take(const Health& health, TimeNs time) noexcept {
  if (possible(health)) return Use::all;
  return refuse(Finding::impossible, health.temperature_degC, kHottest_degC, time, Use::nothing);
}

ReportCheck::Use ReportCheck::take(const Status& status, TimeNs time, bool leg) noexcept {
  if (!possible(status)) {
    const bool turns = std::abs(status.velocity_rad_s) > kFastest_rad_s;
    return refuse(Finding::impossible,
                  (turns ? status.velocity_rad_s : status.position_rad) / kDegree, 360, time,
                  Use::nothing);
  }
  const bool calibrated = (status.flags & last_flags_ & kFlagCalibrated) != 0;
  // Its count begins at another place, for a good reason.
  const bool counts_again = last_ns_ == 0 || time - last_ns_ > kGap ||
                            (status.flags & kFlagReset) != 0 ||
                            ((status.flags ^ last_flags_) & kFlagCalibrated) != 0;
  const double jump_rad = off_rad(status.position_rad, last_rad_);
  const double limit_rad = turn_limit_rad(time - last_ns_);
  const double from_sensor_rad = off_rad(status.position_rad, kSensor_rad);
  if (leg && calibrated && !counts_again && (status.flags & kFlagHallSensor) != 0 &&
      from_sensor_rad > kAtSensor_rad) {
    find(Finding::slips, from_sensor_rad / kDegree, kAtSensor_rad / kDegree, time);
  } else if (!counts_again && jump_rad > limit_rad) {
    const bool stays = strange_ns_ != 0 && off_rad(status.position_rad, strange_rad_) <=
                                               turn_limit_rad(time - strange_ns_);
    strange_ns_ = time;
    strange_rad_ = status.position_rad;
    refuse(Finding::jumps, jump_rad / kDegree, limit_rad / kDegree, time, Use::flags);
    if (!stays) return Use::flags;
    find(Finding::jumps, jump_rad / kDegree, limit_rad / kDegree, time);
  }
  if (counts_again) under_way_ = false;
  strange_ns_ = 0;
  last_ns_ = time;
  last_rad_ = status.position_rad;
  last_flags_ = status.flags;
  return Use::all;
}

// Angle from the present position to that of the order, in its sense, as the module turns it.
void ReportCheck::begin_order(const ModuleOrder& order, const Status& status, TimeNs now) noexcept {
  const double sense = order.kind == ModuleOrder::Kind::rotate_forward ? 1 : -1;
  const double to_rad = order.position_cdeg * 0.01 * kDegree;
  double way_rad = std::fmod(sense * (to_rad - status.position_rad) + 2 * kRound_rad, kRound_rad);
  if (way_rad > kRound_rad - kGoBack_rad) way_rad -= kRound_rad;
  way_rad_ = sense * way_rad;
  begun_ns_ = now;
  due_ns_ = order.arrive_ns;
  seen_rad_ = status.position_rad;
  travelled_rad_ = base_expected_rad_ = base_travelled_rad_ = 0;
  still_ns_ = 0;
  under_way_ = true;
}

void ReportCheck::follow(const ModuleOrder& order, const Status& status, TimeNs status_ns,
                         TimeNs now) noexcept {
  const bool on = (status.flags & kFlagMotionControl) != 0;
  const bool again = order.serial != serial_;
  serial_ = order.serial;
  if (!order.rotates() || !on) {
    under_way_ = false;  // it begins when the motor is on
    return;
  }
  if (again || !under_way_) return begin_order(order, status, now);
  const double moved_rad = std::remainder(status.position_rad - seen_rad_, kRound_rad);
  seen_rad_ = status.position_rad;
  travelled_rad_ += way_rad_ < 0 ? -moved_rad : moved_rad;
  if (now - status_ns > kFresh) return;

  const double way_rad = std::abs(way_rad_);
  const auto duration = static_cast<double>(std::max<TimeNs>(due_ns_ - begun_ns_, 1));
  const double share = static_cast<double>(now - kReaction - begun_ns_) / duration;
  const double expected_rad = way_rad * std::clamp(share, 0.0, 1.0);
  const bool near = std::abs(way_rad - travelled_rad_) < kNear_rad;
  const bool wrong = travelled_rad_ < -kWrongWay_rad;
  const double stretch_rad = expected_rad - base_expected_rad_;
  if (!wrong && (near || stretch_rad < kStretch_rad)) return;
  const double done_rad = travelled_rad_ - base_travelled_rad_;
  if (!wrong && done_rad >= kLeastShare * std::min(stretch_rad, kStretch_rad)) {
    base_expected_rad_ = expected_rad;
    base_travelled_rad_ = travelled_rad_;
    still_ns_ = 0;
    return;
  }
  if (still_ns_ == 0) still_ns_ = now;
  if (now - still_ns_ >= kStillFor)
    find(Finding::still, done_rad / kDegree, stretch_rad / kDegree, now);
}

}  // namespace lss::zebro
