// Report sections of D.I.A.N.A. Ardito: wheels, steering, results of the failure detection, and the
// path.

#include <fmt/format.h>

#include "idl/angles.h"
#include "idl/ardito/commands.h"
#include "tools/lss-cli/ardito/vehicle.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"

namespace lss::cli::ardito {
namespace {

using namespace lss::ardito;
using report::line_of;
using report::LineChart;
using report::over_time;
using report::Table;

constexpr double kDegrees = 1 / kDegree;
constexpr const char* kSteered[kSteeredWheels] = {"LF", "RF", "LR", "RR"};
constexpr int kStates = 8;  // three bits, Ardito thesis 18.1

std::string wheel(int i, const char* what) { return fmt::format("wheels[{}].{}", i, what); }
std::string steering(int i, const char* what) { return fmt::format("steering[{}].{}", i, what); }

void add_wheels(const Table& table, report::Page& page) {
  page.section("Wheels", "Dashed: as commanded; drawn: by the motor encoder.");
  LineChart speeds = over_time("Wheel speeds", "rad/s");
  LineChart currents = over_time("Motor currents", "A");
  LineChart heat = over_time("Motor temperatures", "°C");
  for (int i = 0; i < kDriveWheels; ++i) {
    speeds.lines.push_back(line_of(table, kNodeNames[i], wheel(i, "motor_rad_s"), i));
    currents.lines.push_back(line_of(table, kNodeNames[i], wheel(i, "current_A"), i));
    heat.lines.push_back(line_of(table, kNodeNames[i], wheel(i, "temperature_degC"), i));
  }
  speeds.lines.push_back(line_of(table, "LF, commanded", wheel(0, "target_rad_s"), 0, true));
  speeds.lines.push_back(line_of(table, "RF, commanded", wheel(1, "target_rad_s"), 1, true));
  page.add(speeds);
  page.add(currents);
  LineChart angles = over_time("Steering", "deg, to the left");
  for (int i = 0; i < kSteeredWheels; ++i) {
    const std::string name = kSteered[i];
    angles.lines.push_back(line_of(table, name, steering(i, "motor_rad"), i, false, kDegrees));
    angles.lines.push_back(
        line_of(table, name + ", commanded", steering(i, "target_rad"), i, true, kDegrees));
  }
  page.add(angles);
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
  for (int i = 0; i < kSteeredWheels; ++i)
    add(fmt::format("str. {}", kSteered[i]), table[steering(i, "state")],
        table[steering(i, "stopped")], true);
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
  page.add(over_time("Speed", "m/s",
                     {line_of(table, "commanded", "speed_m_s", 0, true),
                      line_of(table, "measured", "measured_m_s", 0)}));
  page.add(over_time("Suspension", "deg",
                     {line_of(table, "left rocker", "beta_rad", 0, false, kDegrees),
                      line_of(table, "left bogie", "rho_rad[0]", 1, false, kDegrees),
                      line_of(table, "right bogie", "rho_rad[1]", 2, false, kDegrees)}));
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
