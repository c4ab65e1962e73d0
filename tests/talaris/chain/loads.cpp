#include "tests/talaris/chain/loads.h"

#include <algorithm>
#include <bit>
#include <fstream>
#include <stdexcept>

#include "tools/lss-cli/talaris/script.h"

namespace lss::talaris {
namespace {

constexpr std::size_t kSecond_frames = 5;  // whole periods of 7 Hz

bool acts(const Plateau& a) { return a.valves != 0 || a.fans != 0; }
bool same(const Plateau& a, const Plateau& b) {
  return a.valves == b.valves && a.fans == b.fans && a.throttle == b.throttle;
}

// What telemetry and the world show in this frame.
Plateau look(const Chain& chain) {
  Plateau now;
  const lss_TalarisTelemetry& t = chain.telemetry();
  for (std::size_t i = 0; i < kHopperValves; ++i) now.valves |= t.valves[i].open ? 1u << i : 0u;
  for (std::size_t i = 0; i < kHopperFans; ++i) {
    if (t.fans[i].throttle <= 0) continue;
    now.fans |= 1u << i;
    now.throttle = t.fans[i].throttle;
    now.rpm += t.fans[i].rpm;
    now.true_rpm += chain.world().fans().rpm(i);
  }
  const int turning = std::max(std::popcount(now.fans), 1);
  now.rpm /= turning, now.true_rpm /= turning;
  now.load << Eigen::Map<const Eigen::Vector3d>(t.load_N),
      Eigen::Map<const Eigen::Vector3d>(t.load_Nm);
  const auto gas = chain.world().gas().wrench(), lift = chain.world().fans().wrench();
  now.true_load << gas.force_N + lift.force_N, gas.torque_Nm + lift.torque_Nm;
  return now;
}

Plateau mean_of_the_last_second(const std::vector<Plateau>& frames) {
  const std::size_t count = std::min(frames.size(), kSecond_frames);
  Plateau mean = frames.back();
  for (std::size_t i = frames.size() - count; i + 1 < frames.size(); ++i) {
    mean.load += frames[i].load, mean.true_load += frames[i].true_load;
    mean.rpm += frames[i].rpm, mean.true_rpm += frames[i].true_rpm;
  }
  const auto n = static_cast<double>(count);
  mean.load /= n, mean.true_load /= n, mean.rpm /= n, mean.true_rpm /= n;
  return mean;
}

// As `lss-cli script run`. False: the daemon did not take it to its end.
bool run(Chain& chain, const std::string& name) {
  std::ifstream file(std::string(LSS_CAMPAIGNS) + "/" + name);
  const auto steps =
      cli::talaris::parse_script(std::string(std::istreambuf_iterator<char>(file), {}), name);
  constexpr double kId = 7;
  chain.send(CommandKind::script_begin, {kId, static_cast<double>(steps.size())});
  for (std::size_t i = 0; i < steps.size(); ++i) {
    chain.run(0.2);
    const cli::talaris::ScriptStep& s = steps[i];
    chain.send(CommandKind::script_step, {kId, static_cast<double>(i), s.at_s,
                                          static_cast<double>(s.kind), s.which, s.value});
  }
  chain.run(0.2);
  chain.send(CommandKind::script_run, {kId});
  if (!chain.run_until(Mode::script, 1)) return false;
  chain.run(cli::talaris::duration_s(steps) + 1);
  return chain.mode() == Mode::manual;
}

}  // namespace

Series play(const char* script, unsigned seed) {
  sim::talaris::TalarisOptions world;
  world.plant.stand = sim::talaris::Stand::load;
  world.gas.thrust_N = 40;
  world.gas.droop = kDroop;
  world.fans.bend = kBend;
  Chain chain({.config = "valves", .world = sim::talaris::dispersed(world, seed), .seed = seed});
  if (!chain.start() || !chain.arm()) return {};

  Series series;
  Loads zero = Loads::Zero(), first = zero;
  std::vector<Plateau> frames;
  chain.after_frame = [&] {
    const Plateau now = look(chain);
    if (!frames.empty() && !same(now, frames.back())) {
      Plateau over = mean_of_the_last_second(frames);
      frames.clear();
      if (acts(over)) {
        over.load -= zero;
        series.all.push_back(over);
        const Loads off = over.load - over.true_load;
        series.off_N = std::max(series.off_N, off.head<3>().norm());
        series.off_Nm = std::max(series.off_Nm, off.tail<3>().norm());
        series.off_rpm = std::max(series.off_rpm, std::abs(over.rpm - over.true_rpm));
      } else {
        zero = over.load;
        if (series.all.empty()) first = zero;
        series.moved_N = std::max(series.moved_N, (zero - first).head<3>().norm());
      }
    }
    frames.push_back(now);
  };
  const bool ran = run(chain, script);
  chain.after_frame = {};
  return ran ? series : Series{};
}

double of_alone(const Series& series, int count) {
  std::array<double, kHopperValves> alone_N{};
  double sum = 0;
  int sets = 0;
  for (const Plateau& a : series.all) {
    if (std::popcount(a.valves) == 1)
      alone_N[static_cast<std::size_t>(std::countr_zero(a.valves))] = a.force_N();
    if (std::popcount(a.valves) != count) continue;
    double apart_N = 0;
    for (std::size_t i = 0; i < alone_N.size(); ++i) apart_N += (a.valves >> i & 1) * alone_N[i];
    sum += a.force_N() / apart_N;
    ++sets;
  }
  return sum / sets;
}

const Plateau& at(const Series& series, unsigned fans, double throttle) {
  const auto found = std::ranges::find_if(series.all, [&](const Plateau& a) {
    return a.fans == fans && std::abs(a.throttle - throttle) < 1e-6;
  });
  if (found == series.all.end()) throw std::runtime_error("no such throttle");
  return *found;
}

}  // namespace lss::talaris
