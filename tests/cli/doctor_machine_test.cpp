// lss-cli doctor on the kernel, permissions, CPUs, clocks and folders: what is good, and each way
// it can be bad.

#include "tests/cli/doctor_machine.h"

#include <gmock/gmock.h>

#include <cerrno>

namespace lss::cli::test {
namespace {

using namespace doctor;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

using DoctorMachine = Machine;

TEST_F(DoctorMachine, KernelIsGoodWithPreemptRt) {
  expect(check_kernel(system), Result::good, "6.1.0-18-rt-amd64, PREEMPT_RT");
  std::filesystem::remove(root / "sys/kernel/realtime");  // the version still says it
  expect(check_kernel(system), Result::good, "PREEMPT_RT");
  write("proc/sys/kernel/version", "#1 SMP PREEMPT_DYNAMIC Debian 6.1.76-1\n");
  expect(check_kernel(system), Result::warning, "without PREEMPT_RT", "linux-image-rt");
  write("sys/kernel/realtime", "0\n");
  expect(check_kernel(system), Result::warning, "without PREEMPT_RT", "linux-image-rt");
}

TEST_F(DoctorMachine, ThrottleIsJudgedByTheShareThatItLeaves) {
  const Finding usual = check_throttle(system);
  expect(usual, Result::good, "950000 of 1000000");
  EXPECT_THAT(usual.meaning, HasSubstr("95 % of each 1000 ms"));
  const auto with = [&](const char* runtime_us) {
    write("proc/sys/kernel/sched_rt_runtime_us", runtime_us);
    return check_throttle(system);
  };
  expect(with("-1\n"), Result::note, "-1");
  expect(with("1000000\n"), Result::note, "1000000");
  expect(with("100000\n"), Result::warning, "100000", "sched_rt_runtime_us=950000");
  expect(with("0\n"), Result::problem, "0 of", "sched_rt_runtime_us=950000");
  std::filesystem::remove(root / "proc/sys/kernel/sched_rt_runtime_us");
  expect(check_throttle(system), Result::note, "does not report");
}

TEST_F(DoctorMachine, RefusedFifoIsTracedToItsReason) {
  expect(check_fifo(system, 85), Result::good, "SCHED_FIFO 85 was granted");

  system.ask_fifo = [](int) { return EPERM; };
  limits("unlimited", "0");
  expect(check_fifo(system, 85), Result::warning, "refused", "rtprio_limit");

  limits("unlimited", "95");  // permitted, so it is the control group
  write("sys/fs/cgroup/cpu,cpuacct/user.slice/cpu.rt_runtime_us", "0\n");
  const Finding group = check_fifo(system, 85);
  expect(group, Result::problem, "refused", "cpu,cpuacct/user.slice/cpu.rt_runtime_us");
  EXPECT_THAT(group.meaning, HasSubstr("budget of 0 us"));

  write("proc/self/cgroup", "0::/user.slice\n");  // version 2 has no such file
  expect(check_fifo(system, 85), Result::problem, "refused", "sched_rt_runtime_us=-1");
}

TEST_F(DoctorMachine, FifoIsAskedForWithThePriorityThatIsWanted) {
  int asked = 0;
  system.ask_fifo = [&](int priority) { return asked = priority, 0; };
  check_fifo(system, 42);
  EXPECT_EQ(asked, 42);
}

TEST_F(DoctorMachine, LimitsAreGoodWhenHighEnoughOrByCapability) {
  expect(check_rtprio(system, 85), Result::good, "up to 95");
  expect(check_memlock(system), Result::good, "without limit");
  limits("8388608", "84");
  expect(check_rtprio(system, 85), Result::warning, "up to 84", "rtprio 85");
  expect(check_memlock(system), Result::warning, "up to 8 MB", "memlock unlimited");
  write("proc/self/status", "CapEff:\t0000000000804000\n");  // CAP_SYS_NICE 23, CAP_IPC_LOCK 14
  expect(check_rtprio(system, 85), Result::good, "CAP_SYS_NICE");
  expect(check_memlock(system), Result::good, "CAP_IPC_LOCK");
}

TEST_F(DoctorMachine, GovernorsOtherThanPerformanceAreNamedWithTheirCpus) {
  expect(check_governor(system), Result::good, "performance: cpu0 cpu1");
  write("sys/devices/system/cpu/cpu1/cpufreq/scaling_governor", "powersave\n");
  expect(check_governor(system), Result::warning, "powersave: cpu1", "cpupower");
  std::filesystem::remove_all(root / "sys/devices/system/cpu/cpu0/cpufreq");
  std::filesystem::remove_all(root / "sys/devices/system/cpu/cpu1/cpufreq");
  const Finding none = check_governor(system);
  expect(none, Result::good, "no frequency scaling");
  EXPECT_THAT(none.meaning, HasSubstr("virtual machine"));
}

TEST_F(DoctorMachine, CpusOfThreadsMustBeThere) {
  expect(check_cpus(system), Result::good, "4 online (0-3)");
  expect(check_thread_cpus(system, config), Result::good, "any CPU");
  config.threads = {{.name = "frame", .priority = 70, .cpu = 2}, {.name = "actuate", .cpu = 3}};
  expect(check_thread_cpus(system, config), Result::good, "frame on 2, actuate on 3");
  config.threads[1].cpu = 4;
  const Finding missing = check_thread_cpus(system, config);
  expect(missing, Result::problem, "actuate on 4", "one of 0-3");
  EXPECT_THAT(missing.meaning, HasSubstr("no CPU 4 of actuate:"));
  write("sys/devices/system/cpu/online", "0\n");
  expect(check_cpus(system), Result::note, "1 online (0)");
}

TEST_F(DoctorMachine, IsolatedCpusAreComparedWithThoseOfTheThreads) {
  expect(check_isolation(system, nullptr), Result::note, "isolated: 2-3");
  expect(check_isolation(system, &config), Result::note, "isolated: 2-3", "name one of 2-3");
  config.threads = {{.name = "frame", .cpu = 3}};
  expect(check_isolation(system, &config), Result::good, "isolated: 2-3");
  config.threads.push_back({.name = "actuate", .cpu = 1});
  expect(check_isolation(system, &config), Result::note, "isolated: 2-3", "isolcpus=3,1");
  config.threads = {{.name = "frame", .cpu = 7}};  // is not there: nothing to isolate
  EXPECT_THAT(check_isolation(system, &config).remedy, Not(HasSubstr("isolcpus")));
  write("sys/devices/system/cpu/isolated", "\n");
  expect(check_isolation(system, nullptr), Result::note, "none isolated");
}

TEST_F(DoctorMachine, SharedCoresAndUsedSwapAreNoted) {
  expect(check_smt(system), Result::good, "off");
  write("sys/devices/system/cpu/smt/active", "1\n");
  expect(check_smt(system), Result::note, "on", "nosmt");
  expect(check_swap(system), Result::good, "none");
  write("proc/swaps",
        "Filename\tType\tSize\tUsed\tPriority\n/dev/sda2 partition\t2097152\t0\t-2\n");
  expect(check_swap(system), Result::good, "0 of 2048 MB");
  write("proc/swaps",
        "Filename\tType\tSize\tUsed\tPriority\n/dev/sda2 partition\t2097152\t1048576\t-2\n");
  expect(check_swap(system), Result::note, "1024 of 2048 MB", "swapoff");
}

TEST_F(DoctorMachine, SlowClocksAreWarnedOf) {
  expect(check_clock_source(system), Result::good, "tsc (there are: tsc hpet acpi_pm)");
  write(kClock + "current_clocksource", "hpet\n");
  expect(check_clock_source(system), Result::warning, "hpet", "echo tsc");
  write(kClock + "current_clocksource", "board_timer\n");
  expect(check_clock_source(system), Result::note, "board_timer");
  expect(check_clock_read(system), Result::good, "25 ns");
  system.clock_read_ns = [] { return 450.0; };
  expect(check_clock_read(system), Result::note, "450 ns", "clock_source");
  system.clock_read_ns = [] { return 1800.0; };
  expect(check_clock_read(system), Result::warning, "1800 ns", "clock_source");
}

TEST_F(DoctorMachine, StepsOfTheClockAreSeenAndExplained) {
  const std::int64_t before_ns = system.utc_offset_ns();
  expect(check_clock_steps(system, before_ns), Result::good, "UTC is synchronised");
  EXPECT_THAT(check_clock_steps(system, before_ns).meaning, HasSubstr("monotonic"));
  expect(check_clock_steps(system, before_ns + 250'000'000), Result::note, "stepped by -0.250 s");
  expect(check_clock_steps(system, before_ns - 3'000'000'000), Result::note, "stepped by +3.000 s");
  system.clock_synchronised = [] { return false; };
  expect(check_clock_steps(system, before_ns), Result::note, "not synchronised", "chrony");
}

TEST_F(DoctorMachine, FoldersAreThereWritableAndHaveRoom) {
  expect(check_run_dir(system), Result::good, "4096 of 8192 MB free, writable");
  expect(check_state_dir(system), Result::good, "writable");
  expect(check_shm(system, nullptr), Result::good, "4096 of 8192 MB free");

  system.find_roudi = [] { return std::nullopt; };
  system.space = [](const std::filesystem::path&) {
    return Space{.free_bytes = 20 << 20, .total_bytes = 64 << 20};
  };
  expect(check_run_dir(system), Result::warning, "20 of 64 MB free", "df -h");
  expect(check_shm(system, nullptr), Result::warning, "20 of 64 MB", "remount");
  config.shared_memory = false;
  expect(check_shm(system, &config), Result::good, "20 of 64 MB");
  system.find_roudi = [] { return dds::RoudiIdentity{}; };  // it has got its own already
  expect(check_shm(system, nullptr), Result::good, "20 of 64 MB");

  system.space = [](const std::filesystem::path&) {
    return Space{.free_bytes = 0, .total_bytes = 64 << 20};
  };
  expect(check_state_dir(system), Result::problem, "0 of 64 MB free", "df -h");
  system.space = [](const std::filesystem::path&) {
    return Space{.free_bytes = 1 << 30, .total_bytes = 1 << 30, .writable = false};
  };
  expect(check_state_dir(system), Result::note, "not writable for this user");
  system.space = [](const std::filesystem::path&) { return std::nullopt; };
  expect(check_state_dir(system), Result::note, "is not there", "mkdir -p");
}

TEST_F(DoctorMachine, ListsOfCpusAreReadAsTheKernelWritesThem) {
  EXPECT_THAT(parse_cpus("0-3,5"), ElementsAre(0, 1, 2, 3, 5));
  EXPECT_THAT(parse_cpus("7"), ElementsAre(7));
  EXPECT_THAT(parse_cpus(""), IsEmpty());
  EXPECT_THAT(parse_cpus("x,2-"), IsEmpty());
}

// As of a process that ends between open and read.
TEST_F(DoctorMachine, AFileThatCannotBeReadIsAbsent) {
  EXPECT_EQ(read_text("/"), std::nullopt);
  EXPECT_EQ(read_number("/"), std::nullopt);
  EXPECT_EQ(read_text("/dev/null"), "");
}

// Checks of this machine.
TEST(DoctorProbes, AnswerOnTheMachineThatTheTestsRunOn) {
  EXPECT_EQ(ask_fifo(100), EINVAL);  // there are 99
  const double ns = clock_read_ns();
  EXPECT_GT(ns, 0);
  EXPECT_LT(ns, 1e6);
  EXPECT_GT(utc_offset_ns(), 0);
  const std::optional<Space> room = space("/");
  ASSERT_TRUE(room.has_value());
  EXPECT_GE(room->total_bytes, room->free_bytes);
  EXPECT_FALSE(space("/nowhere").has_value());
}

}  // namespace
}  // namespace lss::cli::test
