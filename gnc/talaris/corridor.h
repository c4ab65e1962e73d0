#pragma once

// The corridor around a hop: where it should be, how fast and how level at each moment of its plan,
// and how far off it may be. Judged with navigation's own uncertainty: what cannot be excluded
// counts (2 sigma, up to half the limit). Pure; one call a frame.

#include "gnc/talaris/parameters.h"
#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

// What left the corridor, and the unit of Judgement's numbers.
enum class Off : std::uint8_t {
  none,
  side,    // m, horizontal distance from the planned place
  height,  // m, from the planned height
  speed,   // m/s, horizontal, from the planned one
  tilt,    // rad
  late,    // s behind the plan
  wind,    // m/s2 of a steady push; what jets and tilt can stand
};

struct Judgement {
  Off off = Off::none;  // the worst, relative to its limit
  double measured = 0, limit = 0;
  bool wavers = false;  // inside, but so far off that it should wait and come back
  bool back = false;    // near the plan, and slow
};

class Corridor {
 public:
  Corridor() = default;
  // A leg from standstill at `from` to standstill at `to`, with least effort (as the planner).
  void begin(const Vector3& from_N_m, const Vector3& to_N_m, double seconds) noexcept;
  // It slows down evenly from there, with that speed, and stays.
  void stop(const Vector3& at_N_m, const Vector3& speed_N_m_s, double seconds) noexcept;
  void step() noexcept;  // a frame passed
  Vector3 place_N_m() const noexcept;
  Vector3 speed_N_m_s() const noexcept;

  // `flown_s`, `planned_s`: since lift-off; of the whole plan. `wind_m_s2`: estimated.
  Judgement judge(const NavState& state, double tilt_rad, double flown_s, double planned_s,
                  double wind_m_s2, const Limits& limits) const noexcept;

 private:
  Vector3 from_ = Vector3::Zero(), to_ = Vector3::Zero();
  double length_s_ = 1, passed_s_ = 0;
  bool stops_ = false;
  Vector3 speed_ = Vector3::Zero();  // when it began to stop
};

}  // namespace lss::gnc::talaris
