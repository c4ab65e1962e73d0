#include "tests/bench/lockstep.h"

#include <fmt/format.h>

#include <csignal>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/programs.h"

namespace lss::bench {

namespace {

constexpr double kAt_s = 2;  // when the client comes in

// When the log of lss-cli --jsonl says that the motion is executed, or has ended.
TimeNs when(bool ended, const Moving& moving, const std::filesystem::path& log, Process& client) {
  const std::string motion = moving.motion;
  const std::string command = "{\"command\":\"" + motion.substr(0, motion.find(' ')) + "\",";
  const TimeNs until_ns = now_ns() + 300 * kSecond;
  for (bool last = false;;) {
    std::istringstream lines(read_file(log));
    for (std::string line; std::getline(lines, line);) {
      const auto phase = [&](const char* name) {
        return line.find(fmt::format("\"phase\":\"{}\"", name)) != std::string::npos;
      };
      if (line.starts_with(command) &&
          (ended ? !phase("accepted") && !phase("executing") : phase("executing")))
        return now_ns();
    }
    if (last || now_ns() > until_ns) {
      throw std::runtime_error(
          fmt::format("{} in lockstep: lss-cli does not say that its motion {}: {}", moving.vehicle,
                      ended ? "ended" : "began", read_file(log)));
    }
    last = !client.running();
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

}  // namespace

double lockstep_ms(const Moving& moving, const std::string& plant, int seconds,
                   const std::filesystem::path& recording) {
  Folder folder;
  const std::filesystem::path run = folder / "run", log = folder / "lss-sim.log";
  const std::string id = std::to_string(domain(0));
  const std::string can = "udp://127.0.0.1:" + std::to_string(20000 + domain(0));
  std::vector<std::string> words{
      program("lss-sim"), moving.vehicle, "--dir",       run,
      "--pace",           "--lockstep",   "--speed",     "max",
      "--plant",          plant,          "--client-at", fmt::format("{}", kAt_s)};
  std::string config = edited(shipped_config(moving.vehicle), "shared_memory", "false");
  if (moving.vehicle != std::string("zebro")) {
    words.insert(words.end(), {"--can", can});
    const std::string shipped = "udp://127.0.0.1:20000";
    config.replace(config.find(shipped), shipped.size(), can);
  }
  if (!recording.empty()) {
    const std::size_t recorder = config.find("[recorder]");
    config = config.substr(0, recorder) +
             edited(edited(config.substr(recorder), "file_mb", "200"), "total_mb", "400");
  }
  std::ofstream(folder / "config.toml") << config;
  Process simulator(words, log);
  if (!eventually([&] { return simulator.said("ready"); }))
    throw NotHere("lss-sim does not start here");
  std::optional<ReadySocket> ready(folder);
  Process daemon({program("lssd"), "--lockstep", "--config", folder / "config.toml", "--run-dir",
                  run, "--domain", id},
                 folder / "lssd.log", Process::Environment{loopback(), ready->variable()});
  ready->wait();
  ready.reset();  // nobody reads the daemon's later messages, and a full socket would hold it up
  const std::filesystem::path said = folder / "lss-cli.log";
  Process client(
      {program("lss-cli"), "--domain", id, "--jsonl", "run", "--lockstep", "--dir", run, "-e",
       fmt::format("{}; {} --for {}s; stop", moving.begin, moving.motion, seconds)},
      said, Process::Environment{loopback()});
  const TimeNs begun_ns = when(false, moving, said, client);
  const double ms = static_cast<double>(when(true, moving, said, client) - begun_ns) * 1e-6;
  if (const int code = client.wait(std::chrono::seconds(300)); code != 0)
    throw std::runtime_error(fmt::format("{} in lockstep: lss-cli ended with {}: {}",
                                         moving.vehicle, code, read_file(said)));
  if (recording.empty()) return ms;
  simulator.signal(SIGINT);  // in standing time nothing else would end
  simulator.wait();
  daemon.signal(SIGTERM);
  daemon.wait();
  std::vector<std::filesystem::path> files;
  for (const auto& file : std::filesystem::directory_iterator(run)) {
    if (file.path().extension() == ".lssrec") files.push_back(file);
  }
  if (files.size() != 1)
    throw std::runtime_error(
        fmt::format("lssd made {} recordings: {}", files.size(), read_file(folder / "lssd.log")));
  std::filesystem::copy_file(files.front(), recording);
  return ms;
}

}  // namespace lss::bench
