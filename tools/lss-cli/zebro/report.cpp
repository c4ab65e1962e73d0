// Report sections of Lunar Zebro: gait, legs, and distance.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "idl/zebro/commands.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/zebro/vehicle.h"

namespace lss::cli::zebro {
namespace {

using namespace lss::zebro;
using report::line_of;
using report::LineChart;
using report::over_time;
using report::Table;

constexpr double kGait_s = 15;  // of the gait, so that single steps are visible

std::string column(int module, const char* what) {
  return fmt::format("modules[{}].{}", module, what);
}

// The start of the first walk; without one, the beginning.
report::Range walking(const Table& table) {
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table["mode"][i] == static_cast<double>(Mode::walking))
      return {table.t_s()[i], table.t_s()[i] + kGait_s};
  }
  return {table.t_s().front(), table.t_s().front() + kGait_s};
}

void add_gait(const Table& table, report::Page& page) {
  page.section("Gait",
               fmt::format("The first {} s of walking: which leg stands, which swings.", kGait_s));
  report::RowChart gait{"Stance and swing",
                        "time in s",
                        {},
                        walking(table),
                        {{"c0", "stance"}, {"c1", "swing"}, {"bad", "out of service"}}};
  LineChart angles = over_time("Legs", "deg from straight down", {}, gait.x);
  for (int leg = 0; leg < kLegs; ++leg) {
    std::vector<double> state = table[column(leg, "swing")];
    const auto& isolated = table[column(leg, "isolated")];
    const auto& on = table[column(leg, "motion_control")];
    for (std::size_t i = 0; i < state.size(); ++i)
      state[i] = isolated[i] > 0 ? 2 : on[i] > 0 ? state[i] : 3;
    gait.rows.push_back(
        {kModuleNames[leg],
         report::bars_of(table.t_s(), state,
                         {{"c0", "stance"}, {"c1", "swing"}, {"bad", "out of service"}})});
    // The angle wraps after a full turn: no line across the wrap.
    std::vector<double> degrees;
    for (double rad : table[column(leg, "position_rad")])
      degrees.push_back(std::remainder(rad, 2 * std::numbers::pi) * 180 / std::numbers::pi);
    for (std::size_t i = 1; i < degrees.size(); ++i) {
      if (std::abs(degrees[i] - degrees[i - 1]) > 180) degrees[i - 1] = report::kUnset;
    }
    angles.lines.push_back({kModuleNames[leg], table.t_s(), degrees, leg, false});
  }
  page.add(gait);
  page.add(angles);
}

void add_modules(const Table& table, report::Page& page) {
  page.section("Modules");
  for (const auto& [title, unit, what] : {std::tuple{"Currents", "A", "current_A"},
                                          std::tuple{"Temperatures", "°C", "temperature_degC"},
                                          std::tuple{"Supply", "V", "supply_V"}}) {
    LineChart chart = over_time(title, unit);
    for (int module = 0; module < kModules; ++module)
      chart.lines.push_back(line_of(table, kModuleNames[module], column(module, what), module));
    page.add(chart);
  }
}

void add_way(const Table& table, report::Page& page) {
  page.section("Way", "By dead reckoning from the legs in stance.");
  page.add(over_time("Distance", "m", {line_of(table, "along the body", "distance_m", 0)}));
  page.add(over_time("Speed", "m/s", {line_of(table, "along the body", "speed_m_s", 0)}));
}

}  // namespace

void add_report(const recording::Recording& recording, report::Page& page) {
  const Table table(recording, "telemetry",
                    {"mode", "distance_m", "speed_m_s", "modules[*].swing", "modules[*].isolated",
                     "modules[*].motion_control", "modules[*].position_rad", "modules[*].current_A",
                     "modules[*].temperature_degC", "modules[*].supply_V"});
  if (table.empty()) return page.note("Nothing was recorded of the telemetry.");
  add_gait(table, page);
  add_modules(table, page);
  add_way(table, page);
}

}  // namespace lss::cli::zebro
