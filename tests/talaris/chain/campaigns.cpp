#include "tests/talaris/chain/campaigns.h"

#include <fmt/format.h>

#include <cstdio>
#include <map>

#include "tests/talaris/chain/failed_actuators.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

std::string row(const char* what, const Figures& f, int digits = 2) {
  return fmt::format("| {} | {:.{}f} | {:.{}f} | {:.{}f} |\n", what, f.share(0.5), digits,
                     f.share(0.95), digits, f.most(), digits);
}

void say(const std::string& line) {
  std::fputs((line + "\n").c_str(), stdout);
  std::fflush(stdout);
}

std::string told(const std::vector<Flown>& all) {
  std::map<std::string, unsigned> times;
  for (const Flown& flown : all) {
    for (const FaultId id : flown.faults) ++times[info(id)->name];
  }
  std::string text;
  for (const auto& [name, n] : times)
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", name, n);
  return text.empty() ? "nothing" : text;
}

std::string outcome(unsigned good, unsigned of) { return fmt::format("{} of {}", good, of); }

}  // namespace

bool good(const Flown& flown) { return flown.succeeded && flown.upright(); }

// ---- the hop

const std::vector<HopFigure> kHopFigures = {
    {"landing speed, down, m/s", 2, [](const Flown& f) { return f.down_m_s; }},
    {"landing speed, sideways, m/s", 2, [](const Flown& f) { return f.sideways_m_s; }},
    {"tilt at touchdown, deg", 1, [](const Flown& f) { return f.contact_tilt_deg; }},
    {"tilt in the air, deg", 1, [](const Flown& f) { return f.max_tilt_deg; }},
    {"height off 2 m, level part, m", 2, [](const Flown& f) { return f.height_error_m; }},
    {"place, from the target, m", 1, [](const Flown& f) { return f.off_m(); }},
    {"- along the way, m", 1, [](const Flown& f) { return std::abs(f.along_m); }},
    {"- across, m", 1, [](const Flown& f) { return std::abs(f.across_m); }},
    {"- of that navigation's own error, m", 1, [](const Flown& f) { return f.nav_off_m(); }},
    {"gas, thruster-seconds of 44", 1, [](const Flown& f) { return f.gas_s; }},
    {"in the air, s", 1, [](const Flown& f) { return f.air_s; }},
};

std::string hop_section(unsigned seeds) {
  const auto all = runs(seeds, [](unsigned seed) {
    const Flown flown = fly({}, seed);
    if (!good(flown)) say(flown.text());
    return flown;
  });
  std::vector<Flown> well, bad;
  for (const Flown& flown : all) (good(flown) ? well : bad).push_back(flown);
  std::string text = fmt::format(
      "Up 2 m, 30 m level, down (`config/talaris/hop.toml`). Arrived as planned, upright and "
      "without fault: **{}**. The thesis\nreports no such flight.\n\n",
      outcome(static_cast<unsigned>(well.size()), seeds));
  text +=
      "Of those that arrived, by the simulator's truth:\n\n"
      "| | median | 95 % | most |\n|---|---|---|---|\n";
  const auto of = [&](auto get) { return figures(well, get); };
  for (const HopFigure& figure : kHopFigures)
    text += row(figure.name, of(figure.get), figure.digits);
  const Figures along = of([](const Flown& f) { return f.along_m; });
  const Figures across = of([](const Flown& f) { return f.across_m; });
  text += fmt::format("\nMean place: {:+.2f} m along, {:+.2f} m across.\n", along.mean(),
                      across.mean());
  if (bad.empty()) return text;
  text += "\nThose that did not:\n\n";
  for (const Flown& flown : bad) text += "- " + flown.text() + "\n";
  return text;
}

// ---- stands

