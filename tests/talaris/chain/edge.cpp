// The wide set of dispersions, single causes, and the edge of the envelope: each cause alone, from
// none to more than the vehicle stands.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>

#include "idl/angles.h"
#include "idl/talaris/codes.h"
#include "tests/talaris/chain/campaigns.h"
#include "tests/talaris/chain/many.h"

namespace lss::talaris {
namespace {

using sim::talaris::kWide;
using sim::talaris::TalarisOptions;

constexpr double kSlow_m_s = 1.0, kSideways_m_s = 0.5, kNear_m = 6;

void show(const std::string& line) {
  std::fputs(line.c_str(), stdout);
  std::fflush(stdout);
}

std::string why_failed(const std::vector<Flown>& all) {
  std::map<std::string, unsigned> times;
  for (const Flown& flown : all) {
    if (flown.succeeded) continue;
    const bool course = std::ranges::count(flown.faults, faults::corridor_left) != 0;
    const char* why = !flown.accepted             ? "not accepted"
                      : flown.why == Reason::none ? "nothing"
                      : course                    ? "corridor_left"
                                                  : info(flown.why)->name;
    ++times[why];
  }
  std::string text;
  for (const auto& [name, n] : times)
    text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", name, n);
  return text.empty() ? "-" : text;
}

constexpr const char* kColumns =
    "| cause | value | upright | gentle | claimed | wrong | most down, m/s | most sideways, m/s "
    "| others: reported |\n|---|---|---|---|---|---|---|---|---|\n";

std::string row(const std::string& cause, const std::string& value, const std::vector<Flown>& all) {
  return fmt::format("| {} | {} | {} | {} | {} | {} | {:.2f} | {:.2f} | {} |\n", cause, value,
                     count(all, [](const Flown& f) { return f.upright(); }), count(all, safe),
                     count(all, [](const Flown& f) { return f.succeeded; }), count(all, wrong),
                     figures(all, [](const Flown& f) { return f.down_m_s; }).most(),
                     figures(all, [](const Flown& f) { return f.sideways_m_s; }).most(),
                     why_failed(all));
}

// One cause, from nothing to more than the vehicle stands.
struct Cause {
  const char* name;
  const char* unit;
  std::vector<double> values;
  std::function<void(FlightPlan&, double)> set;
};

std::function<void(FlightPlan&, double)> in_world(void (*change)(TalarisOptions&, double)) {
  return [change](FlightPlan& plan, double value) {
    plan.world = [change, value](TalarisOptions& world) { change(world, value); };
  };
}

template <int kTo_deg>
void push(TalarisOptions& world, double push_N) {
  world.air.push_N = push_N;
  world.air.to_rad = kTo_deg * kDegree;
}

const std::vector<Cause>& causes() {
  static const std::vector<Cause> all = {
      {"steady push across", "N", {0, 10, 20, 30, 40, 50, 60}, in_world(push<90>)},
      {"steady push against the way", "N", {0, 10, 20, 30, 40, 50, 60}, in_world(push<180>)},
      {"gusts on a steady push of 20 N across, in all",
       "N",
       {20, 30, 40, 50, 60, 80},
       in_world([](TalarisOptions& w, double v) {
         w.air.push_N = 20;
         w.air.gust_N = v - 20;
         w.air.to_rad = 90 * kDegree;
       })},
      {"wind in air, across", "m/s", {0, 2, 4, 6, 8, 10}, in_world([](TalarisOptions& w, double v) {
         w.air.density_kg_m3 = 1.2;
         w.air.wind_m_s = v;
         w.air.to_rad = 90 * kDegree;
       })},
      {"centre of mass off along y",
       "mm",
       {0, 2, 4, 6, 8, 10, 12},
       in_world([](TalarisOptions& w, double v) { w.plant.cg_m.y() = v * 1e-3; })},
      {"centre of mass off along z",
       "mm",
       {0, 2, 4, 6, 8, 10, 12},
       in_world([](TalarisOptions& w, double v) { w.plant.cg_m.z() = v * 1e-3; })},
      {"slope, uphill along the way",
       "deg",
       {0, 2, 4, 6, 8, 10},
       in_world([](TalarisOptions& w, double v) { w.plant.slope_rad = v * kDegree; })},
      {"slope across the way",
       "deg",
       {0, 2, 4, 6, 8, 10},
       in_world([](TalarisOptions& w, double v) {
         w.plant.slope_rad = v * kDegree;
         w.plant.uphill_rad = 90 * kDegree;
       })},
      {"tanks not full", "%", {0, 4, 8, 12}, in_world([](TalarisOptions& w, double v) {
         w.gas.fill = 1 - v / 100;
       })},
      {"pressure lost by each further open valve",
       "%",
       {0, 2, 4, 6, 8},
       in_world([](TalarisOptions& w, double v) { w.gas.droop = v / 100; })},
      {"vibration", "m/s2", {0, 0.5, 1, 2, 4}, in_world([](TalarisOptions& w, double v) {
         w.imu.vibration_m_s2 = v;
         w.imu.vibration_rad_s = 0.02 * v;
       })},
      {"scale and axes of the IMU",
       "x 0.1 %",
       {0, 1, 2, 5, 10},
       in_world([](TalarisOptions& w, double v) {
         w.imu.gyro_scale = w.imu.accel_scale = w.imu.skewed_rad = v * 1e-3;
         w.imu.misaligned_rad = 2e-3 * v;
       })},
      {"latency of the altimeter",
       "ms",
       {0, 30, 60, 100, 150},
       in_world([](TalarisOptions& w, double v) { w.altimeter.latency_s = v * 1e-3; })},
      {"orders late, one frame in ten",
       "ms",
       {0, 10, 20, 40, 60},
       [](FlightPlan& plan, double v) {
         plan.late_share = 0.1;
         plan.late_s = v * 1e-3;
       }},
  };
  return all;
}

struct Point {
  double value;
  unsigned upright, safe, planned, seeds;
};

// Small panels, one below the other: share that stands (bold), that is safe, and that says "as
// planned", over the cause.
std::string drawn(const std::vector<std::pair<const Cause*, std::vector<Point>>>& all) {
  constexpr int kWidth = 640, kPanel = 92, kLeft = 330, kRight = 620, kHigh = 54;
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" height=\"{}\" "
      "font-family=\"sans-serif\" "
      "font-size=\"12\">\n<rect width=\"100%\" height=\"100%\" fill=\"white\"/>\n"
      "<text x=\"10\" y=\"16\">black: stands; blue: and gently; green: says \"as planned\". 0 to "
      "100 %"
      "</text>\n",
      kWidth, kPanel * static_cast<int>(all.size()) + 30);
  int top = 30;
  for (const auto& [cause, points] : all) {
    const double least = points.front().value;
    const double span = std::max(points.back().value - least, 1e-9);
    const auto x = [&](double v) { return kLeft + (v - least) / span * (kRight - kLeft); };
    const auto line = [&](const char* colour, int width, auto share) {
      std::string path;
      for (const Point& p : points)
        path += fmt::format("{:.0f},{:.0f} ", x(p.value),
                            top + kHigh - kHigh * static_cast<double>(share(p)) / p.seeds);
      svg +=
          fmt::format("<polyline points=\"{}\" fill=\"none\" stroke=\"{}\" stroke-width=\"{}\"/>\n",
                      path, colour, width);
    };
    svg += fmt::format("<text x=\"10\" y=\"{}\">{}, {}</text>\n", top + kHigh / 2, cause->name,
                       cause->unit);
    svg += fmt::format("<path d=\"M{} {}V{}H{}\" fill=\"none\" stroke=\"gray\"/>\n", kLeft, top,
                       top + kHigh, kRight);
    line("green", 1, [](const Point& p) { return p.planned; });
    line("blue", 1, [](const Point& p) { return p.safe; });
    line("black", 2, [](const Point& p) { return p.upright; });
    for (const Point& p : points)
      svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" text-anchor=\"middle\">{:g}</text>\n",
                         x(p.value), top + kHigh + 14, p.value);
    top += kPanel;
  }
  return svg + "</svg>\n";
}

