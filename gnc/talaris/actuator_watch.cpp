#include "gnc/talaris/actuator_watch.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {
namespace {

// Of the sums: to be condemned, and by how much ahead of any other failure.
constexpr double kCondemned = 14;
constexpr double kAhead = 6;
constexpr double kSuspect = 3;
// What a verdict leaves unexplained: a share of what was, or little (5 degrees of freedom).
constexpr double kLeft = 0.3, kLeftLittle = 16;
constexpr double kMostAgainst = 60;  // of one frame
// Standard deviations without failure: constant part (N, N m), share of the wrench that is
// explained (inertia and thrust are not those of the parameters), share of all that was open.
constexpr double kSigmaLift_N = 9;
constexpr double kSigmaSide_N = 6;
constexpr double kSigmaRoll_Nm = 1;
constexpr double kSigmaTilt_Nm = 1.2;
constexpr double kSigmaShare = 0.35;
constexpr double kSigmaOpen = 0.06;
// What may be unexplained without a failure: mass, centre of mass, wind, fans.
constexpr double kMostLift_N = 40;
constexpr double kMostSide_N = 90;
constexpr double kMostRoll_Nm = 4;
constexpr double kMostTilt_Nm = 7;
constexpr double kLearnFresh = 0.5;
constexpr double kLearn = 0.1;
constexpr double kLearnFailed = 0.3;  // with the least variance
constexpr double kLeastPart = 0.3;    // of the first frame, in which a failure may be
constexpr double kWholeOpen = 0.88, kWholeLeast = 0.7, kWholeMost = 1.2;
constexpr int kBlindFrames = 2;     // after a verdict, until orders follow it
constexpr int kUnheardFrames = 7;   // and until fans that slowed down are back at their speed
constexpr double kSlow_rpm = 1500;  // below its expected speed
constexpr double kRuns_rpm = 6000;  // expected: slower ones are not judged
constexpr double kFollows = 0.5;    // of the way to its expected speed, in the frame: it turns

WrenchB least_variance() noexcept {
  WrenchB sigma;
  sigma << kSigmaLift_N, kSigmaSide_N, kSigmaRoll_Nm, kSigmaTilt_Nm, kSigmaTilt_Nm;
  return sigma.cwiseAbs2();
}

double mean_square(double from, double to) noexcept {
  return (from * from + from * to + to * to) / 3;
}

}  // namespace

double ActuatorWatch::limit() noexcept { return kCondemned; }

ActuatorWatch::ActuatorWatch(const Parameters& parameters) noexcept
    : parameters_(parameters), effect_(effect_of(parameters.thrusters, parameters.fans)) {}

void ActuatorWatch::begin() noexcept {
  health_ = {};
  verdict_ = {};
  unexplained_.setZero();
  suspicion_ = {};
  score_ = 0;
  blind_frames_ = 0;
}

PerFan ActuatorWatch::usable(const PerFan& rpm) const noexcept {
  PerFan left = rpm;
  for (std::size_t i = 0; i < kFans; ++i) {
    if (health_[kValves + i] == Health::weak) left[i] = 0;
  }
  return left;
}

WrenchB ActuatorWatch::explained(const WatchFrame& f) const noexcept {
  Forces force = Forces::Zero();
  for (std::size_t i = 0; i < kValves; ++i) {
    const double share = health_[i] == Health::open   ? 1
                         : health_[i] == Health::shut ? 0
                                                      : f.open_s[i] / kFrame_s;
    force[static_cast<Eigen::Index>(i)] = parameters_.thrusters.force_N * share;
  }
  for (std::size_t i = 0; i < kFans; ++i) {
    if (health_[kValves + i] == Health::weak) continue;
    force[static_cast<Eigen::Index>(kValves + i)] =
        parameters_.fans.thrust_N_per_rpm2 * mean_square(f.rpm_before[i], f.rpm[i]);
  }
  return effect_ * force;
}

WrenchB ActuatorWatch::variance(const WatchFrame& f, const WrenchB& explained) const noexcept {
  WrenchB open = WrenchB::Zero();
  for (std::size_t i = 0; i < kValves; ++i) {
    open += effect_.col(static_cast<Eigen::Index>(i)).cwiseAbs() * parameters_.thrusters.force_N *
            f.open_s[i] / kFrame_s;
  }
  WrenchB share = (explained + unexplained_).cwiseAbs() * kSigmaShare;
  share[kLiftRow] = 0;  // the mass is known better
  share[kSideRow] *= 0.3;
  return least_variance() + share.cwiseAbs2() + (kSigmaOpen * open).cwiseAbs2();
}

void ActuatorWatch::condemn(std::size_t actuator, Health health, double measured,
                            double limit) noexcept {
  health_[actuator] = health;
  verdict_ = {actuator, health, measured, limit};
  suspicion_ = {};
  score_ = 0;
  blind_frames_ = kBlindFrames;
}

// By its speed, with the lag of fan and controller in what is expected. Several at once are their
// node, or its orders.
bool ActuatorWatch::watch_speeds(const WatchFrame& f) noexcept {
  if (!f.speeds) return false;
  std::size_t slow = 0, which = 0;
  for (std::size_t i = 0; i < kFans; ++i) {
    if (health_[kValves + i] != Health::good || f.rpm_expected[i] < kRuns_rpm) continue;
    if (f.rpm[i] >= f.rpm_expected[i] - kSlow_rpm) continue;
    ++slow;
    which = i;
  }
  if (slow > 1) blind_frames_ = kUnheardFrames;
  if (slow != 1) return false;
  // Orders after a verdict speed fans up at once: a healthy one may be late.
  const double way_rpm = f.rpm_expected[which] - f.rpm_before[which];
  if (f.rpm[which] - f.rpm_before[which] >= kFollows * way_rpm) return false;
  condemn(kValves + which, Health::dead, f.rpm[which], f.rpm_expected[which] - kSlow_rpm);
  return true;
}

