#include "tests/talaris/chain/flights.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "idl/angles.h"
#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

using sim::talaris::BodyState;
using sim::talaris::Stand;
using sim::talaris::TalarisOptions;
using sim::talaris::Vector3;

constexpr double kFlightLimit_s = 90;
constexpr double kLifted_m = 0.05;

double tilt_deg(const BodyState& body) {
  const double cosine = (body.attitude * Vector3::UnitX()).x();
  return std::acos(std::clamp(cosine, -1.0, 1.0)) / kDegree;
}

double roll_rad(const BodyState& body) {
  return 2 * std::atan2(body.attitude.x(), body.attitude.w());
}

double wrapped(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }

TalarisOptions on(Stand stand) {
  TalarisOptions world;
  world.plant.stand = stand;
  return world;
}

Chain::Options options_of(const char* config, TalarisOptions world, unsigned seed) {
  return {.config = config, .world = sim::talaris::dispersed(world, seed), .seed = seed};
}

// Executed, and over.
bool ended(Chain& chain, double limit_s) {
  return chain.run_until([&] { return chain.mode() != Mode::execute; }, limit_s);
}

// As planned: the daemon reports no fault.
bool as_planned(const Chain& chain) {
  const bool told = std::ranges::any_of(chain.acks, [](const Ack& ack) {
    return ack.phase == lss::Phase::failed || ack.phase == lss::Phase::rejected;
  });
  // An altimeter that lost the wall while the vehicle turned is only warned of.
  const bool fatal = std::ranges::any_of(chain.supervisor().faults, [](const FaultRecord& fault) {
    return fault.id != FaultId::none &&
           info(fault.id)->severity == static_cast<std::uint8_t>(Severity::fatal);
  });
  return chain.mode() == Mode::standby && !fatal && !told;
}

// Watches a free flight, every millisecond.
struct Watch {
  Chain& chain;
  Flown& flown;
  TimeNs lift_ns = 0, contact_ns = 0, noticed_ns = 0;
  double wanted_m = 0;

  void step() {
    const auto& plant = chain.world().plant();
    const BodyState& body = chain.body();
    if (!flown.lifted_off) {
      if (plant.contact() || plant.clearance_m() < kLifted_m) return;
      flown.lifted_off = true;
      lift_ns = chain.now();
    }
    flown.max_height_m = std::max(flown.max_height_m, body.position_m.x());
    if (noticed_ns == 0 && chain.phase() == Phase::touchdown) noticed_ns = chain.now();
    if (contact_ns == 0 && plant.contact()) {
      contact_ns = chain.now();
      flown.contact_tilt_deg = tilt_deg(body);
      const auto& nav = chain.telemetry().position_m;
      flown.nav_along_m = nav[2] - body.position_m.z();
      flown.nav_across_m = nav[1] - body.position_m.y();
      const auto& speed = chain.telemetry().velocity_m_s;
      flown.nav_side_m_s =
          std::hypot(speed[1] - body.velocity_m_s.y(), speed[2] - body.velocity_m_s.z());
      const gnc::talaris::NavState& state = chain.vehicle().nav();
      flown.sigma_m = state.position_sigma_m.tail<2>().norm() / std::numbers::sqrt2;
      flown.sigma_m_s = state.velocity_sigma_m_s.tail<2>().norm() / std::numbers::sqrt2;
    }
    if (contact_ns == 0) {
      flown.max_tilt_deg = std::max(flown.max_tilt_deg, tilt_deg(body));
      const Phase phase = chain.phase();
      if (phase == Phase::traverse || phase == Phase::brake)
        flown.height_error_m =
            std::max(flown.height_error_m, std::abs(body.position_m.x() - wanted_m));
      return;
    }
    flown.ground_tilt_deg = std::max(flown.ground_tilt_deg, tilt_deg(body));
    flown.down_m_s = std::max(flown.down_m_s, plant.touchdown().down_m_s);
    flown.sideways_m_s = std::max(flown.sideways_m_s, plant.touchdown().horizontal_m_s);
  }
};

template <class World, class Adjust>
FlightPlan with(FlightPlan plan, World&& change, Adjust&& adjust) {
  plan.world = [before = plan.world, change](TalarisOptions& world) {
    if (before) before(world);
    change(world);
  };
  plan.adjust = [before = plan.adjust, adjust](Parameters& parameters) {
    if (before) before(parameters);
    adjust(parameters);
  };
  return plan;
}

}  // namespace

