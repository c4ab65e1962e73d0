// Is the flight inside its corridor, and was it as planned?

#include <algorithm>

#include "gnc/math.h"
#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris {
namespace {

constexpr double kSure = 3;
constexpr double kAlong = 2.0 / 3;  // of a push along z, beside one along y
constexpr double kStill_s = 0.4;    // on the ground: then navigation's velocity is its error
constexpr double kFelt_m_s = 0.15;  // less may be an error of the expected lift
// The first foot turns the vehicle: the opposite one comes down faster. Of a plastic impact of one
// corner, legs 0.3 and 0.4 m out, 45 kg and the inertia of the parameters: 1.65. Programs by fans
// alone: 1.24 was measured, in the median of 18 descents (docs/gnc-talaris.md).
constexpr double kLastFoot = 1.65, kLastFootByFans = 1.3;
constexpr double kUnsure_m_s = 0.05;  // of the speeds at touchdown: the frame is not the moment

}  // namespace

// Only what a plan still governs; the first thing that left the corridor is remembered.
void Flight::watch_corridor() noexcept {
  const bool planned =
      airborne_ && plan_.request.program == Program::hop && reaction_ <= Reaction::hold;
  now_judged_ = {};
  if (!planned) return;
  corridor_.step();
  if (!heard_) return;
  const Attitude attitude = attitude_of(state_.q_NB);
  // it may begin on a slope, and lean against the wind
  const double tilt_y = attitude.tilt_y_rad - lean_y_rad_,
               tilt_z = attitude.tilt_z_rad - lean_z_rad_;
  // against what blows along z the jets help
  const double c = math::cos(attitude.roll_rad), s = math::sin(attitude.roll_rad);
  const double push_m_s2 = math::hypot(c * wind_m_s2_.y() + s * wind_m_s2_.z(),
                                       kAlong * (c * wind_m_s2_.z() - s * wind_m_s2_.y()));
  now_judged_ = corridor_.judge(state_, math::hypot(tilt_y, tilt_z), flown_s_,
                                plan_.total_s + extra_s_, push_m_s2, parameters_.limits);
  if (judgement_.off == Off::none && now_judged_.off != Off::none) judgement_ = now_judged_;
}

void Flight::fall_short(Shortfall why) noexcept {
  if (shortfall_ == Shortfall::none) shortfall_ = why;
}

void Flight::note_contact() noexcept {
  before_contact_ = before_;
  after_contact_[0] = swing();
  moved_frames_ = 1;
  airborne_ = false;
  enter(Phase::touchdown);
}

// Once it is still its velocity is zero: what navigation has then is its error, and what it had
// before contact was wrong by as much. One that slides on has its velocity.
void Flight::note_touchdown() noexcept {
  if (!speed_noted_ && moved_frames_ < after_contact_.size())
    after_contact_[moved_frames_++] = swing();
  const bool ends = phase_s_ >= parameters_.limits.run_down_s;
  if (speed_noted_ || (touchdown_.still_s() < kStill_s && !ends)) return;
  speed_noted_ = touchdown_.still_s() >= kStill_s;
  const Vector3 error = speed_noted_ ? state_.velocity_N_m_s : Vector3(Vector3::Zero());
  touchdown_m_s_ = impact_m_s_;
  touchdown_side_m_s_ = 0;
  const auto passes = [&](const Swing& v) {
    const Vector3 most = (v.least_m_s - error).cwiseAbs().cwiseMax((v.most_m_s - error).cwiseAbs());
    touchdown_side_m_s_ = std::max(touchdown_side_m_s_, most.tail<2>().norm());
    touchdown_m_s_ = std::max(touchdown_m_s_, v.foot_down_m_s + error.x());
  };
  const double last = plan_.request.program == Program::hop ? kLastFoot : kLastFootByFans;
  for (const Speed& v : before_contact_) {
    touchdown_m_s_ =
        std::max(touchdown_m_s_, last * ((error - v.N_m_s).x() + v.falls_m_s) + v.foot_m_s);
    passes({v.N_m_s, v.N_m_s});
  }
  // Seen late, the contact was in the frame before. Then it may come off the ground again, or
  // slide.
  passes(before_contact_[1].in_frame);
  for (std::size_t i = 0; i < moved_frames_; ++i) passes(after_contact_[i]);
  if (impact_m_s_ < kFelt_m_s) return;
  for (const Speed& v : before_impact_) passes({v.N_m_s, v.N_m_s});
}

void Flight::judge_landing() noexcept {
  if (!plan_.flies || reaction_ > Reaction::hold) return;
  const Limits& limits = parameters_.limits;
  const double tilt = math::acos(std::clamp(attitude_of(state_.q_NB).cosine, -1.0, 1.0));
  if (!(tilt <= limits.upright_rad)) fall_short(Shortfall::fallen);
  const double hardest_m_s = touchdown_m_s_ + kUnsure_m_s;
  if (!(hardest_m_s <= limits.touchdown_m_s)) fall_short(Shortfall::hard);
  const Program program = plan_.request.program;
  if (program != Program::hop && program != Program::parachute) return;  // held by a stand
  if (!(touchdown_side_m_s_ + kUnsure_m_s <= limits.touchdown_side_m_s))
    fall_short(Shortfall::sideways);
  if (program != Program::hop) return;  // by fans alone nothing controls the place
  const Vector3 off = state_.position_N_m - goal_m_;
  off_m_ = math::hypot(off.y(), off.z());
  off_sigma_m_ = state_.position_sigma_m.tail<2>().maxCoeff();
  const double sure = off_m_ + kSure * off_sigma_m_;
  if (!(sure <= limits.place_m)) fall_short(Shortfall::place);
}

}  // namespace lss::gnc::talaris
