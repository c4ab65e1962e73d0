// Row xvi: many vehicles on one domain, each the shipped daemon in a process of its own: how long a
// client takes to have the status of all, what each sends while nothing happens, and the memory of
// `lss-cli fleet`.

#include "tests/bench/fleet.h"

#include <fmt/format.h>

#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/programs.h"

namespace lss::bench {
namespace {

constexpr double kDiscovery_s = 10, kTraffic_kB_s = 1;  // at most

// Bytes over loopback since the machine started, of everybody.
double loopback_bytes() {
  std::istringstream lines(read_file("/proc/net/dev"));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find("lo:");
    if (at != std::string::npos) return std::stod(line.substr(at + 3));
  }
  throw NotHere("/proc/net/dev does not have the interface lo");
}

// A figure without a reference.
Figure plain(const std::string& name, const std::string& unit, double value, double goal,
             const std::string& note) {
  return {.row = "xvi",
          .name = name,
          .unit = unit,
          .value = value,
          .goal = goal,
          .absolute = true,
          .note = note};
}

void measure(const Options& options, std::size_t vehicles, int domain, Figures& figures) {
  std::vector<std::unique_ptr<Daemon>> fleet;
  while (fleet.size() < vehicles)
    fleet.push_back(std::make_unique<Daemon>(domain, false, std::filesystem::path(),
                                             fmt::format("zebro-{}", fleet.size() + 1)));
  const std::string of = fmt::format("{} vehicle{}, ", vehicles, vehicles == 1 ? "" : "s");

  Samples discovery_s;
  for (int i = 0; i < options.count(kRounds, 1); ++i)
    discovery_s.push_back(StatusReader(domain).all_heard_s(vehicles));
  figures.push_back(plain(of + "status of all at a new client, largest", "s",
                          quantile(discovery_s, 1), kDiscovery_s,
                          fmt::format("of {}", discovery_s.size())));

  StatusReader client(domain);
  client.all_heard_s(vehicles);
  const double before = loopback_bytes();
  const TimeNs began_ns = now_ns();
  // A multiple of the periods of status (StatusPace) and of DDS' own messages, 8 s.
  std::this_thread::sleep_for(std::chrono::seconds(options.count(40, 1)));
  const double elapsed_s = static_cast<double>(now_ns() - began_ns) * 1e-9;
  figures.push_back(
      plain(of + "traffic of each, idle", "kB/s",
            (loopback_bytes() - before) / elapsed_s / static_cast<double>(vehicles) * 1e-3,
            kTraffic_kB_s, fmt::format("{:.0f} s, with a client that reads status", elapsed_s)));

  Folder folder;
  Process listing({program("lss-cli"), "--timeout", "60s", "--json", "--domain",
                   std::to_string(domain), "fleet"},
                  folder / "fleet.json");
  const int code = listing.wait(kFleetLimit);
  const auto answer = nlohmann::json::parse(read_file(folder / "fleet.json"), nullptr, false);
  const std::size_t listed =
      code == 0 && answer.contains("vehicles") ? answer["vehicles"].size() : 0;
  if (listed != vehicles)
    throw std::runtime_error(fmt::format("lss-cli fleet lists {} of {} vehicles: {}", listed,
                                         vehicles, read_file(folder / "fleet.json")));
  figures.push_back(plain(of + "memory of lss-cli fleet, largest", "MB", listing.peak_mb(), kNone,
                          fmt::format("lists all {}", vehicles)));
}

}  // namespace

Figures fleet(const Options& options) {
  Figures figures;
  int index = 0;
  for (const std::size_t vehicles :
       options.quick ? std::vector<std::size_t>{1, 3} : std::vector<std::size_t>{1, 10, 30, 100}) {
    try {
      measure(options, vehicles, domain(index++), figures);
    } catch (const NotHere&) {
      throw;
    } catch (const std::exception& why) {  // no reason to lose the others
      fmt::print(stderr, "row xvi failed: {}\n", why.what());
      figures.push_back(not_measured("xvi", fmt::format("{} vehicles", vehicles), why.what()));
      figures.back().failed = true;
    }
  }
  return figures;
}

}  // namespace lss::bench