double Flown::off_m() const { return std::hypot(along_m, across_m); }
double Flown::nav_off_m() const { return std::hypot(nav_along_m, nav_across_m); }

std::string Flown::text() const {
  std::string told;
  for (const FaultId id : faults) told += fmt::format(" {}", info(id)->name);
  return fmt::format(
      "seed {}: {}{}{} ({}) {:.1f} s, down {:.2f} m/s, sideways {:.2f} (reported {:.2f}, {:.2f}), "
      "tilt "
      "{:.1f} deg (rest "
      "{:.1f}, air "
      "{:.1f}), off {:.2f} along {:.2f} across, nav {:.2f} {:.2f} ({:.2f} m/s), height {:.2f} (off "
      "{:.2f}), gas "
      "{:.1f} s,{}",
      seed, accepted ? "" : "not accepted ", came_down ? "" : "never down ",
      succeeded ? "as planned," : "", why == Reason::none ? "-" : info(why)->name, run_s, down_m_s,
      sideways_m_s, told_down_m_s, told_sideways_m_s, contact_tilt_deg, rest_tilt_deg, max_tilt_deg,
      along_m, across_m, nav_along_m, nav_across_m, nav_side_m_s, max_height_m, height_error_m,
      gas_s, told);
}

FlightPlan with_camera(FlightPlan plan) {
  return with(
      std::move(plan), [](TalarisOptions& world) { world.camera.present = true; },
      [](Parameters& p) { p.buses.has_camera = p.navigation.camera = true; });
}

FlightPlan with_standby_imu(FlightPlan plan) {
  return with(
      std::move(plan), [](TalarisOptions& world) { world.standby_imu = true; },
      [](Parameters& p) { p.buses.has_standby = true; });
}

FlightPlan with_corner_altimeters(FlightPlan plan) {
  return with(
      std::move(plan), [](TalarisOptions& world) { world.corner_altimeters = true; },
      [](Parameters& p) { p.buses.has_corners = p.navigation.corners = true; });
}

Flown fly(const FlightPlan& plan, unsigned seed) {
  Flown flown;
  flown.seed = seed;
  TalarisOptions world;
  if (plan.world) plan.world(world);
  if (plan.dispersed) world = sim::talaris::dispersed(world, seed, plan.spread);
  flown.slope_deg = world.plant.slope_rad / kDegree;
  Chain chain({.config = plan.config,
               .world = world,
               .seed = seed,
               .late_share = plan.late_share,
               .late_s = plan.late_s,
               .adjust = plan.adjust});
  if (!chain.prepare()) return flown;
  const double gas_before_s = chain.world().gas().used_s();
  flown.accepted = chain.fly(plan.program, plan.request);
  if (!flown.accepted) return flown;

  Watch watch{.chain = chain, .flown = flown, .wanted_m = plan.request.height_m};
  bool struck = plan.faults.empty();
  chain.after_step = [&] {
    watch.step();
    if (struck || !plan.strike_step || !flown.lifted_off || !plan.strike_step(chain)) return;
    struck = true;
    for (const std::string& fault : plan.faults) chain.inject(fault);
  };
  const auto over = [&] {
    if (plan.each_frame) plan.each_frame(chain);
    if (!struck && !plan.strike_step && flown.lifted_off &&
        (plan.strike ? plan.strike(chain)
                     : static_cast<double>(chain.now() - watch.lift_ns) * 1e-9 >= plan.fault_s)) {
      struck = true;
      for (const std::string& fault : plan.faults) chain.inject(fault);
    }
    return chain.rests();
  };
  const double begun_s = chain.seconds();
  flown.came_down = chain.run_until(over, kFlightLimit_s);
  flown.run_s = chain.seconds() - begun_s;
  flown.succeeded = flown.came_down && flown.lifted_off && as_planned(chain);
  chain.run(1);
  chain.after_step = {};

  const BodyState& body = chain.body();
  const bool moves = plan.program == Program::hop;
  const double way = moves ? plan.request.distance_m : 0;
  const Vector3 target(0, -way * std::sin(plan.request.turn_rad),
                       way * std::cos(plan.request.turn_rad));
  flown.rest_tilt_deg = tilt_deg(body);
  flown.along_m = body.position_m.z() - target.z();
  flown.across_m = body.position_m.y() - target.y();
  flown.gas_s = chain.world().gas().used_s() - gas_before_s;
  for (const Ack& ack : chain.acks)
    if (ack.phase == lss::Phase::failed) flown.why = ack.verdict.reason;
  for (const EventRecord& event : chain.events) {
    if (event.id != static_cast<std::uint16_t>(events::flight_judged)) continue;
    flown.told_down_m_s = event.argument[2];
    flown.told_sideways_m_s = event.argument[3];
  }
  if (watch.contact_ns != 0)
    flown.air_s = static_cast<double>(watch.contact_ns - watch.lift_ns) * 1e-9;
  if (watch.contact_ns != 0 && watch.noticed_ns != 0)
    flown.noticed_s = static_cast<double>(watch.noticed_ns - watch.contact_ns) * 1e-9;
  for (std::size_t foot = 0; foot < sim::talaris::Plant::kFeet; ++foot)
    flown.sinkage_m = std::max(flown.sinkage_m, chain.world().plant().sinkage_m(foot));
  for (const FaultRecord& fault : chain.supervisor().faults) {
    if (fault.id != FaultId::none) flown.faults.push_back(fault.id);
  }
  return flown;
}

