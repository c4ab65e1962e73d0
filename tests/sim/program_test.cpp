// lss-sim with the example scout as a program: its bus, simulated time, faults by name.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <thread>

#include "drivers/lockstep/lockstep.h"
#include "tests/support/sim_process.h"

namespace lss::sim {
namespace {

// A daemon that takes part in the simulated time of this folder and does nothing.
class Daemon {
 public:
  explicit Daemon(const std::string& folder) : pid_(::fork()) {
    if (pid_ != 0) return;
    if (!lockstep::join(folder, "lssd").empty()) ::_exit(1);
    std::thread bus([] {
      const lockstep::Part part("bus");
      lockstep::wait(lockstep::kNever);
    });
    lockstep::begin(1);
    bus.join();
    ::_exit(0);
  }
  ~Daemon() {
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

 private:
  pid_t pid_;
};

class ScoutProgram : public SimProgram {
 protected:
  // The truth of three seconds of simulated time.
  std::string lockstep(const std::string& seed) {
    Process sim(
        arguments("scout", {"--can", "udp://127.0.0.1:0", "--pace", "--lockstep", "--speed", "max",
                            "--for", "3", "--seed", seed, "--truth", truth().string(), "--fault",
                            "1s:wheel-blocked:left", "--fault", "1s:node-silent:0x02"}));
    EXPECT_TRUE(sim.says("ready"));
    const Daemon daemon(folder_.string());
    EXPECT_EQ(sim.wait(), 0) << sim.heard;
    EXPECT_THAT(sim.heard, testing::StartsWith("lss-sim: scout ready, CAN bus rover at udp://"));
    std::ifstream file(truth());
    return {std::istreambuf_iterator(file), {}};
  }
};

TEST_F(ScoutProgram, RunsInSimulatedTimeWithTheSameBits) {
  const std::string truth = lockstep("7");
  EXPECT_EQ(truth, lockstep("7"));
  const auto last = nlohmann::json::parse(truth.substr(truth.rfind('{')));
  EXPECT_EQ(last.at("attached_faults"), nlohmann::json({"wheel-blocked:left", "node-silent:0x02"}));
  EXPECT_EQ(last.at("power"), nlohmann::json({"switch on disabled", "switch on disabled"}));
  EXPECT_NEAR(last.at("t_s").get<double>(), 3, 0.01);
}

TEST_F(ScoutProgram, ListsTheFaultsOfItsNodesAndItsOwn) {
  Process list({"faults", "scout"});
  EXPECT_EQ(list.wait(), 0);
  for (const char* each : {"wheel-blocked:WHEEL", "one of left, right", "node-silent:NODE",
                           "one of 0x01, 0x02", "drive-fault:NODE[:CODE]", "bus-off:SECONDS"}) {
    EXPECT_THAT(list.heard, testing::HasSubstr(each));
  }
}

}  // namespace
}  // namespace lss::sim
