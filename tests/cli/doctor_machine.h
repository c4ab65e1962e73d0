#pragma once

// A machine in a folder of its own for the checks of lss-cli doctor: every file that they read, as
// a good OBC has them, to be spoilt one by one.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/temp_folder.h"
#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::test {

class Machine : public testing::Test {
 protected:
  Machine() {
    system.proc = root / "proc";
    system.sys = root / "sys";
    system.configurations = root / "etc";
    system.run_dir = root / "run";
    system.state_dir = root / "state";
    system.shm_dir = root / "shm";
    system.ask_fifo = [](int) { return 0; };
    system.clock_read_ns = [] { return 25.0; };
    system.clock_synchronised = [] { return true; };
    system.utc_offset_ns = [] { return std::int64_t{1'000'000'000'000}; };
    system.ask_can_socket = [] { return 0; };
    system.ask_can_link = [](const std::string&) {
      return doctor::CanLink{.kind = "can", .state = 0, .bitrate = 1'000'000, .restart_ms = 100};
    };
    system.space = [](const std::filesystem::path&) {
      return doctor::Space{.free_bytes = 1ULL << 32, .total_bytes = 1ULL << 33};
    };
    system.find_roudi = [] { return dds::RoudiIdentity{}; };
    write("proc/sys/kernel/osrelease", "6.1.0-18-rt-amd64\n");
    write("proc/sys/kernel/version", "#1 SMP PREEMPT_RT Debian 6.1.76-1\n");
    write("sys/kernel/realtime", "1\n");
    write("proc/sys/kernel/sched_rt_runtime_us", "950000\n");
    write("proc/sys/kernel/sched_rt_period_us", "1000000\n");
    limits("unlimited", "95");
    write("proc/self/status",
          "Name:\tlss-cli\nCapEff:\t0000000000000000\nCapBnd:\t000001ffffffffff\n");
    write("proc/self/cgroup", "3:cpuset:/\n1:cpu,cpuacct:/user.slice\n0::/\n");
    write("proc/cpuinfo", "flags\t\t: fpu vme hypervisor\n");
    write("proc/swaps", "Filename\tType\tSize\tUsed\tPriority\n");
    write("proc/sys/net/core/rmem_max", "4194304\n");
    write("sys/devices/system/cpu/online", "0-3\n");
    write("sys/devices/system/cpu/isolated", "2-3\n");
    write("sys/devices/system/cpu/smt/active", "0\n");
    for (const char* cpu : {"cpu0", "cpu1"})
      write(std::string("sys/devices/system/cpu/") + cpu + "/cpufreq/scaling_governor",
            "performance\n");
    write(kClock + "current_clocksource", "tsc\n");
    write(kClock + "available_clocksource", "tsc hpet acpi_pm \n");
    interface("lo", "0x49", 772);
    for (const char* folder : {"etc", "run", "state", "shm"})
      std::filesystem::create_directories(root / folder);
  }

  void write(const std::string& file, const std::string& text) {
    std::filesystem::create_directories((root / file).parent_path());
    std::ofstream(root / file) << text;
  }
  void limits(const std::string& memory, const std::string& priority) {
    write("proc/self/limits",
          "Limit                     Soft Limit           Hard Limit           Units     \n"
          "Max locked memory         " +
              memory +
              "              8388608              bytes     \n"
              "Max realtime priority     " +
              priority + "                    0                    \n");
  }
  void interface(const std::string& name, const std::string& flags, int type) {
    write("sys/class/net/" + name + "/flags", flags + "\n");
    write("sys/class/net/" + name + "/type", std::to_string(type) + "\n");
  }
  // A process that has `file` open.
  void process(int pid, const std::string& name, const std::filesystem::path& file = "/dev/null") {
    const std::string folder = "proc/" + std::to_string(pid);
    write(folder + "/comm", name + "\n");
    std::filesystem::create_directories(root / folder / "fd");
    std::filesystem::create_symlink("/dev/null", root / folder / "fd/0");
    std::filesystem::create_symlink(file, root / folder / "fd/12");
  }

  inline static const std::string kClock = "sys/devices/system/clocksource/clocksource0/";

  testing_support::TempFolder root;
  doctor::System system;
  config::Config config;
};

inline void expect(const doctor::Finding& finding, doctor::Result result, const std::string& found,
                   const std::string& remedy = "") {
  EXPECT_EQ(finding.result, result) << finding.name << ": " << finding.found;
  EXPECT_NE(finding.found.find(found), std::string::npos) << finding.found;
  EXPECT_FALSE(finding.meaning.empty()) << finding.name;
  EXPECT_NE(finding.remedy.find(remedy), std::string::npos) << finding.remedy;
  // A good finding has no remedy; any other must have one.
  EXPECT_FALSE(result == doctor::Result::good && !finding.remedy.empty()) << finding.remedy;
  EXPECT_FALSE(result > doctor::Result::note && finding.remedy.empty()) << finding.name;
}

}  // namespace lss::cli::test
