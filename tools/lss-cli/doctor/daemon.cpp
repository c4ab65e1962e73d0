// The daemon itself, if one runs: queried over DDS, as by every other verb.

#include <fmt/format.h>

#include <algorithm>
#include <optional>

#include "tools/lss-cli/doctor/checks.h"
#include "tools/lss-cli/session/link.h"
#include "tools/lss-cli/session/status.h"

namespace lss::cli::doctor {

Finding judge_contract(const lss_Status& status) {
  Finding finding{.name = "daemon_contract",
                  .found = fmt::format("policy {}, {}; memory {}; {} page faults and {} mallocs of "
                                       "real-time threads since start",
                                       status.realtime_enforced ? "enforce" : "degrade",
                                       status.realtime_granted ? "all granted" : "not all granted",
                                       status.memory_locked ? "locked" : "not locked",
                                       status.page_faults_since_start, status.mallocs_since_start),
                  .meaning = "it runs in real time"};
  if (!status.realtime_granted || !status.memory_locked) {
    finding.result = Result::warning;
    finding.meaning = "it runs, but nothing guarantees that its frames are in time";
    finding.remedy =
        "start it by systemd (lssd@NAME), or correct rtprio_limit and memlock_limit and "
        "start it again";
  } else if (status.page_faults_since_start > 0 || status.mallocs_since_start > 0) {
    finding.result = Result::warning;
    finding.meaning =
        "its real-time threads should never allocate or fault: each may delay a frame";
    finding.remedy = "lss-cli status says which thread; report it with the journal";
  }
  return finding;
}

Finding judge_parameters(const lss_Status& status) {
  const std::string wrong = saved_trouble(status.saved_parameters);
  Finding finding{.name = "daemon_parameters",
                  .found = fmt::format("saved: {}", saved_name(status.saved_parameters)),
                  .meaning = "what was saved is in force"};
  if (status.saved_parameters == lss_SAVED_NONE)
    finding.meaning = "parameters are those of the configuration";
  if (wrong.empty()) return finding;
  finding.result = Result::warning;
  finding.meaning = wrong;
  finding.remedy = "lss-cli events names it; lss-cli param save writes both copies again";
  return finding;
}

Finding judge_names(const std::vector<lss_Status>& daemons) {
  Finding finding{
      .name = "daemon_names", .found = "", .meaning = "each has a vehicle_id of its own"};
  for (const lss_Status& daemon : daemons) {
    finding.found += fmt::format("{}{} ({})", finding.found.empty() ? "" : "; ",
                                 text(daemon.vehicle_id), instance_text(daemon.instance));
    const auto is_namesake = [&](const lss_Status& other) {
      return text(other.vehicle_id) == text(daemon.vehicle_id);
    };
    if (std::ranges::count_if(daemons, is_namesake) == 1) continue;
    finding.result = Result::problem;
    finding.meaning = fmt::format("several daemons are {}: each obeys what is meant for the other",
                                  text(daemon.vehicle_id));
    finding.remedy = "stop one of them, or give it another vehicle_id in its configuration";
  }
  return finding;
}

namespace {

Finding check_names(Link& link) {
  link.listen();
  std::vector<lss_Status> heard;
  for (const auto& [guid, daemon] : link.daemons().all()) {
    if (daemon.heard) heard.push_back(daemon.status);
  }
  return judge_names(heard);
}

}  // namespace

Findings daemon_findings(const System& system, const Options& options) {
  Finding finding{.name = "daemon"};
  std::optional<Link> link;
  try {
    link.emplace(options);
    link->find_vehicle();
    const lss_Status& status = link->status();
    finding.found = fmt::format("{} ({}, lssd {}) answers on DDS domain {}: {}",
                                text(status.vehicle_id), text(status.vehicle), text(status.version),
                                options.domain, cli::state_name(status.state));
    finding.meaning = "commands reach it";
    if (status.fault_count > 0 || status.state == lss_STATE_FATAL_ERROR) {
      finding.result = Result::note;
      finding.meaning = fmt::format("it has {} faults", status.fault_count);
      finding.remedy = "lss-cli status";
    }
    return {finding, check_names(*link), judge_contract(status), judge_parameters(status)};
  } catch (const Failure& failure) {
    finding.found = failure.what();
    finding.remedy = failure.advice();
    switch (failure.code()) {
      case ExitCode::unreachable:
        finding.result = Result::note;
        finding.meaning = "no lssd runs";
        if (const auto running = processes_named(system, "lssd"); !running.empty()) {
          finding.result = Result::warning;
          finding.meaning = fmt::format("{} runs, on another domain or interface", spoken(running));
        }
        break;
      case ExitCode::unknown_name:
      case ExitCode::usage:
        finding.result = Result::note;
        finding.meaning = "DDS works, but which vehicle is meant is not clear";
        return {finding, check_names(*link)};
      default: finding.result = Result::problem; finding.meaning = "DDS does not work here";
    }
  }
  return {finding};
}

}  // namespace lss::cli::doctor
