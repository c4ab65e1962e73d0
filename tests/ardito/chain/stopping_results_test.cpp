// Stopping distances on the whole chain in physics: no cause needs more than its reaction time and
// the configured deceleration. With LSS_WRITE_RESULTS set, all causes, into docs/ardito-results.md.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "idl/angles.h"
#include "tests/ardito/chain/chain.h"
#include "tests/ardito/chain/jobs.h"
#include "tests/ardito/chain/results_document.h"
#include "tests/support/everything.h"

namespace lss::ardito {
namespace {

using testing_support::in_sample;

struct StopCause {
  const char* name;
  const char* how;
  std::function<void(Chain&)> stop;
  bool by_itself = false;  // autonomous driving
};

const std::vector<StopCause> kStopCauses = {
    {"`halt`, `stop`, Ctrl-C", "safe stop", [](Chain& c) { c.send(lss::CommandKind::stop); }},
    {"killed client, lease of 2 s", "safe stop when the lease is over",
     [](Chain& c) { c.heartbeat(false); }},
    {"IMU lost, autonomous driving", "safe stop, back to driving by hand",
     [](Chain& c) { c.inject("imu-silent"); }, true},
    {"emergency stop by command", "quick stop at once",
     [](Chain& c) { c.send(lss::CommandKind::emergency_stop); }},
    {"emergency-stop button, motor power lost", "drives without power: wheels roll out",
     [](Chain& c) { c.inject("e-stop-button"); }},
    {"wheel drive in fault", "quick stop of the others in the next frame",
     [](Chain& c) { c.inject("drive-fault:0x03"); }},
    {"wheel drive silent", "its heartbeat, 300 ms, then quick stop",
     [](Chain& c) { c.inject("node-silent:0x05"); }},
    {"I/O node silent", "its heartbeat, 300 ms, then quick stop",
     [](Chain& c) { c.inject("node-silent:0x20"); }},
    {"steering motor stuck in a curve", "failure detection, then quick stop",
     [](Chain& c) {
       c.inject("SM:1");
       c.send(CommandKind::drive, {c.telemetry().speed_m_s, 3 * kDegree, 1.0, 0.0});
     }},
    {"cycle halted", "bus thread: orders older than 300 ms, quick stop",
     [](Chain& c) { c.daemon = Chain::Daemon::halted; }},
    {"daemon or computer dead", "nodes: heartbeat of the master, 300 ms, quick stop",
     [](Chain& c) { c.daemon = Chain::Daemon::killed; }},
};

struct Stopping {
  double way_m = 0, time_s = 0;
  bool stood = false;
};

Stopping stop_by(const StopCause& cause, double speed_m_s, double slope_rad, unsigned seed) {
  Chain chain({.rover = {.slope_rad = slope_rad}, .seed = seed, .adjust = [](Parameters& p) {
                 p.beacon_ns = p.autonomy_ns = 1500 * kMillisecond;
                 p.mobility.top_speed_m_s = 1;
               }});
  Stopping result;
  if (!chain.start(speed_m_s > 0.5 ? SpeedLimit::urc : SpeedLimit::erc)) return result;
  chain.lease_ms = 2000;
  chain.send(CommandKind::drive, {speed_m_s, 0.0, 1.0, cause.by_itself ? 1.0 : 0.0});
  const auto speed = [&] { return chain.world().rover().body().velocity_m_s.norm(); };
  if (!chain.run_until([&] { return speed() > 0.97 * speed_m_s; }, 20)) return result;
  chain.run(1 + 0.013 * seed);  // another moment of the frame
  const Eigen::Vector3d from = chain.world().rover().body().position_m;
  const double from_s = chain.seconds();
  cause.stop(chain);
  for (int n = 0; n < 2000 && !result.stood; ++n) {
    chain.run(0.01);
    result.stood = speed() < 0.02;
  }
  result.way_m = (chain.world().rover().body().position_m - from).norm();
  result.time_s = chain.seconds() - from_s;
  return result;
}

TEST(ArditoResults, StoppingDistances) {
  const unsigned seeds = writing_results() ? 3 : 1;
  std::string text =
      "| cause | how it stops | 0.5 m/s: m | s | 1.0 m/s: m | s | 0.5 m/s down 5 deg: m | s "
      "|\n|---|---|---|---|---|---|---|---|\n";
  constexpr std::pair<double, double> kDrives[] = {{0.5, 0}, {1.0, 0}, {0.5, -5 * kDegree}};
  const std::size_t each = std::size(kDrives) * seeds;
  const auto runs_cause = [](std::size_t cause) {
    return writing_results() || in_sample(cause, 4);
  };
  std::vector<Stopping> runs(kStopCauses.size() * each);
  for_each_job(runs.size(), [&](std::size_t i) {
    const auto& [speed_m_s, slope_rad] = kDrives[i % each / seeds];
    if (!runs_cause(i / each) || (!writing_results() && slope_rad != 0)) return;
    runs[i] =
        stop_by(kStopCauses[i / each], speed_m_s, slope_rad, static_cast<unsigned>(i % seeds + 1));
  });
  for (std::size_t number = 0; number < kStopCauses.size(); ++number) {
    if (!runs_cause(number)) continue;
    const StopCause& cause = kStopCauses[number];
    std::size_t run = number * each;
    text += fmt::format("| {} | {} |", cause.name, cause.how);
    for (const auto& [speed_m_s, slope_rad] : kDrives) {
      Stopping worst;
      const std::size_t first = run;
      run += seeds;
      if (!writing_results() && slope_rad != 0) continue;
      for (std::size_t i = first; i < run; ++i) {
        const Stopping& one = runs[i];
        EXPECT_TRUE(one.stood) << cause.name;
        worst.way_m = std::max(worst.way_m, one.way_m);
        worst.time_s = std::max(worst.time_s, one.time_s);
      }
      text += fmt::format(" {:.2f} | {:.1f} |", worst.way_m, worst.time_s);
      if (slope_rad != 0) continue;
      const bool safe = std::string_view(cause.how).starts_with("safe stop");
      const double leased_s = std::string_view(cause.name).starts_with("killed") ? 2.3 : 0.5;
      const double most_m = safe ? speed_m_s * leased_s + speed_m_s * speed_m_s / (2 * 0.5) + 0.15
                                 : speed_m_s * 1.2 + speed_m_s * speed_m_s / 2;
      EXPECT_LT(worst.way_m, most_m) << cause.name << " from " << speed_m_s;
    }
    text += "\n";
    if (writing_results()) fmt::print("{}", text.substr(text.rfind('\n', text.size() - 2) + 1));
  }
  fmt::print("{}", text);
  if (!writing_results()) return;
  write_section(
      "Stopping",
      measured_by("ArditoResults.StoppingDistances") +
          fmt::format("From the cause to standstill (below 0.02 m/s), true, worst of {} seeds; "
                      "straight ahead. Safe stop: `deceleration_m_s2`\n(0.5 m/s2); quick stop: the "
                      "drives' `wheel_acceleration_rpm_s` (2.5 m/s2) as far as friction allows. "
                      "Without motor power\nthe gears alone brake: above 8 deg of slope the rover "
                      "rolls on, as in Idle.\n\n",
                      seeds) +
          text);
}

}  // namespace
}  // namespace lss::ardito
