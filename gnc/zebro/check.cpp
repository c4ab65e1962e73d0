// Checks the parameters. Runs once, before the loop.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <string_view>

#include "gnc/math.h"
#include "gnc/zebro/locomotion.h"

namespace lss::gnc::zebro {

namespace {

// A sentence with numbers in it, truncated at the end of the buffer.
class Sentence {
 public:
  Sentence& operator<<(std::string_view text) noexcept {
    for (const char c : text) {
      if (end_ + 1 < text_.size()) text_[end_++] = c;
    }
    return *this;
  }
  Sentence& operator<<(double value) noexcept {
    std::array<char, 32> digits{};
    const auto result =
        std::to_chars(digits.begin(), digits.end(), value, std::chars_format::general, 4);
    return *this << std::string_view(digits.data(),
                                     static_cast<std::size_t>(result.ptr - digits.data()));
  }
  const char* finish() noexcept {
    text_[end_] = '\0';
    return text_.data();
  }
  void clear() noexcept { end_ = 0; }

 private:
  std::array<char, 240> text_{};
  std::size_t end_ = 0;
};

thread_local Sentence sentence;

constexpr double kRounding = 1e-9;

const char* check_values(const LocomotionParameters& p) noexcept {
  struct Value {
    const char* name;
    double value;
    double low, high;  // both included
  };
  constexpr double kSmallest = 1e-6;
  constexpr double kLongest_s = 60;  // a leg module counts its time in 16 bits of milliseconds
  const Value values[] = {
      {"flight_s", p.flight_s, kSmallest, kLongest_s},
      {"stance_min_s", p.stance_min_s, kSmallest, kLongest_s},
      {"double_stance_s", p.double_stance_s, 0, kLongest_s},
      {"sweep_rad", p.sweep_rad, kSmallest, kPi},
      {"offset_rad", p.offset_rad, -kPi / 2, kPi / 2},
      {"start_delay_s", p.start_delay_s, 0, kLongest_s},
      {"stand_up_s", p.stand_up_s, kSmallest, kLongest_s},
      {"lay_down_s", p.lay_down_s, kSmallest, kLongest_s},
      {"lift_s", p.lift_s, kSmallest, kLongest_s},
      {"align_s", p.align_s, kSmallest, kLongest_s},
      {"leg_diameter_m", p.leg_diameter_m, 1e-3, 10},
      {"track_m", p.track_m, 1e-3, 10},
      {"belly_height_m", p.belly_height_m, 1e-4, 10},
      {"swing_limit_rad_s", p.swing_limit_rad_s, kSmallest, 100},
      {"arrived_rad", p.arrived_rad, 1e-4, 0.5},
      {"late_limit_s", p.late_limit_s, kSmallest, kLongest_s},
  };
  for (const Value& v : values) {
    if (v.value >= v.low && v.value <= v.high) continue;  // false for NaN
    return (sentence << v.name << " = " << v.value << " is outside " << v.low << " to " << v.high)
        .finish();
  }
  return nullptr;
}

// Uses the algebra, not the closed form: the cycle mean of the gait's own matrix against the ring
// of its groups.
const char* check_gait(const char* name, const Partition& gait, const GaitTimes& times) noexcept {
  const std::optional<max_plus::Matrix> a = system_matrix(gait, times, Guard::own_last_group);
  if (!a) {
    return (sentence << "gait " << name << ": its groups wait for each other in a ring").finish();
  }
  const double ring_s = gait.groups * (times.flight_s + times.double_stance_s);
  if (max_plus::cycle_mean(*a) > ring_s + kRounding) {
    return (sentence << "gait " << name << " does not synchronise: flight_s + stance_min_s = "
                     << times.flight_s + times.stance_min_s << " s exceeds "
                     << static_cast<double>(gait.groups)
                     << " (flight_s + double_stance_s) = " << ring_s << " s")
        .finish();
  }
  return nullptr;
}

// The longest order is a stance during which the gait changes from wave to tetrapod-B or back: of a
// leg that landed with the first group and lifts off with the last.
const char* check_stance(const GaitTimes& times) noexcept {
  constexpr double kLongestOrder_s = 65.5;
  constexpr int kGroups = kWave.groups + kTetrapodB.groups - 2;
  const double longest_s =
      kGroups * (times.flight_s + times.double_stance_s) + times.double_stance_s;
  if (longest_s <= kLongestOrder_s) return nullptr;
  return (sentence << "gait: a stance of " << longest_s
                   << " s, when the gait changes, is longer than a leg module can count, "
                   << kLongestOrder_s << " s")
      .finish();
}

const char* check_rates(const LocomotionParameters& p) noexcept {
  const double lowered = lowered_rad(p.belly_height_m, p.leg_diameter_m);
  struct Rate {
    const char* name;
    double travel_rad, duration_s;
  };
  // A leg that steps on the spot swings a full turn; any other swing is shorter.
  const Rate rates[] = {
      {"a full turn in flight_s", 2 * kPi, p.flight_s},
      {"the sweep in stance_min_s", p.sweep_rad, p.stance_min_s},
      {"standing up in stand_up_s", lowered, p.stand_up_s},
      {"lying down in lay_down_s", lowered, p.lay_down_s},
  };
  for (const Rate& rate : rates) {
    const double rate_rad_s = rate.travel_rad / rate.duration_s;
    if (rate_rad_s <= p.swing_limit_rad_s * (1 + kRounding)) continue;
    return (sentence << rate.name << " is " << rate_rad_s << " rad/s, the limit "
                     << p.swing_limit_rad_s << " rad/s")
        .finish();
  }
  return nullptr;
}

const char* check_geometry(const LocomotionParameters& p) noexcept {
  if (p.belly_height_m >= p.leg_diameter_m) {
    return (sentence << "belly_height_m = " << p.belly_height_m
                     << " is not below leg_diameter_m = " << p.leg_diameter_m)
        .finish();
  }
  const double extreme_rad = std::abs(p.offset_rad) + kFurthestReach * p.sweep_rad / 2;
  const double contact_rad = math::acos(p.belly_height_m / p.leg_diameter_m);
  if (extreme_rad >= contact_rad) {
    return (sentence << "offset_rad and sweep_rad take a leg to " << extreme_rad
                     << " rad, where the belly touches from " << contact_rad << " rad")
        .finish();
  }
  return nullptr;
}

// The smallest margin of a walk straight ahead (direction 1) or back (-1): of the feet on the
// ground when a group has lifted off and when it lands. Turns have larger ones.
double gait_margin_m(const Partition& gait, double direction,
                     const LocomotionParameters& p) noexcept {
  const double turn_s = p.flight_s + p.double_stance_s;  // from one group to the next
  const double stance_s = gait.groups * turn_s - p.flight_s;
  double smallest_m = std::numeric_limits<double>::infinity();
  for (int group = 0; group < gait.groups; ++group) {
    for (const double in_flight_s : {0.0, p.flight_s}) {
      PerLeg<bool> in_stance{};
      PerLeg<double> theta_rad{};
      for (std::size_t i = 0; i < kLegs; ++i) {
        const int turns = (group - gait.group_of[i] + gait.groups) % gait.groups;
        const double landed_s = turns * turn_s - p.flight_s + in_flight_s;  // so long ago
        in_stance[i] = turns != 0;
        theta_rad[i] = p.offset_rad + direction * p.sweep_rad / 2 * (1 - 2 * landed_s / stance_s);
      }
      smallest_m =
          std::min(smallest_m, static_margin_m(in_stance, theta_rad, p.leg_diameter_m, p.hips));
    }
  }
  return smallest_m;
}

const char* check_margin(const char* name, const Partition& gait,
                         const LocomotionParameters& p) noexcept {
  const double margin_m = std::min(gait_margin_m(gait, 1, p), gait_margin_m(gait, -1, p));
  if (margin_m >= kLeastMargin_m) return nullptr;
  return (sentence << "in gait " << name << " the centre of mass is " << margin_m * 1e3
                   << " mm inside the feet, at least " << kLeastMargin_m * 1e3
                   << " mm are needed: correct centre_of_mass_mm, hip_x_mm or hip_y_mm, or "
                      "sweep_deg, offset_deg")
      .finish();
}

}  // namespace

const char* check(const LocomotionParameters& p) noexcept {
  sentence.clear();
  if (const char* wrong = check_values(p)) return wrong;
  if (const char* wrong = check_geometry(p)) return wrong;
  const GaitTimes times{p.flight_s, p.stance_min_s, p.double_stance_s};
  if (const char* wrong = check_gait("tripod", kTripod, times)) return wrong;
  if (const char* wrong = check_gait("tetrapod-B", kTetrapodB, times)) return wrong;
  if (const char* wrong = check_gait("wave", kWave, times)) return wrong;
  if (const char* wrong = check_stance(times)) return wrong;
  if (const char* wrong = check_margin("tripod", kTripod, p)) return wrong;
  if (const char* wrong = check_margin("tetrapod-B", kTetrapodB, p)) return wrong;
  if (const char* wrong = check_margin("wave", kWave, p)) return wrong;
  return check_rates(p);
}

}  // namespace lss::gnc::zebro