// ---- sled and rails

namespace {

Slid slide(const char* config, const TalarisOptions& world, unsigned seed, Program program,
           const Chain::HopRequest& request, double heading_rad) {
  Slid slid;
  Chain chain(options_of(config, world, seed));
  if (!chain.prepare(false)) return slid;
  const BodyState before = chain.body();
  const double gas_s = chain.world().gas().used_s();
  const double began_s = chain.seconds();
  if (!chain.fly(program, request) || !ended(chain, 60)) return slid;
  slid.succeeded = as_planned(chain);
  slid.time_s = chain.seconds() - began_s;
  slid.gas_s = chain.world().gas().used_s() - gas_s;
  const BodyState& body = chain.body();
  slid.turn_deg = wrapped(roll_rad(body) - heading_rad - request.turn_rad) / kDegree;
  slid.along_m = body.position_m.z() - before.position_m.z() - request.distance_m;
  return slid;
}

}  // namespace

Slid turn_on_sled(double degrees, unsigned seed) {
  TalarisOptions world = on(Stand::sled);
  const double heading = sim::talaris::dispersed(world, seed).plant.heading_rad;
  return slide("sled", world, seed, Program::turn,
               {.height_m = 0, .distance_m = 0, .turn_rad = degrees * kDegree}, heading);
}

Slid turn_and_traverse(unsigned seed) {
  TalarisOptions world = on(Stand::sled);
  world.plant.heading_rad = -45 * kDegree;
  return slide("sled-traverse", world, seed, Program::turn_traverse,
               {.height_m = 0, .distance_m = 0.8, .turn_rad = 45 * kDegree}, -45 * kDegree);
}

Slid traverse_on_rails(double distance_m, unsigned seed) {
  TalarisOptions world = on(Stand::rail);
  return slide("traverse", world, seed, Program::traverse,
               {.height_m = 0, .distance_m = distance_m}, 0);
}

// ---- pivot and lift

Held hold_attitude(double weight_kg, unsigned seed) {
  Held held;
  TalarisOptions world = on(Stand::pivot);
  world.plant.axis = sim::talaris::Axis::yaw;
  world.plant.weight_kg = weight_kg;
  Chain chain(options_of("attitude", world, seed));
  if (!chain.prepare(false)) return held;
  const double gas_s = chain.world().gas().used_s();
  if (!chain.fly(Program::attitude, {.height_m = 0, .distance_m = 0, .time_s = 20})) return held;
  held.begin_deg = tilt_deg(chain.body());
  const TimeNs settled_ns = chain.now() + 6 * kSecond;
  chain.after_step = [&] {
    if (chain.now() >= settled_ns && chain.mode() == Mode::execute && chain.phase() == Phase::keep)
      held.settled_deg = std::max(held.settled_deg, tilt_deg(chain.body()));
  };
  held.succeeded = ended(chain, 60) && as_planned(chain);
  held.gas_s = chain.world().gas().used_s() - gas_s;
  return held;
}

