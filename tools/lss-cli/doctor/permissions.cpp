// Whether this user may run real-time threads and lock memory; the unit lssd@ has its own limits.

#include <fmt/format.h>
#include <linux/capability.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

namespace fs = std::filesystem;

// mlockall() with MCL_FUTURE needs a limit above the whole address space, not only above the used
// memory; that of lssd is 0.5 GB (2026-11).
constexpr std::int64_t kAddressSpace = std::int64_t{1} << 30;

constexpr const char* kUnit =
    "the unit lssd@ brings its own limits; started by hand, lssd gets no more";

std::int64_t priority_limit(const System& system) {
  const std::int64_t value = limit(system, "Max realtime priority").value_or(0);
  return value < 0 ? 99 : value;
}

bool may_ask(const System& system, int priority) {
  return has_capability(system, CAP_SYS_NICE) || priority_limit(system) >= priority;
}

// The file with the real-time budget of our control group; empty when there is none. cgroup version
// 1 only: version 2 has no such file and no budget.
fs::path budget_file(const System& system) {
  std::istringstream lines(read_text(system.proc / "self/cgroup").value_or(""));
  for (std::string line; std::getline(lines, line);) {  // "4:cpu,cpuacct:/user.slice"
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) continue;
    const std::string controllers = line.substr(first + 1, second - first - 1);
    if (("," + controllers + ",").find(",cpu,") == std::string::npos) continue;
    const fs::path group = line.substr(std::min(line.size(), second + 2));
    return system.sys / "fs/cgroup" / controllers / group / "cpu.rt_runtime_us";
  }
  return {};
}

}  // namespace

Finding check_fifo(const System& system, int priority) {
  Finding finding{.name = "sched_fifo"};
  const int error = system.ask_fifo(priority);
  if (error == 0) {
    finding.found = fmt::format("SCHED_FIFO {} was granted", priority);
    finding.meaning = "nothing in this session stops lssd from being real-time";
    return finding;
  }
  finding.found = fmt::format("SCHED_FIFO {} was refused: {}", priority, std::strerror(error));
  if (error == EPERM && !may_ask(system, priority)) {
    finding.result = Result::warning;
    finding.meaning = std::string("this user has no real-time permission; ") + kUnit;
    finding.remedy = "see rtprio_limit";
    return finding;
  }
  finding.result = Result::problem;
  const fs::path file = budget_file(system);
  const std::optional<std::int64_t> budget_us = read_number(file);
  if (budget_us) {
    finding.meaning = fmt::format(
        "it is permitted, so the kernel groups real-time threads (CONFIG_RT_GROUP_SCHED), and the "
        "control group of this session has a budget of {} us",
        *budget_us);
    finding.remedy = fmt::format(
        "echo 900000 > {}, its parents first, or for all groups: sysctl "
        "kernel.sched_rt_runtime_us=-1",
        file.string());
  } else {
    finding.meaning =
        "it is permitted, so most likely the kernel groups real-time threads "
        "(CONFIG_RT_GROUP_SCHED) and the control group has no budget; the unit will "
        "be refused, too";
    finding.remedy =
        "sysctl kernel.sched_rt_runtime_us=-1, or a kernel without CONFIG_RT_GROUP_SCHED";
  }
  return finding;
}

Finding check_rtprio(const System& system, int priority) {
  const std::int64_t granted = priority_limit(system);
  const bool capable = has_capability(system, CAP_SYS_NICE);
  Finding finding{.name = "rtprio_limit",
                  .found = capable ? "any real-time priority, by CAP_SYS_NICE"
                                   : fmt::format("real-time priority up to {}", granted),
                  .meaning = fmt::format("lssd wants up to {}", priority)};
  if (capable || granted >= priority) return finding;
  finding.result = Result::warning;
  finding.meaning += std::string("; ") + kUnit;
  finding.remedy = fmt::format(
      "start lssd by systemd, or put \"USER - rtprio {}\" into /etc/security/limits.d/lss.conf and "
      "log in again",
      priority);
  return finding;
}

Finding check_memlock(const System& system) {
  const std::int64_t bytes = limit(system, "Max locked memory").value_or(0);
  const bool capable = has_capability(system, CAP_IPC_LOCK);
  const std::string amount =
      capable     ? "without limit, by CAP_IPC_LOCK"
      : bytes < 0 ? "without limit"
                  : fmt::format("up to {:.0f} MB", static_cast<double>(bytes) / 1'048'576);
  Finding finding{.name = "memlock_limit",
                  .found = "locked memory " + amount,
                  .meaning = "lssd locks its memory, so that a page fault never delays a frame"};
  if (capable || bytes < 0 || bytes >= kAddressSpace) return finding;
  finding.result = Result::warning;
  finding.meaning += std::string("; ") + kUnit;
  finding.remedy =
      "start lssd by systemd, or put \"USER - memlock unlimited\" into "
      "/etc/security/limits.d/lss.conf and log in again";
  return finding;
}

}  // namespace lss::cli::doctor
