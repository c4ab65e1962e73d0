// The kernel, and the CPU time that it allows real-time threads.

#include <fmt/format.h>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

constexpr double kLowShare = 0.5;  // lssd needs a few percent, but at once

}  // namespace

Finding check_kernel(const System& system) {
  const std::string release = read_text(system.proc / "sys/kernel/osrelease").value_or("?");
  const std::string version = read_text(system.proc / "sys/kernel/version").value_or("");
  // Its patches have used both spellings.
  const bool realtime = read_number(system.sys / "kernel/realtime") == 1 ||
                        version.find("PREEMPT_RT") != std::string::npos ||
                        version.find("PREEMPT RT") != std::string::npos;
  if (realtime) {
    return {.name = "kernel",
            .found = fmt::format("Linux {}, PREEMPT_RT", release),
            .meaning = "threads of lssd wake up within microseconds, independent of drivers"};
  }
  return {.name = "kernel",
          .result = Result::warning,
          .found = fmt::format("Linux {} without PREEMPT_RT ({})", release, version),
          .meaning =
              "threads of lssd mostly wake up in time, but nothing bounds the latest: drivers "
              "may occupy a CPU for milliseconds",
          .remedy = "apt-get install linux-image-rt-amd64 (or linux-image-rt-arm64), then reboot"};
}

Finding check_throttle(const System& system) {
  Finding finding{.name = "rt_throttle"};
  const auto runtime_us = read_number(system.proc / "sys/kernel/sched_rt_runtime_us");
  const auto period_us = read_number(system.proc / "sys/kernel/sched_rt_period_us");
  if (!runtime_us || !period_us || *period_us <= 0) {
    finding.result = Result::note;
    finding.found = "the kernel does not report sched_rt_runtime_us";
    finding.meaning = "whether real-time threads are throttled is unknown";
    return finding;
  }
  finding.found = fmt::format("sched_rt_runtime_us {} of {}", *runtime_us, *period_us);
  if (*runtime_us < 0 || *runtime_us >= *period_us) {
    finding.result = Result::note;
    finding.meaning =
        "no throttle: a real-time thread that never sleeps keeps its CPU for good; lssd's own "
        "sleep";
    return finding;
  }
  const double share = static_cast<double>(*runtime_us) / static_cast<double>(*period_us);
  finding.meaning = fmt::format(
      "real-time threads together get {:.0f} % of each {:.0f} ms, then they stand still for the "
      "rest; lssd needs a few percent",
      100 * share, static_cast<double>(*period_us) / 1000);
  if (share >= kLowShare) return finding;
  finding.result = share > 0 ? Result::warning : Result::problem;
  if (share <= 0) finding.meaning = "there is no time for real-time threads at all";
  finding.remedy = "sysctl kernel.sched_rt_runtime_us=950000 kernel.sched_rt_period_us=1000000";
  return finding;
}

}  // namespace lss::cli::doctor
