#include "gnc/ardito/decision.h"

#include <cmath>

namespace lss::gnc::ardito {

Mode next_mode(Mode mode, const ModeInputs& in, const Parameters& p) noexcept {
  const bool moves = std::abs(in.speed) > p.min_speed;
  switch (mode) {
    case Mode::running: return !moves || in.parking || in.error ? Mode::stop : Mode::running;
    case Mode::parking: return !moves || !in.parking || in.error ? Mode::stop : Mode::parking;
    default:
      if (!moves || in.busy || in.error || in.delta_sigma_rad > p.steady_sigma_rad) {
        return Mode::stop;
      }
      return in.parking ? Mode::parking : Mode::running;
  }
}

StopPhase next_phase(StopPhase phase, const StopInputs& in, const Parameters& p) noexcept {
  const bool stands = in.fastest_rad_s < p.standing_rad_s;
  const bool steered = in.largest_angle_rad <= p.steered_rad;
  switch (phase) {
    case StopPhase::rover_stop:
      if (!stands) return StopPhase::deceleration;
      return steered ? StopPhase::rover_stop : StopPhase::rover_steer;
    case StopPhase::rover_steer: return steered ? StopPhase::rover_stop : StopPhase::rover_steer;
    case StopPhase::deceleration: return stands ? StopPhase::rover_steer : StopPhase::deceleration;
    default:
      if (!stands) return StopPhase::begin;
      return steered ? StopPhase::rover_stop : StopPhase::rover_steer;
  }
}

}  // namespace lss::gnc::ardito
