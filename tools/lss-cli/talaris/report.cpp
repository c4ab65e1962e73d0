// Report sections of TALARIS: the hop, its attitude, valves, fans and gas.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "idl/angles.h"
#include "idl/talaris/commands.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/talaris/vehicle.h"

namespace lss::cli::talaris {
namespace {

using report::line_of;
using report::LineChart;
using report::over_time;
using report::Table;

constexpr double kDegrees = 1 / kDegree;
constexpr int kValves = 8, kFans = 4;

// The time in the air, with a margin before and after; without a flight the whole recording.
report::Range flight(const Table& table) {
  const auto& airborne = table["airborne"];
  constexpr double kAround_s = 3;
  report::Range range;
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (airborne[i] <= 0) continue;
    if (std::isnan(range.from)) range.from = table.t_s()[i] - kAround_s;
    range.to = table.t_s()[i] + kAround_s;
  }
  return std::isnan(range.from) ? report::Range{table.t_s().front(), table.t_s().back()} : range;
}

// Roll, pitch, yaw (about x, which is up, y and z) in degrees.
std::vector<report::Line> attitude(const Table& table) {
  std::vector<report::Line> lines = {{"about x (up)", table.t_s(), {}, 0, false},
                                     {"about y", table.t_s(), {}, 1, false},
                                     {"about z (ahead)", table.t_s(), {}, 2, false}};
  for (std::size_t i = 0; i < table.size(); ++i) {
    double q[4];
    for (std::size_t k = 0; k < 4; ++k) q[k] = table[fmt::format("attitude_wxyz[{}]", k)][i];
    // The rotation vector: axis and angle.
    const double sine = std::hypot(q[1], q[2], q[3]);
    const double angle = 2 * std::atan2(sine, std::abs(q[0])) * (q[0] < 0 ? -1 : 1);
    for (std::size_t k = 0; k < 3; ++k)
      lines[k].y.push_back(sine > 0 ? angle * q[k + 1] / sine * kDegrees : 0);
  }
  return lines;
}

void add_hop(const Table& table, const report::Range& range, report::Page& page) {
  page.section("Hop", "Dashed: as planned. Axes of where it stood: x up, z along the way.");
  page.add(over_time("Height", "m",
                     {line_of(table, "navigated", "position_m[0]", 0),
                      line_of(table, "target", "target_position_m[0]", 0, true),
                      line_of(table, "altimeter", "range_m", 1)},
                     range));
  page.add(over_time("Way", "m",
                     {line_of(table, "along z", "position_m[2]", 0),
                      line_of(table, "target", "target_position_m[2]", 0, true),
                      line_of(table, "across, y", "position_m[1]", 1)},
                     range));
  page.add(over_time("Velocity", "m/s",
                     {line_of(table, "up", "velocity_m_s[0]", 0),
                      line_of(table, "up, target", "target_velocity_m_s[0]", 0, true),
                      line_of(table, "along", "velocity_m_s[2]", 1),
                      line_of(table, "along, target", "target_velocity_m_s[2]", 1, true)},
                     range));
  page.add(over_time("Attitude", "deg", attitude(table), range));
}

void add_valves(const Table& table, const report::Range& range, report::Page& page) {
  page.section("Valves and gas", "Pulses as commanded, frame by frame.");
  report::RowChart chart{
      "Valve pulses", "time in s", {}, range, {{"c0", "lift"}, {"c1", "ahead"}, {"c2", "back"}}};
  // Of valves 1..8: 1, 3, 5, 7 lift, 2 and 8 push to +z, 4 and 6 to -z.
  constexpr const char* kLooks[kValves] = {"c0", "c1", "c0", "c2", "c0", "c2", "c0", "c1"};
  for (int valve = 0; valve < kValves; ++valve) {
    const auto column = [&](const char* what) { return fmt::format("valves[{}].{}", valve, what); };
    const auto &on = table[column("on_s")], &delay = table[column("delay_s")],
               &open = table[column("open")];
    report::Row row{fmt::format("valve {}", valve + 1), {}};
    for (std::size_t i = 0; i < table.size(); ++i) {
      const double t = table.t_s()[i];
      double from = t + delay[i], to = from + on[i];
      if (on[i] <= 0) {  // opened by hand
        if (open[i] <= 0 || i + 1 >= table.size()) continue;
        from = t;
        to = table.t_s()[i + 1];
      }
      // Pulses that follow each other without a gap are one bar.
      if (!row.bars.empty() && from - row.bars.back().to < 1e-3) {
        row.bars.back().to = std::max(row.bars.back().to, to);
      } else {
        row.bars.push_back({from, to, kLooks[valve], ""});
      }
      row.bars.back().tip = fmt::format("{:.3f} s for {:.0f} ms", row.bars.back().from,
                                        (row.bars.back().to - row.bars.back().from) * 1e3);
    }
    chart.rows.push_back(std::move(row));
  }
  page.add(chart);
  LineChart fans = over_time("Fans", "1000/min", {}, range);
  for (int fan = 0; fan < kFans; ++fan)
    fans.lines.push_back(line_of(table, fmt::format("fan {}", fan + 1),
                                 fmt::format("fans[{}].rpm", fan), fan, false, 1e-3));
  page.add(fans);
  page.add(over_time("Gas used", "thruster s",
                     {line_of(table, "used", "gas_thruster_s", 0),
                      line_of(table, "left, by the budget", "gas_left_thruster_s", 1, true)},
                     range));
  page.add(over_time("Pressure", "MPa",
                     {line_of(table, "tank", "pressure_Pa[0]", 0, false, 1e-6),
                      line_of(table, "regulated", "pressure_Pa[1]", 1, false, 1e-6)},
                     range));
}

}  // namespace

void add_report(const recording::Recording& recording, report::Page& page) {
  const Table table(recording, "telemetry",
                    {"airborne", "position_m[*", "velocity_m_s[*", "attitude_wxyz[*", "range_m",
                     "target_position_m[*", "target_velocity_m_s[*", "valves[*", "fans[*",
                     "gas_thruster_s", "gas_left_thruster_s", "pressure_Pa[*"});
  if (table.empty()) return page.note("Nothing was recorded of the telemetry.");
  const report::Range range = flight(table);
  add_hop(table, range, page);
  add_valves(table, range, page);
}

}  // namespace lss::cli::talaris
