// Row iii: `lss-cli estop` of a Lunar Zebro with its motors on, from exec to the first byte of the
// stop on the bus, against the least client in C that stops the same daemon.

#include <fmt/format.h>

#include "idl/commands.h"
#include "tests/bench/stop_rig.h"

namespace lss::bench {

Figures estop_call(const Options& options) {
  constexpr double kOfMinimal = 1.5, kMost_ms = 60;
  prepare_real_time();
  const Stoppable zebro = lunar_zebro();
  const int where = domain(3);  // those before it are in use
  StopDaemon daemon(zebro, where);
  const std::string id = std::to_string(where);
  const std::vector<std::string> ours{program("lss-cli"), "--domain", id,
                                      "--vehicle",        "zebro-1",  "estop"};
  const std::vector<std::string> least{
      program("bench-dds-client"), id, "zebro-1",
      std::to_string(static_cast<int>(CommandKind::emergency_stop)), "0"};
  const int count = options.count(6, 1);
  const Rounds rounds =
      turn_by_turn([&] { return daemon.calls_ms(ours, count); },
                   [&] { return daemon.calls_ms(least, count); }, options.count(kRounds, 1));
  Samples all;
  for (const Round& round : rounds) all.insert(all.end(), round.value.begin(), round.value.end());
  const std::string what = "lss-cli estop, exec to first stop byte, ";
  Figure slowest = at_most(figure("iii", what + "p99", "ms", rounds, p99, kNone), kMost_ms);
  slowest.value = p99(all);  // of all, not of a part
  return {noted(figure("iii", what + "p50", "ms", rounds, median, kOfMinimal),
                "zebro; reference: the client in C"),
          noted(slowest, fmt::format("of {} calls", all.size()))};
}

}  // namespace lss::bench
