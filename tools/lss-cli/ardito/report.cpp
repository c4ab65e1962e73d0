// Report sections of D.I.A.N.A. Ardito: wheels, steering, results of the failure detection, and the
// path.

#include <fmt/format.h>

#include <numbers>

#include "idl/ardito/commands.h"
#include "tools/lss-cli/ardito/vehicle.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"

namespace lss::cli::ardito {
namespace {

using namespace lss::ardito;
using report::LineChart;
using report::Table;

constexpr double kDegrees = 180 / std::numbers::pi;
constexpr int kStates = 8;  // three bits, Ardito thesis 18.1

std::string wheel(int i, const char* what) { return fmt::format("wheels[{}].{}", i, what); }
std::string steering(int i, const char* what) { return fmt::format("steering[{}].{}", i, what); }

std::vector<double> in_degrees(std::vector<double> values) {
  for (double& value : values) value *= kDegrees;
  return values;
}

void add_wheels(const Table& table, report::Page& page) {
  page.section("Wheels", "Dashed: as commanded; drawn: by the motor encoder.");
  LineChart speeds{"Wheel speeds", "time in s", "rad/s", {}, {}};
  LineChart currents{"Motor currents", "time in s", "A", {}, {}};
  for (int i = 0; i < kDriveWheels; ++i) {
    speeds.lines.push_back({kNodeNames[i], table.t_s(), table[wheel(i, "motor_rad_s")], i, false});
    currents.lines.push_back({kNodeNames[i], table.t_s(), table[wheel(i, "current_A")], i, false});
  }
  speeds.lines.push_back({"LF, commanded", table.t_s(), table[wheel(0, "target_rad_s")], 0, true});
  speeds.lines.push_back({"RF, commanded", table.t_s(), table[wheel(1, "target_rad_s")], 1, true});
  page.add(speeds);
  page.add(currents);
  LineChart angles{"Steering", "time in s", "deg, to the left", {}, {}};
  constexpr const char* kSteered[] = {"LF", "RF", "LR", "RR"};
  for (int i = 0; i < kSteeredWheels; ++i) {
    angles.lines.push_back(
        {kSteered[i], table.t_s(), in_degrees(table[steering(i, "motor_rad")]), i, false});
    angles.lines.push_back({fmt::format("{}, commanded", kSteered[i]), table.t_s(),
                            in_degrees(table[steering(i, "target_rad")]), i, true});
  }
  page.add(angles);
  LineChart heat{"Motor temperatures", "time in s", "°C", {}, {}};
  for (int i = 0; i < kDriveWheels; ++i)
    heat.lines.push_back(
        {kNodeNames[i], table.t_s(), table[wheel(i, "temperature_degC")], i, false});
  page.add(heat);
}

void add_failures(const Table& table, report::Page& page) {
  page.section("Failures",
               "What the failure detection found, as the thesis numbers its states (18.1).");
  report::RowChart chart{
      "Failure states",
      "time in s",
      {},
      {0, table.t_s().back()},
      {{"good", "no failure"}, {"warn", "a failure, mitigated"}, {"bad", "motor taken out"}}};
  std::vector<report::Look> looks(2 * kStates, {"warn", ""});
  for (int i = 0; i < kStates; ++i) {
    looks[static_cast<std::size_t>(i)] = {i == 0 ? "good" : "warn", fmt::format("state {}", i)};
    looks[static_cast<std::size_t>(i + kStates)] = {"bad", fmt::format("state {}, motor out", i)};
  }
  // An idle steering motor is off, too: that alone is no failure.
  const auto add = [&](const std::string& label, const std::vector<double>& state,
                       const std::vector<double>& stopped, bool rests) {
    std::vector<double> values = state;
    for (std::size_t i = 0; i < values.size(); ++i) {
      values[i] = std::min(values[i], kStates - 1.0);
      if (stopped[i] > 0 && !(rests && state[i] == 0)) values[i] += kStates;
    }
    chart.rows.push_back({label, report::bars_of(table.t_s(), values, looks)});
  };
  for (int i = 0; i < kDriveWheels; ++i)
    add(kNodeNames[i], table[wheel(i, "state")], table[wheel(i, "stopped")], false);
  for (int i = 0; i < kSteeredWheels; ++i) {
    constexpr const char* kLabels[] = {"str. LF", "str. RF", "str. LR", "str. RR"};
    add(kLabels[i], table[steering(i, "state")], table[steering(i, "stopped")], true);
  }
  page.add(chart);
}

void add_way(const Table& table, report::Page& page) {
  page.section("Way", "By dead reckoning from wheels, steering and IMU.");
  page.add(LineChart{"Seen from above",
                     "m to the left",
                     "m ahead",
                     {{"middle of the rover", table["y_m"], table["x_m"], 0, false}},
                     {},
                     true});
  page.add(LineChart{"Speed",
                     "time in s",
                     "m/s",
                     {{"commanded", table.t_s(), table["speed_m_s"], 0, true},
                      {"measured", table.t_s(), table["measured_m_s"], 0, false}},
                     {}});
  page.add(LineChart{"Suspension",
                     "time in s",
                     "deg",
                     {{"left rocker", table.t_s(), in_degrees(table["beta_rad"]), 0, false},
                      {"left bogie", table.t_s(), in_degrees(table["rho_rad[0]"]), 1, false},
                      {"right bogie", table.t_s(), in_degrees(table["rho_rad[1]"]), 2, false}},
                     {}});
}

}  // namespace

void add_report(const recording::Recording& recording, report::Page& page) {
  const Table table(recording, "telemetry",
                    {"wheels[*", "steering[*", "x_m", "y_m", "speed_m_s", "measured_m_s",
                     "beta_rad", "rho_rad[*]"});
  if (table.empty()) return page.note("Nothing was recorded of the telemetry.");
  add_wheels(table, page);
  add_failures(table, page);
  add_way(table, page);
}

}  // namespace lss::cli::ardito