void ActuatorWatch::step(const WatchFrame& f) noexcept {
  verdict_ = {};
  if (f.unheard) {
    blind_frames_ = kUnheardFrames;
    suspicion_ = {};
    score_ = 0;
    return;
  }
  if (blind_frames_ <= kBlindFrames && watch_speeds(f)) return;
  if (!f.measured || !f.speeds) return;
  const Body& body = parameters_.body;
  const Vector3 inertia(body.inertia_x_kg_m2, body.inertia_y_kg_m2, body.inertia_z_kg_m2);
  const Vector3 mean = (f.rate_B_rad_s + f.rate_before_B_rad_s) / 2;
  const Vector3 turns = inertia.cwiseProduct(f.rate_B_rad_s - f.rate_before_B_rad_s) / kFrame_s +
                        mean.cross(inertia.cwiseProduct(mean).eval());
  WrenchB felt;
  felt << f.mass_kg * f.force_B_m_s2.x(), f.mass_kg * f.force_B_m_s2.z(), turns.x(), turns.y(),
      turns.z();
  const WrenchB known = explained(f);
  const WrenchB odd = felt - known - unexplained_;
  if (!odd.allFinite()) return;
  if (!f.fresh) judge(f, odd, variance(f, known));
  if (verdict_.health == Health::good && blind_frames_ > 0) --blind_frames_;
  if (verdict_.health != Health::good) return;
  if (score_ >= kSuspect && !f.fresh) return;
  WrenchB learn = WrenchB::Constant(f.fresh ? kLearnFresh : kLearn);
  // By a failure it turns fast: by how much it turns faster than expected is no push that lasts.
  if (!f.fresh && !good())
    learn = kLearnFailed * least_variance().cwiseQuotient(variance(f, known));
  WrenchB most;
  most << kMostLift_N, kMostSide_N, kMostRoll_Nm, kMostTilt_Nm, kMostTilt_Nm;
  unexplained_ = (unexplained_ + learn.cwiseProduct(odd)).cwiseMax(-most).cwiseMin(most);
}

void ActuatorWatch::judge(const WatchFrame& f, const WrenchB& odd,
                          const WrenchB& variance) noexcept {
  const WrenchB weight = variance.cwiseInverse();
  struct Best {
    double score = 0, part = 0, force_N = 0, ordered_N = 0, left = 0;
    std::size_t actuator = 0;
    Health health = Health::good;
  } best;
  double second = 0;
  const double all = odd.cwiseAbs2().dot(weight);
  // `force_N`: by which the actuator would differ from its order. `whole`: in all of the frame.
  const auto weigh = [&](double& sum, std::size_t i, Health health, double force_N,
                         double ordered_N, bool whole) {
    const WrenchB signature = effect_.col(static_cast<Eigen::Index>(i)) * force_N;
    const double size = signature.cwiseAbs2().dot(weight);
    if (!(size > 0)) return;
    const double found = odd.cwiseProduct(signature).dot(weight) / size;
    const double part = whole || sum > kSuspect ? 1 : std::clamp(found, kLeastPart, 1.0);
    const double adds = size * part * (found - part / 2);
    sum = std::max(sum + std::max(adds, -kMostAgainst), 0.0);
    if (sum > best.score) {
      second = std::max(second, best.score);
      best = {sum, found, force_N, ordered_N, all - size * found * found, i, health};
    } else {
      second = std::max(second, sum);
    }
  };
  for (std::size_t i = 0; i < kActuators; ++i) {
    Suspicion& s = suspicion_[i];
    const double full_N = parameters_.thrusters.force_N;
    // A valve that was stuck may be free again. It gets no orders: then it is shut. By more than
    // half of its thrust, else one that is partly open would change without end.
    if (health_[i] == Health::open) weigh(s.shut, i, Health::shut, -full_N, full_N, true);
    if (health_[i] == Health::shut) weigh(s.open, i, Health::open, full_N, 0, true);
    if (health_[i] != Health::good || blind_frames_ > 0) continue;
    if (i < kValves) {
      const double ordered_N = full_N * f.open_s[i] / kFrame_s;
      weigh(s.open, i, Health::open, full_N - ordered_N, ordered_N, false);
      weigh(s.shut, i, Health::shut, -ordered_N, ordered_N, true);
    } else {
      const double thrust_N = parameters_.fans.thrust_N_per_rpm2 *
                              mean_square(f.rpm_before[i - kValves], f.rpm[i - kValves]);
      weigh(s.weak, i, Health::weak, -thrust_N, thrust_N, false);
    }
  }
  // A side valve that stays shut is like the one beside it stuck open for a part of the frame: only
  // the whole thrust is that of an open one, and the whole pulse that of one that stays shut.
  const bool side = best.actuator < kValves && best.actuator % 2 == 1;
  const bool whole = best.health == Health::open
                         ? best.part >= kWholeOpen
                         : best.part >= kWholeLeast && best.part <= kWholeMost;
  score_ = best.score;
  if (best.score < kCondemned || best.score - second < kAhead || (side && !whole) ||
      best.left > std::max(kLeft * all, kLeftLittle))
    return;
  condemn(best.actuator, best.health, best.ordered_N + best.part * best.force_N, best.ordered_N);
}

}  // namespace lss::gnc::talaris
