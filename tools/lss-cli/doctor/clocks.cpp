// The clocks. lssd runs on CLOCK_MONOTONIC; UTC is for people.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

constexpr std::array kFast = {"tsc", "kvm-clock", "arch_sys_counter", "hyperv_clocksource_tsc_page",
                              "riscv_clocksource"};
constexpr std::array kSlow = {"hpet", "acpi_pm", "pit", "jiffies", "refined-jiffies"};

constexpr double kGoodRead_ns = 200, kSlowRead_ns = 1000;  // by the vDSO 20 to 60 ns (2026-11)
constexpr double kStep_s = 0.001;  // reading two clocks one after the other takes less

constexpr const char* kStepMeans =
    "lssd runs on the monotonic clock; a step makes the UTC stamps of status and events jump, and "
    "after a step back a --source that was used before is refused as stale until the clock has "
    "caught up";

}  // namespace

Finding check_clock_source(const System& system) {
  const auto folder = system.sys / "devices/system/clocksource/clocksource0";
  const std::string current = read_text(folder / "current_clocksource").value_or("unknown");
  const std::string all = read_text(folder / "available_clocksource").value_or("?");
  Finding finding{.name = "clock_source",
                  .found = fmt::format("{} (there are: {})", current, all),
                  .meaning = "reading the time is cheap"};
  if (std::ranges::count(kFast, current) > 0) return finding;
  finding.result = Result::note;
  finding.meaning = "not known to this program: clock_read says how fast it is";
  if (std::ranges::count(kSlow, current) == 0) return finding;
  finding.result = Result::warning;
  finding.meaning = "slow and coarse: each look at the time costs a microsecond or more";
  finding.remedy = fmt::format(
      "dmesg | grep -i clocksource says why; echo tsc > {} when it is offered, or tsc=reliable for "
      "the kernel",
      (folder / "current_clocksource").string());
  return finding;
}

Finding check_clock_read(const System& system) {
  const double ns = system.clock_read_ns();
  Finding finding{.name = "clock_read",
                  .found = fmt::format("one clock_gettime takes {:.0f} ns", ns),
                  .meaning = "without a system call"};
  if (ns < kGoodRead_ns) return finding;
  finding.result = ns < kSlowRead_ns ? Result::note : Result::warning;
  finding.meaning = "by a system call: every time stamp costs that much";
  finding.remedy = "see clock_source";
  return finding;
}

Finding check_clock_steps(const System& system, std::int64_t offset_before_ns) {
  const double step_s = static_cast<double>(system.utc_offset_ns() - offset_before_ns) * 1e-9;
  const bool synchronised = system.clock_synchronised();
  Finding finding{.name = "clock_steps",
                  .found = synchronised ? "UTC is synchronised" : "UTC is not synchronised",
                  .meaning = kStepMeans};
  if (std::abs(step_s) > kStep_s) {
    finding.result = Result::note;
    finding.found += fmt::format("; it stepped by {:+.3f} s just now", step_s);
    finding.remedy = "let one program keep the clock, by slewing: chrony without makestep";
  } else if (!synchronised) {
    finding.result = Result::note;
    finding.remedy = "for UTC stamps that can be trusted: chrony, or systemd-timesyncd";
  }
  return finding;
}

}  // namespace lss::cli::doctor
