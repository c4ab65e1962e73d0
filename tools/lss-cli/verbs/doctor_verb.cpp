// doctor: can lssd run on this machine, in real time and as configured?

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <iterator>

#include "tools/lss-cli/doctor/checks.h"
#include "tools/lss-cli/doctor/read_config.h"
#include "tools/lss-cli/doctor/report.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

using namespace doctor;

constexpr int kHighestDefault = 85;  // of lssd's threads, when no configuration says otherwise

struct Asked {
  std::vector<std::string> files;  // none: those of System::configurations
  std::string run_dir;             // empty: systemd's, or lssd's default
  bool explain = false;
  bool domain_given = false;
};

void add(Findings& all, Findings more) { std::ranges::move(more, std::back_inserter(all)); }

Findings machine(const System& system, int priority) {
  return {check_kernel(system),         check_throttle(system),
          check_fifo(system, priority), check_rtprio(system, priority),
          check_memlock(system),        check_governor(system),
          check_cpus(system),           check_smt(system),
          check_swap(system),           check_clock_source(system),
          check_clock_read(system),     check_dds_uri(),
          check_buffers(system),        check_run_dir(system),
          check_state_dir(system)};
}

// Checks that depend on the configuration, or on its defaults without one.
Findings configured(const System& system, const config::Config* config) {
  Findings all;
  if (config != nullptr) {
    std::vector<std::string> ports;
    for (const config::Port& port : config->ports) ports.push_back(port.name);
    all.push_back({.name = "config",
                   .found = fmt::format("{}: {}, ports: {}", config->file, config->vehicle_id,
                                        fmt::join(ports, ", ")),
                   .meaning = "it is TOML; lssd says what else is wrong in it when it starts"});
    all.push_back(check_thread_cpus(system, *config));
  }
  all.push_back(check_isolation(system, config));
  if (config != nullptr) {
    for (const config::Port& port : config->ports) all.push_back(check_port(system, *config, port));
  }
  for (const std::string& name : (config != nullptr ? *config : config::Config()).interfaces)
    all.push_back(check_interface(system, name));
  all.push_back(check_roudi(system, config));
  all.push_back(check_shm(system, config));
  return all;
}

// The identity from the daemon's own options: the command line takes precedence over the
// configuration.
Options about_daemon(const Options& given, const Asked& asked, const config::Config* config) {
  Options options = given;
  if (config == nullptr) return options;
  if (!asked.domain_given) options.domain = config->domain;
  if (options.vehicle_id.empty()) options.vehicle_id = config->vehicle_id;
  return options;
}

// The requests of lssd. Threads that the file does not name have defaults.
int highest_priority(const std::vector<config::Config>& configs) {
  int highest = configs.empty() ? kHighestDefault : 0;
  for (const config::Config& config : configs) {
    const bool all_named =
        config.threads.size() >= 2 + config.ports.size();  // frame, actuate, buses
    if (!all_named) highest = std::max(highest, kHighestDefault);
    for (const config::Thread& thread : config.threads)
      highest = std::max(highest, std::min(thread.priority, 99));
  }
  return std::max(highest, 1);
}

std::size_t terminal_width() {
  winsize size{};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0) return Layout().width;
  return size.ws_col;
}

// The configuration, null when there is none, and its daemon.
Findings examine(Context& context, const Asked& asked, const System& system,
                 const config::Config* config) {
  Findings all = configured(system, config);
  const Options options = about_daemon(context.options, asked, config);
  context.output.progress(fmt::format("listening for lssd on DDS domain {}", options.domain));
  add(all, daemon_findings(system, options));
  context.output.end_progress();
  return all;
}

System this_machine(const Asked& asked) {
  System system;
  if (const char* given = std::getenv("RUNTIME_DIRECTORY"); given != nullptr && *given != '\0')
    system.run_dir = given;
  if (!asked.run_dir.empty()) system.run_dir = asked.run_dir;
  return system;
}

ExitCode run_doctor(Context& context, const Asked& asked) {
  const System system = this_machine(asked);
  const std::int64_t offset_before_ns = system.utc_offset_ns();
  std::vector<config::Config> configs;
  Findings broken;
  std::vector<std::filesystem::path> files(asked.files.begin(), asked.files.end());
  if (files.empty()) files = configurations(system);
  for (const std::filesystem::path& file : files) {
    if (auto config = read_config(file)) {
      configs.push_back(std::move(*config));
    } else {
      broken.push_back({.name = "config",
                        .result = Result::problem,
                        .found = config.error(),
                        .meaning = "lssd does not start with it",
                        .remedy = "correct it; lssd --config FILE then reports all other errors"});
    }
  }
  Findings all = machine(system, highest_priority(configs));
  add(all, std::move(broken));
  if (configs.empty()) add(all, examine(context, asked, system, nullptr));
  for (const config::Config& config : configs) {
    Findings own = examine(context, asked, system, &config);
    for (Finding& finding : own) {
      if (configs.size() > 1) finding.name = fmt::format("{} {}", config.vehicle_id, finding.name);
    }
    add(all, std::move(own));
  }
  all.push_back(check_clock_steps(system, offset_before_ns));

  context.output.document(report_json(all));
  context.output.print(report_text(all, context.output.style(),
                                   {.width = terminal_width(), .explain = asked.explain}));
  return has_problem(all) ? ExitCode::failed : ExitCode::completed;
}

}  // namespace

void add_doctor_verbs(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub =
      grammar.verb("doctor", "can lssd run here: checks of machine and configuration", R"(
  lss-cli doctor
  lss-cli doctor --config /etc/lss/zebro.toml
  lss-cli --json doctor | jq '.checks[] | select(.result != "good")'
)");
  auto asked = std::make_shared<Asked>();
  sub.add_option("--config", asked->files,
                 "configuration of lssd, once for each (default: those in /etc/lss)")
      ->allow_extra_args(false);
  sub.add_option("--run-dir", asked->run_dir,
                 "as of lssd: where ports of a simulated vehicle are (default /run/lss)");
  sub.add_flag("--explain", asked->explain, "also what the good ones mean");
  grammar.on(sub, [asked, &sub](Context& context) {
    asked->domain_given = sub.get_parent()->get_option("--domain")->count() > 0;
    return run_doctor(context, *asked);
  });
}

}  // namespace lss::cli
