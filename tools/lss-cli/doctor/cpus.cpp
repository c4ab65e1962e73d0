// CPUs: their number, which ones the configured threads need, and what slows them down.

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <sstream>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

std::filesystem::path cpu_folder(const System& system) { return system.sys / "devices/system/cpu"; }

std::vector<int> online(const System& system) {
  return parse_cpus(read_text(cpu_folder(system) / "online").value_or(""));
}

bool contains(const std::vector<int>& cpus, int cpu) { return std::ranges::count(cpus, cpu) > 0; }

bool is_virtual(const System& system) {
  return read_text(system.proc / "cpuinfo").value_or("").find("hypervisor") != std::string::npos;
}

// "frame on 1, actuate on 2"; the threads that need a CPU of their own.
std::string placed(const config::Config& config) {
  std::string list;
  for (const config::Thread& thread : config.threads) {
    if (thread.cpu < 0) continue;
    list += fmt::format("{}{} on {}", list.empty() ? "" : ", ", thread.name, thread.cpu);
  }
  return list;
}

}  // namespace

Finding check_governor(const System& system) {
  std::map<std::string, std::vector<std::string>> cpus_of;
  for (const std::string& name : names_in(cpu_folder(system))) {
    const auto governor = read_text(cpu_folder(system) / name / "cpufreq/scaling_governor");
    if (governor) cpus_of[*governor].push_back(name);
  }
  Finding finding{.name = "cpu_governor"};
  if (cpus_of.empty()) {
    finding.found = "no frequency scaling";
    finding.meaning = is_virtual(system) ? "usual in a virtual machine: its host decides"
                                         : "the CPUs always run at their own speed";
    return finding;
  }
  for (const auto& [governor, cpus] : cpus_of) {
    finding.found +=
        fmt::format("{}{}: {}", finding.found.empty() ? "" : "; ", governor, fmt::join(cpus, " "));
  }
  finding.meaning = "the CPUs stay at full speed";
  if (cpus_of.size() == 1 && cpus_of.contains("performance")) return finding;
  finding.result = Result::warning;
  finding.meaning = "CPUs slow down between frames, and a frame then begins on a slow one";
  finding.remedy = "cpupower frequency-set -g performance (package linux-cpupower), at every boot";
  return finding;
}

Finding check_cpus(const System& system) {
  const std::vector<int> cpus = online(system);
  Finding finding{.name = "cpus",
                  .found = fmt::format("{} online ({})", cpus.size(),
                                       read_text(cpu_folder(system) / "online").value_or("?")),
                  .meaning = "frames and everything else can run at the same time"};
  if (cpus.size() != 1) return finding;
  finding.result = Result::note;
  finding.meaning = "lssd shares its only CPU with everything else, and goes first";
  return finding;
}

Finding check_thread_cpus(const System& system, const config::Config& config) {
  const std::string wanted = placed(config);
  Finding finding{.name = "thread_cpus",
                  .found = wanted.empty() ? "any CPU for each thread" : wanted,
                  .meaning = "all of them are there"};
  const std::vector<int> there = online(system);
  std::string missing;
  for (const config::Thread& thread : config.threads) {
    if (thread.cpu < 0 || contains(there, thread.cpu)) continue;
    missing += fmt::format("{}CPU {} of {}", missing.empty() ? "" : ", ", thread.cpu, thread.name);
  }
  if (missing.empty()) return finding;
  finding.result = Result::problem;
  finding.meaning = fmt::format(
      "this machine has no {}: with realtime.policy = \"enforce\" lssd "
      "does not start, else the thread runs anywhere",
      missing);
  finding.remedy = fmt::format("set cpu in [[realtime.thread]] to one of {}, or to -1 for any",
                               read_text(cpu_folder(system) / "online").value_or("?"));
  return finding;
}

Finding check_isolation(const System& system, const config::Config* config) {
  const std::string text = read_text(cpu_folder(system) / "isolated").value_or("");
  const std::vector<int> isolated = parse_cpus(text);
  Finding finding{
      .name = "cpu_isolation",
      .result = Result::note,
      .found = isolated.empty() ? "none isolated" : "isolated: " + text,
      .meaning = "everything may run everywhere; CPUs of its own make lssd more punctual"};
  std::vector<int> named;
  if (config != nullptr) {
    const std::vector<int> there = online(system);
    for (const config::Thread& thread : config->threads) {
      if (contains(there, thread.cpu) && !contains(named, thread.cpu)) named.push_back(thread.cpu);
    }
  }
  const auto is_isolated = [&](int cpu) { return contains(isolated, cpu); };
  if (!named.empty() && std::ranges::all_of(named, is_isolated)) {
    finding.result = Result::good;
    finding.meaning = "nothing but lssd runs on the CPUs of its threads";
  } else if (!named.empty()) {
    finding.meaning = "other programs run on the CPUs of lssd's threads, too";
    finding.remedy =
        fmt::format("add isolcpus={} to the kernel's command line", fmt::join(named, ","));
  } else if (!isolated.empty() && config != nullptr) {
    finding.meaning = "no thread of lssd asks for them, so that they stand idle";
    finding.remedy = fmt::format("name one of {} as cpu in [[realtime.thread]]", text);
  }
  return finding;
}

Finding check_smt(const System& system) {
  Finding finding{.name = "smt", .found = "off", .meaning = "no CPU shares its core with another"};
  if (read_number(cpu_folder(system) / "smt/active") != 1) return finding;
  finding.result = Result::note;
  finding.found = "on";
  finding.meaning = "what runs on the other half of a core slows a frame down, even on its own CPU";
  finding.remedy = "echo off > /sys/devices/system/cpu/smt/control, or nosmt for the kernel";
  return finding;
}

Finding check_swap(const System& system) {
  std::istringstream lines(read_text(system.proc / "swaps").value_or(""));
  std::string line;
  std::getline(lines, line);  // the heading
  double size_kB = 0, used_kB = 0;
  while (std::getline(lines, line)) {
    std::istringstream columns(line);
    std::string file, type;
    double size = 0, used = 0;
    columns >> file >> type >> size >> used;
    size_kB += size;
    used_kB += used;
  }
  Finding finding{.name = "swap",
                  .found = size_kB > 0 ? fmt::format("{:.0f} of {:.0f} MB in use", used_kB / 1024,
                                                     size_kB / 1024)
                                       : "none",
                  .meaning = "nothing waits for a disk to get its memory back"};
  if (used_kB <= 0) return finding;
  finding.result = Result::note;
  finding.meaning = "lssd locks its memory and is not touched; RouDi and clients may stall";
  finding.remedy = "swapoff -a, when the memory is large enough";
  return finding;
}

}  // namespace lss::cli::doctor
