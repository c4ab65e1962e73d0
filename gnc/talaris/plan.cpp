#include "gnc/talaris/plan.h"

#include <algorithm>
#include <cmath>

namespace lss::gnc::talaris {
namespace {

constexpr double kLeastHeight_m = 0.1, kMostHeight_m = 10, kMostDistance_m = 100;
constexpr double kTouchAfter_s = 1;   // from the end of guidance to contact
constexpr double kSpinUp_s = 5;       // and kRunDown_s of fans that run beside the flight
constexpr double kLiftMargin = 1.25;  // distance of hover pulses from the valves' limits

double fan_force_N(const Parameters& p) noexcept {
  return p.fans.weight_share * p.body.mass_kg * kGravity_m_s2;
}

bool usable(const PlanRequest& r) noexcept {
  return std::isfinite(r.height_m + r.distance_m + r.turn_rad + r.time_s) && r.time_s >= 0 &&
         std::abs(r.turn_rad) <= 3.1416 && std::abs(r.distance_m) <= kMostDistance_m &&
         static_cast<std::uint8_t>(r.program) < kPrograms;
}

// Between standstills over `way_m`, peak acceleration 6 way / T^2.
double leg_s(double way_m, double peak_m_s2, double least_s) noexcept {
  return way_m > 0 ? std::max(std::sqrt(6 * way_m / peak_m_s2), least_s) : 0;
}

struct Judge {
  PlanResult& result;
  // the first failure is reported; measured must not exceed limit
  void most(Guard guard, double measured, double limit) const noexcept {
    if (result.guard == Guard::none && !(measured <= limit)) {
      result.guard = guard;
      result.measured = measured;
      result.limit = limit;
    }
  }
  void least(Guard guard, double measured, double limit) const noexcept {
    if (result.guard == Guard::none && !(measured >= limit)) {
      result.guard = guard;
      result.measured = measured;
      result.limit = limit;
    }
  }
};

}  // namespace

double hover_thrusters(const Parameters& p) noexcept {
  const double force = p.body.mass_kg * kGravity_m_s2 - fan_force_N(p);
  return (force + p.gas.attitude_N) / p.thrusters.force_N;
}

PlanResult make_plan(const PlanRequest& request, const Parameters& p, double gas_left_s) noexcept {
  PlanResult result;
  Plan& plan = result.plan;
  plan.request = request;
  const Judge judge{result};
  if (!usable(request)) {
    result.guard = Guard::request;
    return result;
  }
  const Program program = request.program;
  const bool hop = program == Program::hop,
             fans_only = program == Program::fan_altitude || program == Program::parachute;
  plan.flies = hop || program == Program::altitude || fans_only;
  plan.uses_fans = plan.flies;
  plan.uses_gas = !fans_only;
  const bool moves = hop || program == Program::traverse || program == Program::turn_traverse;
  plan.needs_altimeter = plan.flies || program == Program::traverse;
  const bool turns = hop || program == Program::turn || program == Program::turn_traverse;

  const double F = p.thrusters.force_N, m = p.body.mass_kg, frame = kFrame_s;
  const double weight = m * kGravity_m_s2;
  const double lateral_m_s2 = 2 * F * (p.thrusters.max_on_s / frame) / m;

  // times
  const double way = moves ? std::abs(request.distance_m) : 0;
  if (turns && request.turn_rad != 0) {
    plan.turn_s = std::abs(request.turn_rad) / p.profile.turn_rate_rad_s + p.profile.settle_s;
  }
  if (way > 0) {
    plan.traverse_s = request.time_s > 0
                          ? request.time_s
                          : leg_s(way, p.profile.lateral_duty * 2 * F / m, p.profile.min_leg_s);
  }
  if (plan.flies) {
    const double down = std::max(request.height_m - p.profile.touchdown_height_m, 0.0);
    if (fans_only) {
      const double rate = p.gains[0].height_rate_m_s;
      plan.climb_s = request.height_m / rate + 3;
      plan.descend_s = request.height_m / rate + 1;
    } else {
      plan.climb_s = leg_s(request.height_m, p.profile.climb_m_s2, p.profile.min_leg_s / 2);
      plan.descend_s =
          std::max(leg_s(down, p.profile.descend_m_s2, p.profile.min_leg_s / 2), frame);
    }
    plan.hover_s = p.profile.hover_s;
    plan.keep_s = hop ? p.profile.hover_s : request.time_s;  // after the traverse
    plan.fan_rpm = rpm_for(fan_force_N(p), p.fans);
  } else if (program == Program::attitude) {
    plan.keep_s = request.time_s > 0 ? request.time_s : p.profile.keep_s;
  } else if (moves) {
    plan.keep_s = p.profile.settle_s + 1;
  }
  plan.total_s = plan.climb_s + plan.hover_s + plan.turn_s + plan.traverse_s + plan.keep_s +
                 plan.descend_s + (plan.flies ? kTouchAfter_s : 0);

  // gas: for hovering, for the traverse, for turning
  const double peak_m_s2 = plan.traverse_s > 0 ? 6 * way / (plan.traverse_s * plan.traverse_s) : 0;
  if (plan.uses_gas) {
    double gas = 0;
    if (plan.flies) gas += hover_thrusters(p) * plan.total_s;
    if (program == Program::attitude) gas += 4 * p.profile.stand_on_s / frame * plan.keep_s;
    if (!plan.flies) gas += p.gas.attitude_N / F * plan.total_s;
    if (plan.traverse_s > 0) gas += 3 * m * way / (plan.traverse_s * F);
    if (plan.turn_s > 0) {
      gas += 2 * p.profile.turn_rate_rad_s * p.body.inertia_x_kg_m2 / (F * p.thrusters.side_y_m);
    }
    plan.gas_s = gas;
  }

  // guards
  if (plan.flies) {
    judge.least(Guard::height, request.height_m, kLeastHeight_m);
    judge.most(Guard::height, request.height_m, kMostHeight_m);
    judge.most(Guard::altimeter, request.height_m,
               p.limits.altimeter_share * p.limits.altimeter_max_m);
    const double most_N = kFans * p.fans.thrust_N_per_rpm2 * p.fans.max_rpm * p.fans.max_rpm;
    judge.most(Guard::fan_thrust, fans_only ? weight * 1.02 : fan_force_N(p), most_N);
    judge.most(Guard::run_time, plan.total_s + kSpinUp_s + p.limits.run_down_s, p.fans.max_run_s);
  }
  if (plan.flies && plan.uses_gas) {
    const double hover_on = frame * (weight - fan_force_N(p)) / (4 * F);
    judge.least(Guard::hover_on_time, hover_on, kLiftMargin * p.thrusters.min_on_s);
    judge.most(Guard::hover_on_time, hover_on, p.thrusters.max_on_s / kLiftMargin);
    const double up = (4 * F * p.thrusters.max_on_s / frame + fan_force_N(p) - weight) / m;
    judge.most(Guard::climb, 6 * request.height_m / (plan.climb_s * plan.climb_s), up);
  }
  if (moves) {
    judge.most(Guard::lateral, peak_m_s2, lateral_m_s2);
    if (!hop && std::isfinite(request.range_m) && program == Program::traverse) {
      judge.most(Guard::wall, request.distance_m, request.range_m - p.profile.clearance_m);
    }
  }
  if (plan.uses_gas) judge.most(Guard::gas, plan.gas_s, gas_left_s - p.gas.reserve_s);
  return result;
}

}  // namespace lss::gnc::talaris