// What navigation's covariance predicts: both axes alike and normal, the distance is Rayleigh's.
std::string predicted(const std::vector<Flown>& all) {
  const auto below = [](double share, double sigma) {
    return sigma * std::sqrt(-2 * std::log(1 - share));
  };
  const double m = figures(all, [](const Flown& f) { return f.sigma_m; }).share(0.5);
  const double m_s = figures(all, [](const Flown& f) { return f.sigma_m_s; }).share(0.5);
  return fmt::format(
      "\nNavigation's covariance at touchdown predicts {:.2f} m and {:.3f} m/s (1 sigma of each "
      "axis): off by {:.2f} m in the\nmedian and {:.2f} m in 95 %, speed by {:.2f} and {:.2f} "
      "m/s.\n",
      m, m_s, below(0.5, m), below(0.95, m), below(0.5, m_s), below(0.95, m_s));
}

// The wide set with one set of sensors.
std::string wide_flights(const FlightPlan& plan, unsigned seeds) {
  const auto all = runs(seeds, [&](unsigned seed) {
    const Flown flown = fly(plan, seed);
    if (!flown.succeeded || wrong(flown)) show(flown.text() + "\n");
    return flown;
  });
  const unsigned upright = count(all, [](const Flown& f) { return f.upright(); });
  const unsigned gentle = count(all, safe);
  const unsigned planned = count(all, [](const Flown& f) { return f.succeeded; });
  std::string text = fmt::format(
      "Upright: **{} of {}**; with at most {:g} m/s down and {:g} m/s sideways: **{}**. Reported "
      "\"as planned\": {}; **{}**\nof these were not (gentle, and within {:g} m of the target). "
      "Causes of the others: {}.\n\n",
      upright, seeds, kSlow_m_s, kSideways_m_s, gentle, planned, count(all, wrong), kNear_m,
      why_failed(all));
  text += "| | median | 95 % | most |\n|---|---|---|---|\n";
  const auto row = [&](const char* what, auto get) {
    const Figures f = figures(all, get);
    text += fmt::format("| {} | {:.2f} | {:.2f} | {:.2f} |\n", what, f.share(0.5), f.share(0.95),
                        f.most());
  };
  row("landing speed, down, m/s", [](const Flown& f) { return f.down_m_s; });
  row("landing speed, sideways, m/s", [](const Flown& f) { return f.sideways_m_s; });
  row("place, from the target, m", [](const Flown& f) { return f.off_m(); });
  row("- of that navigation's own error, m", [](const Flown& f) { return f.nav_off_m(); });
  row("speed of navigation, sideways, off by, m/s", [](const Flown& f) { return f.nav_side_m_s; });
  row("tilt in the air, deg", [](const Flown& f) { return f.max_tilt_deg; });
  row("gas, thruster-seconds of 44", [](const Flown& f) { return f.gas_s; });
  return text + predicted(all);
}

}  // namespace