std::string stands_section(unsigned seeds, unsigned sled_seeds) {
  std::string text =
      "*a, b*: in the median, and at most.\n\n"
      "| campaign | thesis | here | figures |\n"
      "|---|---|---|---|\n";
  const auto add = [&](const std::string& campaign, const char* thesis, const std::string& here,
                       const std::string& figures) {
    const std::string line =
        fmt::format("| {} | {} | {} | {} |\n", campaign, thesis, here, figures);
    std::fputs(line.c_str(), stdout);
    std::fflush(stdout);
    text += line;
  };

  for (const auto& [name, set] : {std::pair("one fan", 0b0001u), {"four fans", 0b1111u}}) {
    const auto all = runs(seeds, [set](unsigned seed) { return spin(set, 20'000, seed); });
    const auto right = [](const Spun& s) { return s.armed && s.mean_rpm <= 100; };
    add(fmt::format("{}, speed by PI (`fans`)", name), "follows the ramp, 200 rpm dead band",
        outcome(count(all, right), seeds),
        fmt::format("to 20,000 rpm at 4,000 rpm/s: off the ramp by {:.0f} rpm at most; steady: "
                    "mean by {:.0f}, readings by {:.0f}",
                    figures(all, [](const Spun& s) { return s.ramp_rpm; }).most(),
                    figures(all, [](const Spun& s) { return s.mean_rpm; }).most(),
                    figures(all, [](const Spun& s) { return s.steady_rpm; }).most()));
  }

  const auto hopped = runs(seeds, [](unsigned seed) { return hop_by_fans(0.3, seed); });
  for (std::size_t set = 0; set < 3; ++set) {
    const char* names[] = {"gentle", "standard", "aggressive"};
    const auto of = [&](auto get) {
      return figures(hopped, [&](const auto& each) { return get(each[set]); });
    };
    add(fmt::format("height by fans, 30 cm, gains \"{}\" (`fan-altitude`)", names[set]),
        "several sets",
        outcome(count(hopped, [&](const auto& each) { return each[set].reached(); }), seeds),
        fmt::format("up in {:.1f} s (median); at most {:.2f} m too high, down with {:.2f} m/s",
                    of([](const Hopped& h) { return h.rise_s; }).share(0.5),
                    of([](const Hopped& h) { return h.overshoot_m; }).most(),
                    of([](const Hopped& h) { return h.down_m_s; }).most()));
  }

  const auto fired = runs(8, [](unsigned valve) { return fire(valve, 0.08, valve); });
  const auto pulses = [](const Fired& f) {
    return std::abs(f.on_ms - 80) < 0.5 && std::abs(f.force_N - f.true_N) < 0.02 * f.true_N;
  };
  add("valves on the load cell (`valves`)", "about 40 N; clean behind a notch of 7 Hz",
      outcome(count(fired, pulses), 8),
      fmt::format("{:.1f} N of {:.1f} N; rings by {:.1f} N, behind the notch {:.1f} N; of 80 ms "
                  "{:.1f} ms by the edges, {:.1f} ms of thrust; opens {:.0f} ms late, shuts {:.0f} "
                  "ms",
                  figures(fired, [](const Fired& f) { return f.force_N; }).mean(),
                  figures(fired, [](const Fired& f) { return f.true_N; }).mean(),
                  figures(fired, [](const Fired& f) { return f.raw_N; }).share(0.5),
                  figures(fired, [](const Fired& f) { return f.clean_N; }).share(0.5),
                  figures(fired, [](const Fired& f) { return f.on_ms; }).mean(),
                  figures(fired, [](const Fired& f) { return f.gas_ms; }).mean(),
                  figures(fired, [](const Fired& f) { return f.open_ms; }).mean(),
                  figures(fired, [](const Fired& f) { return f.shut_ms; }).mean()));

  const auto most = [](const std::vector<Series>& all, double Series::*get) {
    return figures(all, [get](const Series& s) { return s.*get; }).most();
  };
  const auto measured = [&](const std::vector<Series>& all) {
    return outcome(count(all, [](const Series& s) { return s.measured(); }), seeds);
  };
  const auto swept = runs(seeds, [](unsigned n) { return play("throttle.script", n); });
  for (const auto& [name, fans] : {std::pair("one fan", 0b0001u), {"four fans", 0b1111u}}) {
    std::string curve;
    for (const double throttle : {0.25, 0.5, 0.75, 1.0}) {
      const auto mean = [&](auto get) {
        return figures(swept, [&](const Series& s) { return get(at(s, fans, throttle)); }).mean();
      };
      curve += fmt::format("{:.0f} %: {:.0f} rpm, {:.1f} N; ", throttle * 100,
                           mean([](const Plateau& a) { return a.rpm; }),
                           mean([](const Plateau& a) { return a.force_N(); }));
    }
    add(fmt::format("{} by throttle (`throttle.script`)", name), "not linear", measured(swept),
        fmt::format("{}off by {:.0f} rpm, {:.2f} N at most", curve, most(swept, &Series::off_rpm),
                    most(swept, &Series::off_N)));
  }
  const auto together = runs(seeds, [](unsigned n) { return play("valves.script", n); });
  const auto share = [&](int valves) {
    return 100 * figures(together, [&](const Series& s) { return of_alone(s, valves); }).mean();
  };
  add("valves alone, in pairs, all four for lift (`valves.script`)",
      "firings together change the thrust; zero from a minute at standstill", measured(together),
      fmt::format(
          "a pair gives {:.1f} % of both alone, four {:.1f} % (each further one takes {:.0f} "
          "% of the pressure); at most off by {:.2f} N, {:.2f} N m; the zero, taken before "
          "each, moves by {:.2f} N in 70 s",
          share(2), share(4), 100 * kDroop, most(together, &Series::off_N),
          most(together, &Series::off_Nm), most(together, &Series::moved_N)));

  const auto slid_text = [](const std::vector<Slid>& all, bool turns, bool moves) {
    std::string figures_text;
    if (turns) {
      const auto off_deg = figures(all, [](const Slid& s) { return std::abs(s.turn_deg); });
      figures_text += fmt::format("heading off by {:.1f} deg, {:.1f} (mean {:+.1f}); ",
                                  off_deg.share(0.5), off_deg.most(),
                                  figures(all, [](const Slid& s) { return s.turn_deg; }).mean());
    }
    if (moves) {
      const auto off_m = figures(all, [](const Slid& s) { return std::abs(s.along_m); });
      figures_text +=
          fmt::format("place off by {:.2f} m, {:.2f}; ", off_m.share(0.5), off_m.most());
    }
    return figures_text + fmt::format("{:.1f} s, {:.1f} thruster-seconds (means)",
                                      figures(all, [](const Slid& s) { return s.time_s; }).mean(),
                                      figures(all, [](const Slid& s) { return s.gas_s; }).mean());
  };
  const auto rails = runs(seeds, [](unsigned seed) { return traverse_on_rails(2, seed); });
  add("traverse on rails, 2 m (`traverse`)", "reaches the target",
      outcome(count(rails, reached_place), seeds), slid_text(rails, false, true));
  const auto turns = runs(sled_seeds, [](unsigned seed) { return turn_on_sled(90, seed); });
  add("sled, 90 deg (`sled`)", "4 of 4", outcome(count(turns, reached_heading), sled_seeds),
      slid_text(turns, true, false));
  const auto both = runs(sled_seeds, [](unsigned seed) { return turn_and_traverse(seed); });
  add("sled, 45 deg to the wall and 0.8 m (`sled-traverse`)", "4 of 4",
      outcome(count(both, reached_place), sled_seeds), slid_text(both, true, true));

  for (const auto& [name, weight_kg, most_deg, thesis] :
       {std::tuple("balanced", 0.0, 2.0, "within 2 deg"),
        std::tuple("0.3 kg at one end", 0.3, 3.0, "within 3 deg")}) {
    const auto held =
        runs(seeds, [weight = weight_kg](unsigned seed) { return hold_attitude(weight, seed); });
    const auto right = [most = most_deg](const Held& h) {
      return h.succeeded && h.settled_deg <= most;
    };
    const auto settled = figures(held, [](const Held& h) { return h.settled_deg; });
    add(fmt::format("attitude on the pivot, {} (`attitude`)", name), thesis,
        outcome(count(held, right), seeds),
        fmt::format("from {:.0f} deg; within {:.1f} deg, {:.1f} after 6 s; {:.1f} thruster-seconds "
                    "(mean) in 20 s",
                    figures(held, [](const Held& h) { return h.begin_deg; }).share(0.5),
                    settled.share(0.5), settled.most(),
                    figures(held, [](const Held& h) { return h.gas_s; }).mean()));
  }

  const auto lifted = runs(seeds, [](unsigned seed) { return lift_and_hold(seed); });
  add("height and attitude on the lift, 1 m (`altitude-attitude`)", "stable",
      outcome(count(lifted, [](const Lifted& l) { return l.succeeded && l.tilt_deg < 5; }), seeds),
      fmt::format(
          "{:.2f} to {:.2f} m high; at most tilt {:.1f} deg (median {:.1f}), down {:.2f} m/s",
          figures(lifted, [](const Lifted& l) { return l.top_m; }).share(0),
          figures(lifted, [](const Lifted& l) { return l.top_m; }).most(),
          figures(lifted, [](const Lifted& l) { return l.tilt_deg; }).most(),
          figures(lifted, [](const Lifted& l) { return l.tilt_deg; }).share(0.5),
          figures(lifted, [](const Lifted& l) { return l.down_m_s; }).most()));

  const auto chutes = runs(seeds, [](unsigned seed) { return fly(parachute_flight(), seed); });
  const auto of = [&](auto get) { return figures(chutes, get); };
  add("fans as parachute, free, up to 2 m and down (`parachute`)", "an idea",
      outcome(count(chutes, good), seeds),
      fmt::format(
          "down with {:.2f} m/s, {:.2f}; at most sideways {:.2f}, tilt {:.1f} deg in the air, "
          "{:.1f} at touchdown",
          of([](const Flown& f) { return f.down_m_s; }).share(0.5),
          of([](const Flown& f) { return f.down_m_s; }).most(),
          of([](const Flown& f) { return f.sideways_m_s; }).most(),
          of([](const Flown& f) { return f.max_tilt_deg; }).most(),
          of([](const Flown& f) { return f.contact_tilt_deg; }).most()));
  return text;
}

bool reached_place(const Slid& slid) { return slid.succeeded && std::abs(slid.along_m) < 0.15; }
bool reached_heading(const Slid& slid) { return slid.succeeded && std::abs(slid.turn_deg) < 5; }

FlightPlan parachute_flight() {
  return {.config = "parachute",
          .program = Program::parachute,
          .request = {.height_m = 2, .distance_m = 0}};
}

// ---- failures

const std::vector<Failure>& failures() {
  static const std::vector<Failure> all = {
      {"valve node silent", {"node-silent:0x20"}, "down by the fans"},
      {"fan node silent: the fans stop", {"node-silent:0x21"}, "gas takes what it can"},
      {"gas leak, 1 thruster-second a second", {"gas-leak:1"}, "down in time"},
      {"less gas than planned: 12 s from then on", {"gas:12"}, "down in time"},
      {"pressure regulator at 20 %", {"pressure-drop:0.2"}, "down by the fans"},
      {"wind of 10 N", {"push:10:60"}, "as planned"},
  };
  return all;
}

const std::vector<Failure>& sensor_failures() {
  static const std::vector<Failure> all = {
      {"IMU silent", {"imu-silent"}, "level by the fans", nullptr, true},
      {"IMU stuck", {"imu-stuck"}, "level by the fans", nullptr, true},
      {"IMU silent, with a second one", {"imu-silent"}, "as planned", with_standby_imu},
      {"IMU silent, with a second one and a camera",
       {"imu-silent"},
       "as planned",
       [](FlightPlan plan) { return with_camera(with_standby_imu(std::move(plan))); }},
      {"altimeter silent", {"altimeter-silent"}, "down by dead reckoning"},
      {"altimeter stuck", {"altimeter-stuck"}, "down by dead reckoning"},
      {"altimeter silent, with four at the corners",
       {"altimeter-silent"},
       "as planned",
       with_corner_altimeters},
  };
  return all;
}

Flown fail_in(Phase phase, const Failure& failure, unsigned seed) {
  FlightPlan plan = struck_in(phase, seed, {.faults = failure.faults});
  return fly(failure.with != nullptr ? failure.with(std::move(plan)) : plan, seed);
}

Flown fail(const Failure& failure, unsigned seed, unsigned seeds) {
  constexpr double kFrom_s = 1, kTo_s = 17;
  FlightPlan plan{.faults = failure.faults};
  plan.fault_s = kFrom_s + (kTo_s - kFrom_s) * (seed - 1) / std::max(seeds - 1, 1u);
  return fly(failure.with != nullptr ? failure.with(plan) : plan, seed);
}

namespace {

constexpr const char* kFailureHead =
    "| failure | should | survived | upright | as planned | down, m/s | sideways, m/s "
    "| tilt, deg | reported |\n|---|---|---|---|---|---|---|---|---|\n";

// A row, printed as it is flown.
std::string failure_row(std::string_view name, std::string_view should,
                        const std::vector<Flown>& all, const std::string& reported) {
  const auto of = [&](auto get) { return figures(all, get); };
  const Figures down = of([](const Flown& f) { return f.down_m_s; });
  const Figures sideways = of([](const Flown& f) { return f.sideways_m_s; });
  const unsigned wrongly = count(all, wrong);
  const std::string line = fmt::format(
      "| {} | {} | {} of {} | {} | {}{} | {:.2f}, {:.2f} | {:.2f}, {:.2f} | {:.1f} | {} |", name,
      should, count(all, survived), all.size(),
      count(all, [](const Flown& f) { return f.upright(); }),
      count(all, [](const Flown& f) { return f.succeeded; }),
      wrongly > 0 ? fmt::format(", {} wrongly", wrongly) : "", down.share(0.5), down.most(),
      sideways.share(0.5), sideways.most(),
      of([](const Flown& f) { return f.contact_tilt_deg; }).most(), reported);
  say(line);
  return line + "\n";
}

std::string in_phase(std::string_view name, Phase phase) {
  return fmt::format("{}, {}", name, kPhaseNames[static_cast<std::size_t>(phase)]);
}

// Flights that were not survived are printed.
std::string sensor_rows(unsigned seeds) {
  std::string text;
  for (const Failure& failure : sensor_failures()) {
    for (const Phase phase : kStruckPhases) {
      const auto all = runs(seeds, [&](unsigned seed) { return fail_in(phase, failure, seed); });
      text += failure_row(in_phase(failure.name, phase), failure.right, all, told(all));
      for (const Flown& flown : all)
        if (!survived(flown)) say(flown.text());
    }
  }
  return text;
}

// Each valve and fan, in each phase of its own.
std::string actuator_rows(unsigned seeds) {
  std::string text;
  std::map<std::string, std::vector<const ActuatorFailure*>> kinds;
  for (const ActuatorFailure& failure : actuator_failures())
    kinds[failure.kind].push_back(&failure);
  for (const auto& [kind, failures] : kinds) {
    for (const Phase phase : kStruckPhases) {
      const auto all = runs(seeds, [&, &failures = failures](unsigned seed) {
        return strike(*failures[seed % failures.size()], phase, seed);
      });
      std::vector<Flown> flown;
      Figures after;
      for (const Struck& struck : all) {
        flown.push_back(struck.flown);
        if (struck.found) after.add(struck.found_after_s);
      }
      const unsigned wrong_one = count(all, [](const Struck& s) { return s.wrong; });
      text += failure_row(
          in_phase(kind, phase), failures.front()->often_lost ? "found" : "survived", flown,
          fmt::format("{} found: {:.2f}, {:.2f} s{}", after.size(), after.share(0.5), after.most(),
                      wrong_one > 0 ? fmt::format("; other {}", wrong_one) : ""));
    }
  }
  return text;
}

}  // namespace

std::string sensors_section(unsigned seeds) { return kFailureHead + sensor_rows(seeds); }
std::string actuators_section(unsigned seeds) { return kFailureHead + actuator_rows(seeds); }

std::string failures_section(unsigned seeds, unsigned phase_seeds) {
  std::string text = fmt::format(
      R"({} hops each, the failure between 1 and 17 s after lift-off, evenly spread; of IMU, altimeter, valves and fans {} hops in
each phase, narrow dispersion with the fans' torque of the wide set. Survived: upright (less than 10 deg of tilt in the end), at
most {:g} m/s down. Speeds, and times after which a failure was found: in the median, and at most; tilt: at touchdown, at most.
Reported: faults, and the number of flights with each; *other*: flights in which another failure was found before or instead.

)",
      seeds, phase_seeds, kSurvived_m_s);
  text += kFailureHead;
  for (const Failure& failure : failures()) {
    const auto all = runs(seeds, [&](unsigned seed) { return fail(failure, seed, seeds); });
    text += failure_row(failure.name, failure.right, all, told(all));
  }
  return text + sensor_rows(phase_seeds) + actuator_rows(phase_seeds);
}

}  // namespace lss::talaris