Lifted lift_and_hold(unsigned seed) {
  constexpr double kNoCounterweight_kg = 0.5;  // the fans carry instead (5.2.9, at its end)
  Lifted lifted;
  TalarisOptions world = on(Stand::lift);
  world.plant.axis = sim::talaris::Axis::yaw;
  world.plant.counterweight_kg = kNoCounterweight_kg;
  Chain chain(options_of("altitude-attitude", world, seed));
  if (!chain.prepare()) return lifted;
  const double gas_s = chain.world().gas().used_s();
  if (!chain.fly(Program::altitude, {.height_m = 1, .distance_m = 0, .time_s = 3})) return lifted;
  chain.after_step = [&] {
    const BodyState& body = chain.body();
    lifted.top_m = std::max(lifted.top_m, body.position_m.x());
    if (!chain.world().plant().contact())
      lifted.tilt_deg = std::max(lifted.tilt_deg, tilt_deg(body));
  };
  lifted.succeeded = ended(chain, 60) && as_planned(chain);
  lifted.down_m_s = chain.world().plant().touchdown().down_m_s;
  lifted.gas_s = chain.world().gas().used_s() - gas_s;
  return lifted;
}

// ---- fans

std::array<Hopped, 3> hop_by_fans(double height_m, unsigned seed) {
  std::array<Hopped, 3> all;
  TalarisOptions world = on(Stand::fans);
  Chain chain(options_of("fan-altitude", world, seed));
  if (!chain.start() || !chain.arm()) return all;
  for (std::size_t set = 0; set < all.size(); ++set) {
    Hopped& hopped = all[set];
    if (!chain.calibrate()) return all;
    chain.send(CommandKind::gains, {static_cast<double>(set + 1)});
    if (!chain.fly(Program::fan_altitude, {.height_m = height_m, .distance_m = 0, .time_s = 4}))
      return all;
    TimeNs up_ns = 0, there_ns = 0;
    chain.after_step = [&] {
      const double height = chain.body().position_m.x();
      hopped.top_m = std::max(hopped.top_m, height);
      if (up_ns == 0 && height > 0.02) up_ns = chain.now();
      if (there_ns == 0 && height > 0.9 * height_m) there_ns = chain.now();
    };
    const bool over = ended(chain, 90);
    chain.after_step = {};
    hopped.succeeded = over && as_planned(chain);
    hopped.overshoot_m = hopped.top_m - height_m;
    hopped.rise_s = there_ns != 0 ? static_cast<double>(there_ns - up_ns) * 1e-9 : 0;
    hopped.down_m_s = chain.world().plant().touchdown().down_m_s;
    if (!over) return all;
  }
  return all;
}

Spun spin(unsigned fans, double rpm, unsigned seed) {
  constexpr double kRamp_rpm_s = 4000, kSteady_s = 10;
  Spun spun;
  TalarisOptions world = on(Stand::load);
  world.load_cell = false;
  Chain chain(options_of("fans", world, seed));
  if (!chain.start() || !chain.arm()) return spun;
  spun.armed = true;
  chain.run(0.5);
  chain.send(CommandKind::edf_rpm, {static_cast<double>(fans), rpm, kRamp_rpm_s});
  if (!chain.run_until([&] { return chain.telemetry().fans[0].throttle > 0; }, 1)) return spun;
  const TimeNs begin_ns = chain.frame_ns();
  const double ramp_s = rpm / kRamp_rpm_s;
  std::array<double, kHopperFans> sum{};
  int count = 0;
  chain.after_frame = [&] {
    const double t = static_cast<double>(chain.frame_ns() - begin_ns) * 1e-9;
    const bool steady = t > ramp_s + 2;
    for (std::size_t i = 0; i < kHopperFans; ++i) {
      if ((fans >> i & 1) == 0) continue;
      const double measured = chain.telemetry().fans[i].rpm;
      if (t > 1 && t < ramp_s)
        spun.ramp_rpm = std::max(spun.ramp_rpm, std::abs(measured - kRamp_rpm_s * t));
      if (!steady) continue;
      spun.steady_rpm = std::max(spun.steady_rpm, std::abs(measured - rpm));
      sum[i] += measured - rpm;
    }
    count += steady ? 1 : 0;
  };
  chain.run(ramp_s + 2 + kSteady_s);
  chain.after_frame = {};
  for (const double each : sum)
    spun.mean_rpm = std::max(spun.mean_rpm, std::abs(each / std::max(count, 1)));
  return spun;
}

// ---- valves