FlightPlan wide_flight() { return {.spread = kWide, .late_share = 0.02, .late_s = 0.010}; }

bool safe(const Flown& flown) {
  return flown.upright() && flown.down_m_s <= kSlow_m_s && flown.sideways_m_s <= kSideways_m_s;
}

bool wrong(const Flown& flown) {
  return flown.succeeded && !(safe(flown) && flown.off_m() <= kNear_m);
}

std::string wide_section(unsigned seeds) {
  std::string text = fmt::format(
      R"(The same hop, seeds 1 to {}, with everything at once, evenly unless "sigma": mass {:.0f} %, inertia {:.0f} %, centre of mass
{:.0f} mm in height and {:.1f} mm sideways, each valve {:.0f} %, each fan {:.0f} % and its lag {:.0f} %, tanks up to {:.0f} % short, pressure up to {:.0f} % less
for each further open valve and {:.0f} % with the last gas, fan torque {:.0f} mN m a N and {:.0f} %, rotors {:.0e} kg m2, IMU scale {:.1f} % sigma, mounting {:.0f} mrad
sigma, axes {:.1f} mrad sigma, vibration up to {:.1f} m/s2, altimeter {:.0f} mm and up to {:.0f} ms late, slope up to {:.0f} deg, wind up to {:.1f} m/s with gusts
of up to {:.1f} m/s more (both in any direction) in air of {:.1f} kg/m3, one frame in fifty up to 10 ms late.

)",
      seeds, 100 * kWide.mass, 100 * kWide.inertia, 1e3 * kWide.cg_x_m, 1e3 * kWide.cg_m,
      100 * kWide.valve_thrust, 100 * kWide.fan_thrust, 100 * kWide.fan_lag, 100 * kWide.tank_fill,
      100 * kWide.droop, 100 * kWide.fade, 1e3 * kWide.fan_torque_m, 100 * kWide.fan_torque,
      kWide.rotor_kg_m2, 100 * kWide.imu_scale_sigma, 1e3 * kWide.imu_misaligned_sigma_rad,
      1e3 * kWide.imu_skewed_sigma_rad, kWide.vibration_m_s2, 1e3 * kWide.altimeter_bias_m,
      1e3 * kWide.altimeter_latency_s, kWide.slope_rad / kDegree, kWide.wind_m_s, kWide.gust_m_s,
      kWide.density_kg_m3);
  return text + "### As built\n" + wide_flights(wide_flight(), seeds);
}

