// lssd: the boot order. Configuration, vehicle, DDS, memory, real-time threads, READY; then signals
// and the watchdog until the end.

#include <signal.h>
#include <spdlog/async.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <thread>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "daemon/app/roster.h"
#include "daemon/config/config.h"
#include "daemon/record/build.h"
#include "daemon/replay/cycle_cost.h"
#include "daemon/replay/replay_files.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/program_check.h"
#include "daemon/runtime/service_manager.h"
#include "drivers/lockstep/wire.h"

namespace {

// For a simulator that was started in the same moment.
constexpr std::chrono::seconds kSimulatorStarts{5};
// When only time helps: the clock is late, or DDS finds no interface.
constexpr lss::TimeNs kStartAgain = 5 * lss::kSecond;
constexpr lss::TimeNs kStandstill = lss::kSecond;  // a thread without a turn for so long is stuck
constexpr std::size_t kLogLines = 1024;
constexpr int kExitFailure = 1;
constexpr int kExitConfig = 78;   // EX_CONFIG: another start will not help
constexpr int kExitRestart = 75;  // EX_TEMPFAIL: systemd starts us again (RestartForceExitStatus)

struct Options {
  std::filesystem::path config;
  std::filesystem::path run_dir = "/run/lss";
  int domain = -1;  // -1: from the configuration
  bool lockstep = false;
  std::vector<std::filesystem::path> replay;
  std::size_t cost = 0;  // so many frames of each are counted
};

// "sim:NAME" is a link in the run directory, made by lss-sim.
void resolve_ports(lss::config::Config& config, const std::filesystem::path& run_dir) {
  for (lss::config::Port& port : config.ports) {
    if (port.path.starts_with("sim:")) port.path = run_dir / port.path.substr(4);
  }
}

// True: the condition was met in time.
template <class Condition>
bool await_simulator(Condition&& condition) {
  const auto end = std::chrono::steady_clock::now() + kSimulatorStarts;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  return true;
}

// Joins simulated time, only if all ports belong to the simulator. The error says what to do.
tl::expected<void, std::string> follow_simulator(const lss::config::Config& config,
                                                 const std::filesystem::path& run_dir) {
  std::string error;
  if (!await_simulator([&] {
        error = lss::lockstep::join(run_dir.string(), "lssd");
        return error.empty();
      }))
    return tl::unexpected(error);
  for (const lss::config::Port& port : config.ports) {
    const std::filesystem::path path = port.path;
    const bool of_simulator = path.parent_path() == run_dir || port.path.starts_with("udp://");
    const std::string_view line = lss::lockstep::line_name(port.path);
    if (of_simulator && await_simulator([&] { return lss::lockstep::has_line(line); })) continue;
    return tl::unexpected("--lockstep: port " + port.name + " (" + port.path +
                          ") is no port of the simulator in " + run_dir.string() +
                          ": give it the simulator's sim:NAME or udp:// address, or start without "
                          "--lockstep");
  }
  return {};
}

// Signals are taken only by sigtimedwait in main: block them before any thread exists.
sigset_t block_signals() {
  sigset_t set;
  sigemptyset(&set);
  for (const int s : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, s);
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  ::signal(SIGPIPE, SIG_IGN);
  ::signal(SIGXFSZ, SIG_IGN);  // a file size limit is an error like a full disk
  return set;
}

// Reports threads that stand still: true when there was something to report.
bool tell_standstills(const std::vector<lss::ProgressWatch::Change>& changes) {
  for (const auto& change : changes) {
    const double still_s = static_cast<double>(change.still_ns) * 1e-9;
    if (!change.stuck) {
      spdlog::warn("thread {} runs again after {:.1f} s", change.thread, still_s);
    } else {
      spdlog::error("thread {} stands still for {:.1f} s: {}", change.thread, still_s,
                    lss::ProgressWatch::effect(change));
    }
  }
  return !changes.empty();
}

// Until a signal comes or the daemon wants to be restarted. Feeds the watchdog only while frames
// advance, and looks at a part of the program each time.
int supervise(lss::App& app, const sigset_t& signals) {
  const timespec tenth = lss::to_timespec(100 * lss::kMillisecond);
  lss::ProgressWatch watch(kStandstill);
  lss::ProgramCheck program;
  std::uint64_t frames = 0;
  std::string summary, stuck;
  bool ready = lss::tell_service_manager("READY=1");
  for (;;) {
    const int signal = ::sigtimedwait(&signals, nullptr, &tenth);
    if (signal > 0) {
      spdlog::info("{}: stopping", signal == SIGINT ? "interrupt" : "termination asked for");
      return 0;
    }
    if (const char* reason = app.restart_reason(); reason != nullptr) {
      spdlog::warn("{} and the vehicle does not move: the daemon ends, systemd starts it again",
                   reason);
      return kExitRestart;
    }
    if (!program.step()) {
      spdlog::critical("the program changed in memory, within {} bytes from {}: the vehicle stops",
                       program.last().size(), static_cast<const void*>(program.last().data()));
      app.program_damaged();
    }
    const std::vector<lss::Progress> progress = app.progress();
    if (progress.front().turns != frames) {
      frames = progress.front().turns;
      lss::tell_service_manager("WATCHDOG=1");
      if (!ready) ready = lss::tell_service_manager("READY=1");
    }
    const bool frame_stuck = watch.stuck(0);
    if (tell_standstills(watch.look(progress, lss::now_ns()))) {
      if (watch.stuck(0) && !frame_stuck) app.keep_frames();
      stuck.clear();
      for (std::size_t i = 0; i < progress.size(); ++i) {
        if (watch.stuck(i)) stuck += " " + progress[i].thread + " stands still!";
      }
    }
    if (const std::string text = app.summary() + stuck;
        text != summary && lss::tell_service_manager("STATUS=" + text))
      summary = text;
  }
}

int run(const Options& options, const sigset_t& signals) {
  lss::Maker make;
  auto config = lss::config::load(options.config, lss::vehicle_names(),
                                  [&](const std::string& vehicle, lss::config::Section& section) {
                                    make = lss::vehicle_port(vehicle).read(section);
                                  });
  if (!config) {
    spdlog::critical("the configuration has errors:\n{}", config.error());
    return kExitConfig;
  }
  if (options.domain >= 0) config->domain = options.domain;
  resolve_ports(*config, options.run_dir);
  if (options.lockstep) {
    if (auto ok = follow_simulator(*config, options.run_dir); !ok) {
      spdlog::critical("{}", ok.error());
      return kExitConfig;
    }
    // RouDi drops a process that stands still for longer than it can see in simulated time.
    config->shared_memory = false;
  }
  const char* state = std::getenv("STATE_DIRECTORY");  // systemd's
  const std::filesystem::path kept = state != nullptr && *state != '\0' ? state : options.run_dir;
  for (std::filesystem::path* folder : {&config->log_folder, &config->parameters_folder}) {
    if (folder->empty()) *folder = kept;
  }
  spdlog::set_level(static_cast<spdlog::level::level_enum>(config->log_level));

  const std::unique_ptr<lss::App> app = make(*config);
  if (const std::string wrong = app->wrong_configuration(); !wrong.empty()) {
    spdlog::critical("the configuration has errors:\n{}", wrong);
    return kExitConfig;
  }
  if (auto ok = app->start(); !ok) {
    spdlog::critical("{}", ok.error().text);
    if (ok.error().cure == lss::Cure::change) return kExitConfig;
    // systemd 252 has one RestartSec for all ends; a daemon that ended itself is held sooner.
    const timespec pause = lss::to_timespec(kStartAgain);
    const bool ended =
        ok.error().cure == lss::Cure::time && ::sigtimedwait(&signals, nullptr, &pause) > 0;
    return ended ? 0 : kExitFailure;
  }
  spdlog::info("lssd {} ready: {} ({}) on DDS domain {}", LSS_VERSION, config->vehicle_id,
               config->vehicle, config->domain);
  const int code = supervise(*app, signals);
  lss::tell_service_manager("STOPPING=1");
  app->stop();
  return code;
}

int count_costs(const Options& options) {
  for (const std::filesystem::path& path : options.replay) {
    const auto cost = lss::record::cycle_cost(path, options.cost);
    if (!cost) {
      std::fprintf(stderr, "%s\n", cost.error().c_str());
      return kExitFailure;
    }
    const nlohmann::ordered_json line = {{"file", path.string()},
                                         {"frames", cost->frames},
                                         {"counted", cost->counted},
                                         {"frame", cost->frame},
                                         {"instructions", cost->instructions},
                                         {"ns_per_instruction", cost->ns_per_instruction},
                                         {"longest_ns", cost->longest_ns},
                                         {"version", lss::record::program_version(LSS_VERSION)}};
    std::printf("%s\n", line.dump().c_str());
  }
  return 0;
}

// With the vehicles: there are programs of one vehicle alone.
std::string version_text() {
  std::string text = "lssd " LSS_VERSION;
  const char* before = " (";
  for (const std::string& name : lss::vehicle_names()) text += std::exchange(before, ", ") + name;
  return text + ")";
}

// Lines that cannot be written must not keep the daemon from ending.
void end_log(int code) {
  std::thread([code] {
    std::this_thread::sleep_for(std::chrono::seconds(1));
    ::_exit(code);
  }).detach();
  const auto log = spdlog::default_logger();  // destroyed after the thread that uses it has ended
  spdlog::shutdown();
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App cli("lssd: the Locomotion Sub-System of a small planetary vehicle");
  CLI::Option* config =
      cli.add_option("--config", options.config, "configuration file, e.g. /etc/lss/zebro.toml");
  cli.add_option("--run-dir", options.run_dir, "where links of simulated ports (sim:NAME) are")
      ->capture_default_str();
  cli.add_option("--domain", options.domain, "DDS domain; wins over the configuration")
      ->envname("LSS_DOMAIN")
      ->check(CLI::Range(0, 230));
  cli.add_flag("--lockstep", options.lockstep,
               "simulated time: follows lss-sim --lockstep in the run directory");
  cli.add_option(
         "--replay", options.replay,
         "moves nothing: executes recordings (*.lssrec) again and compares every bit of "
         "every output; 0: equal, 2: different, 3: damaged, 4: of another build or vehicle, "
         "5: frames that cannot be compared, 1: unreadable")
      ->type_name("FILE")
      ->excludes(config);
  cli.add_option(
         "--cost", options.cost,
         "with --replay: counts the instructions of that many of the longest frames of each "
         "file, a line of JSON for lss-cli timing certify")
      ->check(CLI::Range(1, 1'000'000))
      ->needs("--replay");
  cli.set_version_flag("--version", version_text());
  cli.footer(
      "Examples:\n  lssd --config config/zebro.toml --run-dir /tmp/lss --domain 7\n"
      "  lssd --replay /var/lib/lss/*.lssrec");
  try {
    cli.parse(argc, argv);
    if (options.config.empty() && options.replay.empty())
      throw CLI::RequiredError("--config FILE (or --replay FILE)");
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : kExitConfig;
  }
  if (options.cost != 0) return count_costs(options);
  if (!options.replay.empty()) {
    const auto print = [](const std::string& line) { std::fputs(line.c_str(), stdout); };
    return static_cast<int>(lss::record::replay_files(options.replay, print));
  }

  const sigset_t signals = block_signals();
  // In its own thread, which drops the oldest lines when they cannot be written.
  spdlog::init_thread_pool(kLogLines, 1);
  spdlog::set_default_logger(spdlog::create_async_nb<spdlog::sinks::stderr_color_sink_mt>("lssd"));
  // The journal adds its own time and level.
  spdlog::set_pattern(lss::tell_service_manager("STATUS=starting") ? "%v"
                                                                   : "%H:%M:%S.%e %^%-8l%$ %v");
  const int code = run(options, signals);
  end_log(code);
  return code;
}
