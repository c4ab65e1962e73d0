// What lss-ros sends for cmd_vel, to a test that speaks for the daemon.

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-ros/bridge.h"

namespace lss::ros {
namespace {

using testing_support::eventually;
using testing_support::own_domain;

constexpr const char* kSource = "ros2:teleop";

class CommandsOfCmdVel : public testing::Test {
 protected:
  CommandsOfCmdVel() {
    status_.state = lss_STATE_OPERATIONAL;
    status_.instance.started_utc_ns = 1;
    status_.time_ns = 1'000'000'000'000;
  }
  // Commands before the reader is known are lost.
  bool connect() {
    const cli::Invocation probe =
        cli::with_defaults(cli::common_command(CommandKind::request_data));
    return eventually([&] {
      commander_.send(probe, kSource, kFlagDryRun);
      return take() > 0;
    });
  }
  // All samples that are there; motions are kept.
  int take() {
    lss_Command command{};
    void* samples[1] = {&command};
    dds_sample_info_t info{};
    int count = 0;
    for (; dds_take(reader_.get(), samples, &info, 1, 1) == 1; ++count) {
      if (info.valid_data && command.flags == 0) motions_.push_back(command);
    }
    return count;
  }
  bool sends(std::size_t motions) {
    return eventually([&] {
      driver_.step(status_);
      take();
      return motions_.size() == motions;
    });
  }

  const int domain_ = own_domain();
  dds::Participant ours_ = cli::checked(dds::Participant::create({.domain = domain_}));
  dds::Participant theirs_ = cli::checked(dds::Participant::create({.domain = domain_}));
  dds::Entity reader_ =
      cli::checked(dds::create_reader(theirs_.get(), dds::common_topic(dds::Kind::command)));
  Commander commander_{ours_, "zebro-1", 60'000};
  Driver driver_{*cli::find_vehicle("zebro"), commander_, {.lease_ms = 60'000}};
  lss_Status status_{};
  std::vector<lss_Command> motions_;
};

TEST_F(CommandsOfCmdVel, goes_on_with_a_daemon_that_started_again) {
  ASSERT_TRUE(connect());
  driver_.wanted({.ahead_m_s = 0.01}, kSource, status_);
  ASSERT_TRUE(sends(1)) << motions_.size();
  // It ends without an answer.
  status_.instance.started_utc_ns = 2;
  ASSERT_TRUE(sends(2)) << motions_.size();

  // Or after one, and the computer with it: its clock begins at zero.
  lss_CommandAck ack{};
  cli::put(ack.source, kSource);
  ack.seq = motions_.back().seq;
  ack.kind = motions_.back().kind;
  ack.phase = lss_PHASE_SUPERSEDED;
  ack.time_ns = status_.time_ns + 1;
  driver_.heard(ack);
  status_.instance.started_utc_ns = 3;
  status_.time_ns = 5'000'000'000;
  EXPECT_TRUE(sends(3)) << motions_.size();
}

}  // namespace
}  // namespace lss::ros