std::string camera_section(unsigned seeds) {
  return fmt::format(
             "### With a camera\nThe same with a camera, its scale off by {:.1f} % (sigma).\n\n",
             100 * kWide.camera_scale_sigma) +
         wide_flights(with_camera(wide_flight()), seeds);
}

std::string corners_section(unsigned seeds) {
  return "### With altimeters at the corners\nThe same with four more altimeters, each with a bias "
         "of its own of up to that of the first.\n\n" +
         wide_flights(with_corner_altimeters(wide_flight()), seeds);
}

const std::array<Alone, 3> kAlone = {{
    {"centre_of_mass", "centre of mass off sideways", "10 mm",
     [](TalarisOptions& w, double to_rad) {
       w.plant.cg_m.y() = 0.010 * std::sin(to_rad);
       w.plant.cg_m.z() = 0.010 * std::cos(to_rad);
     }},
    {"wind", "steady push of 20 N with gusts, in all", "40 N",
     [](TalarisOptions& w, double to_rad) {
       w.air.push_N = 20;
       w.air.gust_N = 20;
       w.air.to_rad = to_rad;
     }},
    {"slope", "slope", "8 deg",
     [](TalarisOptions& w, double to_rad) {
       w.plant.slope_rad = 8 * kDegree;
       w.plant.uphill_rad = to_rad;
     }},
}};

std::vector<Flown> fly_alone(const Alone& cause, unsigned seeds) {
  return runs(seeds, [&](unsigned seed) {
    constexpr double kGolden_rad = 2.39996;  // fills the circle evenly
    FlightPlan plan;
    plan.world = [&, seed](TalarisOptions& world) { cause.set(world, kGolden_rad * seed); };
    return fly(plan, seed);
  });
}

std::string alone_section(unsigned seeds) {
  std::string text = fmt::format(
      "Each alone on the vehicle of the full hop (narrow dispersion), seeds 1 to {}, the direction "
      "another one with each seed.\nGentle: at most {:g} m/s down and {:g} m/s sideways; claimed: "
      "reported \"as planned\"; wrong: claimed, and was not.\n\n{}",
      seeds, kSlow_m_s, kSideways_m_s, kColumns);
  for (const Alone& cause : kAlone) {
    text += row(cause.what, cause.value, fly_alone(cause, seeds));
    show(text.substr(text.rfind('\n', text.size() - 2) + 1));
  }
  return text;
}

std::string edge_section(unsigned seeds, const std::string& picture) {
  std::string text = fmt::format(
      "Likewise, {} seeds at each value of the picture. At values that the table omits all flights "
      "were gentle and claimed,\nnone wrong.\n\n"
      "![The edge of the envelope](images/talaris-envelope.svg)\n\n{}",
      seeds, kColumns);
  std::string clear;  // causes of which all flights were good
  std::vector<std::pair<const Cause*, std::vector<Point>>> all;
  for (const Cause& cause : causes()) {
    std::vector<Point> points;
    bool all_good = true;
    for (const double value : cause.values) {
      const auto flown = runs(seeds, [&](unsigned seed) {
        FlightPlan plan;
        cause.set(plan, value);
        return fly(plan, seed);
      });
      const Point point{value, count(flown, [](const Flown& f) { return f.upright(); }),
                        count(flown, safe),
                        count(flown, [](const Flown& f) { return f.succeeded; }), seeds};
      points.push_back(point);
      const std::string line = row(cause.name, fmt::format("{:g} {}", value, cause.unit), flown);
      show(line);
      if (point.safe == seeds && point.planned == seeds && count(flown, wrong) == 0) continue;
      text += line;
      all_good = false;
    }
    if (all_good)
      clear += fmt::format("- {}: {:g} {}\n", cause.name, cause.values.back(), cause.unit);
    all.emplace_back(&cause, points);
  }
  if (!clear.empty()) text += "\nOmitted up to the largest value:\n\n" + clear;
  if (!picture.empty()) std::ofstream(picture) << drawn(all);
  return text;
}

}  // namespace lss::talaris
