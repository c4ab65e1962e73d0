// lss-cli doctor as a program, on the machine that the tests run on: on any machine, the report
// must be whole and the exit code must fit it.

#include <fcntl.h>
#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <set>

#include "tests/cli/program_test.h"
#include "tests/support/temp_folder.h"

namespace lss::cli::test {
namespace {

class Doctor : public ProgramTest {
 protected:
  std::string config(const std::string& text) const {
    std::ofstream(folder_ / "zebro.toml") << text;
    return folder_ / "zebro.toml";
  }
  // Runs doctor and compares the exit code with the report.
  json examine(std::vector<std::string> more) const {
    std::vector<std::string> words = {"--json", "--timeout", "300ms",
                                      "doctor", "--run-dir", folder_};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = run(words);
    json report = json::parse(ended.out);
    std::size_t problems = 0;
    for (const json& check : report.at("checks")) {
      const std::string name = check.at("name"), result = check.at("result");
      EXPECT_THAT(result, AnyOf("good", "note", "warning", "problem")) << name;
      EXPECT_FALSE(check.at("found").get<std::string>().empty()) << name;
      EXPECT_FALSE(check.at("meaning").get<std::string>().empty()) << name;
      const bool silent = check.at("remedy").get<std::string>().empty();
      EXPECT_TRUE(!silent || result == "good" || result == "note") << name;
      problems += result == "problem" ? 1U : 0U;
    }
    EXPECT_EQ(report.at("schema_version"), 2);
    EXPECT_EQ(report.at("problems"), problems);
    EXPECT_EQ(ended.code, problems > 0 ? 6 : 0) << ended.err;
    return report;
  }
  static json check(const json& report, const std::string& name) {
    for (const json& check : report.at("checks")) {
      if (check.at("name") == name) return check;
    }
    ADD_FAILURE() << "no check " << name;
    return {};
  }

  testing_support::TempFolder folder_;
};

TEST_F(Doctor, ChecksTheMachineWithoutAConfiguration) {
  const json report = examine({});
  std::set<std::string> names;
  for (const json& check : report.at("checks")) {
    const std::string name = check.at("name");
    names.insert(name.substr(name.rfind(' ') + 1));  // with several configurations: "zebro-1 roudi"
  }
  EXPECT_THAT(names, IsSupersetOf({"kernel", "rt_throttle", "sched_fifo", "rtprio_limit",
                                   "memlock_limit", "cpu_governor", "cpus", "cpu_isolation", "smt",
                                   "swap", "clock_source", "clock_read", "clock_steps", "dds_uri",
                                   "dds_buffers", "run_dir", "state_dir", "shm", "roudi"}));
}

TEST_F(Doctor, PortThatIsNotThereAndCpuThatIsNotThereAreProblems) {
  const json report =
      examine({"--config", config("vehicle = \"zebro\"\n[[port]]\nname = \"legs\"\n"
                                  "path = \"/dev/ttyNowhere7\"\n"
                                  "[[realtime.thread]]\nname = \"frame\"\ncpu = 1023\n")});
  EXPECT_EQ(check(report, "config").at("result"), "good");
  EXPECT_EQ(check(report, "port/legs").at("result"), "problem");
  EXPECT_THAT(check(report, "port/legs").at("found"), HasSubstr("/dev/ttyNowhere7"));
  EXPECT_EQ(check(report, "thread_cpus").at("result"), "problem");
  EXPECT_THAT(check(report, "thread_cpus").at("meaning"), HasSubstr("CPU 1023 of frame"));
}

TEST_F(Doctor, BrokenConfigurationIsOneProblemAndTheRestIsStillChecked) {
  const json report = examine({"--config", config("vehicle = \"zebro\"\n[[port]\n")});
  EXPECT_EQ(check(report, "config").at("result"), "problem");
  EXPECT_THAT(check(report, "config").at("found"), HasSubstr("zebro.toml:2:"));
  EXPECT_THAT(check(report, "kernel").at("found"), HasSubstr("Linux"));
  EXPECT_EQ(check(examine({"--config", "/nowhere.toml"}), "config").at("result"), "problem");
}

TEST_F(Doctor, NamesOfSeveralConfigurationsSayWhose) {
  const std::string one = config("vehicle = \"zebro\"\nvehicle_id = \"z7\"\n");
  const std::string two = folder_ / "two.toml";
  std::ofstream(two) << "vehicle = \"zebro\"\n[dds]\nshared_memory = false\n";
  const json report = examine({"--config", one, "--config", two});
  EXPECT_THAT(check(report, "z7 config").at("found"), HasSubstr(one));
  EXPECT_THAT(check(report, "zebro-1 config").at("found"), HasSubstr(two));
  EXPECT_THAT(check(report, "zebro-1 roudi").at("meaning"),
              HasSubstr("dds.shared_memory is false"));
  EXPECT_THAT(check(report, "kernel").at("found"), HasSubstr("Linux"));
}

TEST_F(Doctor, WhoHasThePortIsSeenInProc) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY | O_CLOEXEC);
  char name[64];
  ASSERT_TRUE(grantpt(master) == 0 && unlockpt(master) == 0 &&
              ptsname_r(master, name, sizeof name) == 0);
  std::filesystem::create_symlink(name, folder_ / "legs");
  const std::string file =
      config("vehicle = \"zebro\"\n[[port]]\nname = \"legs\"\npath = \"sim:legs\"\n");
  EXPECT_EQ(check(examine({"--config", file}), "port/legs").at("result"), "good");
  const int slave = open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  const json held = check(examine({"--config", file}), "port/legs");
  EXPECT_EQ(held.at("result"), "problem");
  EXPECT_THAT(held.at("found"), HasSubstr("(pid " + std::to_string(getpid()) + ")"));
  close(slave);
  close(master);
}