Fired fire(unsigned valve, double on_s, unsigned seed) {
  constexpr int kPulses = 10;
  Fired fired;
  TalarisOptions world = on(Stand::load);
  world.gas.thrust_N = 40;
  Chain chain(options_of("valves", world, seed));
  if (!chain.start()) return fired;
  chain.run(1);
  const std::size_t i = valve - 1;
  const double set = 1u << i;
  const bool lifts = valve % 2 == 1;
  const std::size_t axis = lifts ? 0 : 2;
  const double zero_N = chain.telemetry().load_N[axis];
  const auto force = [&](const std::array<double, 3>& load_N) {
    return std::abs(load_N[axis] - zero_N);
  };

  // Valve kept open: the force, with and without the ringing of the stand.
  gnc::talaris::Filter clean(
      gnc::talaris::notch(chain.parameters().notch_Hz, 500, chain.parameters().notch_quality));
  double least = 1e9, most = -1e9, clean_least = 1e9, clean_most = -1e9, sum_N = 0;
  int readings = 0;
  TimeNs from_ns = 0;
  chain.after_frame = [&] {
    for (const TalarisSample& sample : chain.samples()) {
      const auto* load = std::get_if<Load>(&sample.reading);
      if (load == nullptr) continue;
      const double raw_N = force(load->force_N), clean_N = clean.step(raw_N);
      if (from_ns == 0 || sample.time_ns < from_ns) continue;
      least = std::min(least, raw_N), most = std::max(most, raw_N);
      sum_N += clean_N, ++readings;
      clean_least = std::min(clean_least, clean_N), clean_most = std::max(clean_most, clean_N);
    }
  };
  chain.send(CommandKind::valve, {set, 1, 1.4});
  if (!chain.run_until([&] { return chain.telemetry().valves[i].open; }, 1)) return fired;
  from_ns = chain.now() + 200 * kMillisecond;
  chain.run(0.95);
  fired.true_N = chain.world().gas().thrust_N(i);
  fired.force_N = sum_N / std::max(readings, 1);
  fired.raw_N = most - least;
  fired.clean_N = clean_most - clean_least;
  chain.after_frame = {};
  chain.run(1);

  // Ten pulses: the daemon's report, and the true gas flow.
  double impulse_Ns = 0;
  TimeNs full_ns = 0, none_ns = 0, opened_ns = 0, shut_ns = 0;
  double opening_ms = 0, shutting_ms = 0;
  int openings = 0, shuttings = 0;
  chain.after_step = [&] {
    const double now_N = chain.world().gas().thrust_N(i);
    impulse_Ns += now_N * sim::talaris::kStep_s;
    const EdgeReport& edges = chain.edges_now();
    if (edges.opened_ns[i] != opened_ns) opened_ns = edges.opened_ns[i], full_ns = 0;
    if (edges.shut_ns[i] != shut_ns) shut_ns = edges.shut_ns[i], none_ns = 0;
    if (full_ns == 0 && opened_ns > shut_ns && now_N > 0.99 * fired.true_N) {
      full_ns = chain.now();
      opening_ms += static_cast<double>(full_ns - opened_ns) * 1e-6;
      ++openings;
    }
    if (none_ns == 0 && shut_ns > opened_ns && now_N < 0.01 * fired.true_N) {
      none_ns = chain.now();
      shutting_ms += static_cast<double>(none_ns - shut_ns) * 1e-6;
      ++shuttings;
    }
  };
  opened_ns = chain.edges_now().opened_ns[i], shut_ns = chain.edges_now().shut_ns[i];
  full_ns = none_ns = 1;
  chain.send(CommandKind::duty_cycle);
  if (!chain.run_until(Mode::duty_cycle, 1)) return fired;
  const double before_s = chain.telemetry().valves[i].fired_s;
  const std::uint64_t pulses = chain.telemetry().valves[i].pulses;
  chain.send(CommandKind::pulse, {set, on_s, 0.02, kPulses});
  chain.run(kPulses * 0.2 + 1);
  const lss_TalarisValve& told = chain.telemetry().valves[i];
  if (told.pulses != pulses + kPulses || openings == 0 || shuttings == 0) return fired;
  fired.on_ms = (told.fired_s - before_s) / kPulses * 1e3;
  fired.gas_ms = impulse_Ns / fired.true_N / kPulses * 1e3;
  fired.open_ms = opening_ms / openings;
  fired.shut_ms = shutting_ms / shuttings;
  return fired;
}

}  // namespace lss::talaris
