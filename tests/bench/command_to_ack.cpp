// Row iii: a command from a client to its acknowledgement by the daemon, against an echo in plain C
// on the same topics with the same client, and against ddsperf; and a whole call of lss-cli against
// the least client in C (of estop: estop_call.cpp). Over loopback UDP, as the control plane always
// goes.

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>

#include "idl/commands.h"
#include "tests/bench/clients.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

// The median round trip as ddsperf says it, which is half of it.
Samples ddsperf_us(int domain) {
  Folder folder;
  const std::string id = std::to_string(domain);
  std::optional<Process> pong;
  {
    const OnCpu servers(measured_cpu());
    pong.emplace(std::vector<std::string>{"ddsperf", "-i", id, "pong"}, folder / "pong.log",
                 Process::Environment{loopback()});
  }
  Process ping({"ddsperf", "-i", id, "-D", "2.5", "ping", "size", "200"}, folder / "ping.log",
               {loopback()});
  ping.wait();
  const std::string said = read_file(folder / "ping.log");
  const std::size_t at = said.rfind(" 50% ");
  if (at == std::string::npos) throw NotHere("ddsperf does not measure round trips here");
  return {2 * std::strtod(said.c_str() + at + 5, nullptr)};
}

}  // namespace

Figures command_to_ack(const Options& options) {
  const int daemon_domain = domain(0), echo_domain = domain(1);
  Folder folder;
  std::optional<Daemon> daemon;
  std::optional<Process> echo;
  // Servers on one CPU, clients on the other: else a round trip is three times shorter whenever the
  // scheduler puts both onto one.
  {
    const OnCpu servers(measured_cpu());
    daemon.emplace(daemon_domain, false);
    echo.emplace(std::vector<std::string>{program("bench-dds-echo"), std::to_string(echo_domain)},
                 folder / "echo.log", Process::Environment{loopback()});
  }
  const OnCpu clients(kHardwareCpu);
  Pinger to_daemon(daemon_domain), to_echo(echo_domain);

  const int pings = options.count(2000, 200);
  const Rounds rounds = turn_by_turn([&] { return to_daemon.times_us(pings); },
                                     [&] { return to_echo.times_us(pings); });
  Figures figures{figure("iii", "command to acknowledgement, p50", "us", rounds, median, 1.25),
                  figure("iii", "command to acknowledgement, p99", "us", rounds, p99, kNone)};

  if (options.quick) {
    figures.push_back(not_measured("iii", "command to acknowledgement against ddsperf",
                                   "left out by --quick, ddsperf speaks once a second"));
  } else {
    const Rounds against = turn_by_turn([&] { return Samples{median(to_daemon.times_us(pings))}; },
                                        [&] { return ddsperf_us(domain(2)); });
    figures.push_back(
        noted(figure("iii", "command to acknowledgement against ddsperf", "us", against, median, 1),
              "medians; ddsperf with 200 bytes"));
  }

  const int calls = options.count(4, 1);
  const std::string id = std::to_string(daemon_domain);
  const std::vector<std::string> client{program("bench-dds-client"), id, "zebro-1",
                                        std::to_string(static_cast<int>(CommandKind::stop)),
                                        std::to_string(kFlagDryRun)};
  const Rounds whole = turn_by_turn(
      [&] {
        return call_ms(stop_dry_run(daemon_domain), {"LSS_SOURCE", "lss-bench-cli"}, calls);
      },
      [&] { return call_ms(client, loopback(), calls); });
  figures.push_back(
      held_back(noted(figure("iii", "whole call of lss-cli, p50", "ms", whole, median, 1.5),
                      "stop --dry-run --vehicle; reference: the same by the client in C"),
                "waits for the vehicle's status, and for the match of its two writers"));
  try {
    std::ranges::move(estop_call(options), std::back_inserter(figures));
  } catch (const NotHere& why) {
    figures.push_back(not_measured("iii", "lss-cli estop", why.what()));
  } catch (const std::exception& why) {  // no reason to lose the others
    fmt::print(stderr, "row iii failed: {}\n", why.what());
    figures.push_back(not_measured("iii", "lss-cli estop", why.what()));
    figures.back().failed = true;
  }
  return figures;
}

}  // namespace lss::bench