TEST_F(Doctor, AsksTheDaemonForItsContract) {
  const std::vector<std::string> words = {"--config", config("vehicle = \"zebro\"\n")};
  EXPECT_THAT(check(examine(words), "daemon").at("found"), HasSubstr("no vehicle answers"));
  FakeDaemon daemon(domain());
  const json report = examine(words);
  EXPECT_EQ(check(report, "daemon").at("result"), "good");
  EXPECT_THAT(check(report, "daemon").at("found"),
              AllOf(HasSubstr("zebro-1"), HasSubstr("domain " + std::to_string(domain()))));
  EXPECT_THAT(check(report, "daemon_contract").at("found"), HasSubstr("policy"));
  daemon.latch(FaultId::module_silent, 4);
  ASSERT_TRUE(await([&] { return check(examine(words), "daemon").at("result") == "note"; }));
}

TEST_F(Doctor, TwoDaemonsOfOneNameAreAProblemThatNamesBoth) {
  const std::vector<std::string> words = {"--config", config("vehicle = \"zebro\"\n")};
  FakeDaemon first(domain(), Birth{.pid = 1001});
  FakeDaemon other(domain(), Birth{.vehicle_id = "zebro-2", .pid = 1003});
  const json single = check(examine(words), "daemon_names");
  EXPECT_EQ(single.at("result"), "good");
  EXPECT_THAT(single.at("found"), AllOf(HasSubstr("zebro-1 (obc, pid 1001"), HasSubstr("1003")));
  FakeDaemon second(domain(), Birth{.pid = 1002});
  const json twice = check(examine(words), "daemon_names");
  EXPECT_EQ(twice.at("result"), "problem");
  EXPECT_THAT(twice.at("found"), AllOf(HasSubstr("pid 1001"), HasSubstr("pid 1002")));
  EXPECT_THAT(twice.at("meaning"), HasSubstr("several daemons are zebro-1"));
}

TEST_F(Doctor, DomainComesFromTheConfigurationUnlessItIsGiven) {
  const std::string file = config("vehicle = \"zebro\"\n[dds]\ndomain = 231\n");
  EXPECT_THAT(check(examine({"--config", file}), "daemon").at("found"),
              HasSubstr("domain " + std::to_string(domain())));  // LSS_DOMAIN
  const std::string out = folder_ / "out";
  EXPECT_NE(std::system(("env -u LSS_DOMAIN '" LSS_CLI "' --json --timeout 300ms doctor --config " +
                         file + " > " + out)
                            .c_str()),
            0);
  const json found = check(json::parse(std::ifstream(out)), "daemon");
  EXPECT_EQ(found.at("result"), "problem");
  EXPECT_THAT(found.at("found"), HasSubstr("231 is out of range"));
}

TEST_F(Doctor, IsReadableInATerminalAndInAPipe) {
  const Ended ended = run({"--timeout", "300ms", "doctor", "--run-dir", folder_});
  EXPECT_THAT(ended.out,
              AllOf(HasSubstr("  kernel "), HasSubstr(" problem"), Not(HasSubstr("\x1b"))));
  const Ended explained = run({"--timeout", "300ms", "doctor", "--explain", "--run-dir", folder_});
  EXPECT_GT(explained.out.size(), ended.out.size());
}

}  // namespace
}  // namespace lss::cli::test
