// Nodes by their frames: NMT, boot-up, heartbeats, SDO, PDO configuration, EMCY (ICD sections 4, 5,
// 7, 8, 10, 11).

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/ardito/sim/master.h"
#include "tools/lss-sim/ardito/devices.h"
#include "tools/lss-sim/ardito/drive.h"

namespace lss::sim::ardito {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::Not;

// One wheel drive, the I/O node and the IMU on a bus, their motors at standstill.
class Nodes : public testing::Test {
 protected:
  Nodes() {
    for (Node* node : all_) node->power_on();
  }

  void step() {
    wheel_.set_link_V(24.05);
    wheel_.feel(train_, {});
    io_.feel({.beta_rad = 0.1, .rho1_rad = -0.05, .rho2_rad = 0}, button_, !button_);
    imu_.feel(body_);
    for (Node* node : all_) node->step();
  }
  std::optional<CanFrame> hear() {
    for (Node* node : all_) {
      if (auto said = node->send()) return said;
    }
    return std::nullopt;
  }
  void bring_up() {
    for (const unsigned node : {0x01u, 0x20u, 0x21u}) ASSERT_TRUE(master_.bring_up(node));
    master_.tell("77F [1] 05");
    master_.run(5);
    master_.heard.clear();
  }
  // With 200 ms of the master's heartbeat before and after.
  void stay_alive(int ms) {
    for (; ms > 0; ms -= 100) {
      master_.tell("77F [1] 05");
      master_.run(std::min(ms, 100));
    }
  }

  WheelDrive wheel_{0x01, 1};
  IoNode io_{2};
  ImuNode imu_{3};
  std::array<Node*, 3> all_ = {&wheel_, &io_, &imu_};
  WheelTrain train_;
  BodyState body_;
  bool button_ = false;
  Master master_{[this](const CanFrame& frame) {
                   for (Node* node : all_) node->receive(frame);
                 },
                 [this] { return hear(); }, [this] { step(); }};
};

TEST_F(Nodes, BootUpComesOnceWithin500msAndNothingBefore) {
  master_.tell("601 [8] 40 00 10 00 00 00 00 00");
  master_.run(500);
  EXPECT_THAT(master_.heard,
              testing::UnorderedElementsAre("701 [1] 00", "720 [1] 00", "721 [1] 00"));
  EXPECT_EQ(wheel_.state(), Nmt::pre_operational);
}

TEST_F(Nodes, SdoAnswersAreThoseOfTheGoldenFrames) {
  master_.run(500);
  EXPECT_EQ(master_.ask("601 [8] 2F 60 60 00 03 00 00 00"), "581 [8] 60 60 60 00 00 00 00 00");
  EXPECT_EQ(master_.ask("601 [8] 40 00 10 00 00 00 00 00"), "581 [8] 43 00 10 00 92 01 02 00");
  EXPECT_EQ(master_.ask("601 [8] 40 FF 5F 00 00 00 00 00"), "581 [8] 80 FF 5F 00 00 00 02 06");
  EXPECT_EQ(master_.ask("620 [8] 40 00 10 00 00 00 00 00"), "5A0 [8] 43 00 10 00 91 01 07 00");
  EXPECT_EQ(master_.ask("621 [8] 40 00 10 00 00 00 00 00"), "5A1 [8] 43 00 10 00 00 00 01 00");
}

TEST_F(Nodes, WrongSdoRequestsAreAbortedWithTheirCode) {
  master_.run(500);
  EXPECT_EQ(master_.write(1, 0x1000, 0, 4, 1), 0x06010002u);  // read-only
  EXPECT_EQ(master_.write(1, 0x1016, 7, 4, 1), 0x06090011u);  // no such sub-index
  EXPECT_EQ(master_.write(1, 0x5FFF, 0, 4, 1), 0x06020000u);  // no such object
  EXPECT_EQ(master_.write(1, 0x1017, 0, 4, 1), 0x06070010u);  // length
  EXPECT_EQ(master_.write(1, 0x6060, 0, 1, 1), 0x06090030u);  // a mode that it does not have
  EXPECT_EQ(master_.write(1, 0x6083, 0, 4, 0), 0x06090030u);
  EXPECT_EQ(master_.ask("601 [8] 60 17 10 00 00 00 00 00"), "581 [8] 80 17 10 00 01 00 04 05");
}

TEST_F(Nodes, APdoThatExistsKeepsItsMapping) {
  master_.run(500);
  ASSERT_TRUE(master_.bring_up(0x01));
  EXPECT_EQ(master_.write(1, 0x1A00, 0, 1, 0), 0x06010000u);
  EXPECT_EQ(master_.write(1, 0x1A00, 1, 4, 0x60410010), 0x06010000u);
  EXPECT_EQ(master_.write(1, 0x1800, 1, 4, 0x40000199), 0x06090030u);  // another identifier
  EXPECT_EQ(master_.write(1, 0x1800, 1, 4, 0xC0000181), 0u);
  EXPECT_EQ(master_.write(1, 0x1A00, 1, 4, 0x60410010), 0x06010000u);  // while it counts 3
  EXPECT_EQ(master_.write(1, 0x1A00, 0, 1, 0), 0u);
  EXPECT_EQ(master_.write(1, 0x1A00, 1, 4, 0x5FFF0010), 0x06020000u);
  EXPECT_EQ(master_.write(1, 0x1A00, 1, 4, 0x10170010), 0x06040041u);
  EXPECT_EQ(master_.write(1, 0x1A00, 1, 4, 0x606C0010), 0x06040041u);  // 16 bits of 32
  for (unsigned sub : {1u, 2u, 3u}) EXPECT_EQ(master_.write(1, 0x1A00, sub, 4, 0x606C0020), 0u);
  EXPECT_EQ(master_.write(1, 0x1A00, 0, 1, 3), 0x06040042u);  // 96 bits
  EXPECT_EQ(master_.write(1, 0x1A00, 0, 1, 2), 0u);
}

TEST_F(Nodes, ConfiguredNodesSendTheirPdosInOperationalOnly) {
  for (const unsigned node : {0x01u, 0x20u, 0x21u}) ASSERT_TRUE(master_.bring_up(node));
  master_.heard.clear();
  master_.tell("080 [0]");
  master_.run(5);
  EXPECT_THAT(master_.heard, Contains(testing::StartsWith("181 [8] 50 12 00 00 00 00")));
  EXPECT_THAT(master_.heard, Contains("1A0 [1] 02"));
  for (const std::uint32_t id : {0x181u, 0x281u, 0x1A0u, 0x2A0u, 0x1A1u}) {
    EXPECT_TRUE(master_.last.contains(id)) << id;
  }
  master_.tell("000 [2] 80 00");
  master_.heard.clear();
  master_.tell("080 [0]");
  master_.run(5);
  EXPECT_THAT(master_.heard, Not(Contains(testing::StartsWith("181"))));
}

TEST_F(Nodes, MeasurementsComeInTheUnitsOfTheIcd) {
  bring_up();
  body_.velocity_B_m_s = {-0.498, 0.0436, 0};  // backward and to the left: behind to the right
  body_.yaw_rate_rad_s = -0.012;
  stay_alive(300);
  for (int i = 0; i < 258; ++i) master_.tell("080 [0]");
  master_.run(5);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x1A1], 0)), -500, 20);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x1A1], 2)), 873, 150);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x1A1], 4)), 12, 8);
  EXPECT_EQ(i16_at(master_.last[0x1A1], 6), 258);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x2A0], 0)), 1000, 40);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x2A0], 2)), -500, 40);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x2A0], 4)), 0, 40);
}

TEST_F(Nodes, TemperatureAndVoltageComeOnceASecond) {
  bring_up();
  stay_alive(3050);
  EXPECT_EQ(std::ranges::count_if(master_.heard,
                                  [](const auto& each) { return each.starts_with("381"); }),
            3);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x381], 0)), 250, 5);
  EXPECT_NEAR(static_cast<double>(i16_at(master_.last[0x381], 2)), 2405, 10);
}

TEST_F(Nodes, HeartbeatsComeEvery100msWithTheState) {
  bring_up();
  stay_alive(1000);
  EXPECT_EQ(std::ranges::count(master_.heard, "701 [1] 05"), 10);
  master_.tell("000 [2] 02 01");
  master_.heard.clear();
  stay_alive(200);
  EXPECT_EQ(std::ranges::count(master_.heard, "701 [1] 04"), 2);
  EXPECT_EQ(master_.ask("601 [8] 40 00 10 00 00 00 00 00"), "nothing");
}

TEST_F(Nodes, ALostMasterMakesThemReportAndLeaveOperational) {
  bring_up();
  master_.tell("220 [1] 3F");
  master_.tell("77F [1] 05");
  master_.run(299);
  EXPECT_EQ(wheel_.state(), Nmt::operational);
  master_.run(20);
  EXPECT_EQ(wheel_.state(), Nmt::pre_operational);
  EXPECT_THAT(master_.heard, Contains("081 [8] 30 81 11 00 00 00 00 00"));
  EXPECT_TRUE(io_.clutch(0)) << "clutches stay";
  EXPECT_TRUE(io_.beacon());
  master_.heard.clear();
  stay_alive(200);
  EXPECT_THAT(master_.heard, Contains("081 [8] 00 00 00 00 00 00 00 00"));
  EXPECT_EQ(wheel_.state(), Nmt::pre_operational) << "not back by itself";
}

TEST_F(Nodes, WithoutAFirstHeartbeatOfTheMasterNobodyWatchesIt) {
  ASSERT_TRUE(master_.bring_up(0x01));
  master_.run(1000);
  EXPECT_EQ(wheel_.state(), Nmt::operational);
}

TEST_F(Nodes, ThePushOfTheButtonIsSentAtOnceAndNotTwiceWithinItsInhibitTime) {
  bring_up();
  master_.run(20);
  master_.heard.clear();
  button_ = true;
  master_.run(2);
  EXPECT_THAT(master_.heard, ElementsAre("1A0 [1] 01"));
  button_ = false;
  master_.run(1);
  master_.tell("080 [0]");
  EXPECT_EQ(std::ranges::count(master_.heard, "1A0 [1] 02"), 0);
  master_.run(5);
  EXPECT_EQ(std::ranges::count(master_.heard, "1A0 [1] 02"), 1);
}

TEST_F(Nodes, OutputsFollowAtOnceAndAResetOpensTheClutches) {
  bring_up();
  master_.tell("220 [1] 7F");
  for (std::size_t wheel = 0; wheel < kWheels; ++wheel) EXPECT_TRUE(io_.clutch(wheel));
  EXPECT_TRUE(io_.beacon());
  master_.tell("000 [2] 80 20");
  EXPECT_TRUE(io_.clutch(3)) << "ordered out of operational: outputs stay";
  master_.tell("000 [2] 81 20");
  EXPECT_FALSE(io_.clutch(3));
  EXPECT_FALSE(io_.beacon());
}

TEST_F(Nodes, APdoOfWrongLengthIsNotUsedAndReported) {
  bring_up();
  master_.tell("220 [2] 7F 00");
  master_.run(20);
  EXPECT_FALSE(io_.clutch(0));
  EXPECT_THAT(master_.heard, Contains("0A0 [8] 10 82 11 00 00 00 00 00"));
  master_.tell("220 [1] 01");
  master_.run(20);
  EXPECT_TRUE(io_.clutch(0));
  EXPECT_THAT(master_.heard, Contains("0A0 [8] 00 00 00 00 00 00 00 00"));
}

TEST_F(Nodes, AResetNodeForgetsItsConfiguration) {
  bring_up();
  master_.last.clear();
  master_.tell("000 [2] 81 01");
  master_.run(500);
  EXPECT_EQ(master_.ask("601 [8] 40 17 10 00 00 00 00 00"), "581 [8] 4B 17 10 00 00 00 00 00");
  EXPECT_EQ(master_.ask("601 [8] 40 00 18 01 00 00 00 00"), "581 [8] 43 00 18 01 81 01 00 C0");
  EXPECT_EQ(master_.ask("601 [8] 40 00 14 01 00 00 00 00"), "581 [8] 43 00 14 01 01 02 00 80");
}

TEST_F(Nodes, InjectedFaultsAreSeenOnTheBus) {
  bring_up();
  wheel_.faults.longer_pdos = -2;
  master_.tell("080 [0]");
  master_.run(1);
  EXPECT_EQ(master_.last[0x181].size, 6);
  wheel_.faults = {.sdo_abort = 0x08000000};
  EXPECT_EQ(master_.write(1, 0x1017, 0, 2, 100), 0x08000000u);
  wheel_.faults = {.babble_1_s = 2000};
  master_.heard.clear();
  master_.run(100);
  EXPECT_NEAR(static_cast<double>(master_.heard.size()), 200, 10);
  wheel_.faults = {.silent = true};
  master_.heard.clear();
  master_.tell("080 [0]");
  master_.run(100);
  EXPECT_THAT(master_.heard, Not(Contains(testing::HasSubstr("81 ["))));
  wheel_.faults = {};
  wheel_.set_device_type(0x000F0191);
  master_.run(1);
  EXPECT_EQ(master_.ask("601 [8] 40 00 10 00 00 00 00 00"), "581 [8] 43 00 10 00 91 01 0F 00");
}

TEST_F(Nodes, AnErrorIsReportedOnceAndSettledOnce) {
  bring_up();
  imu_.inject_emcy(0x4210, true);
  imu_.inject_emcy(0x4210, true);
  stay_alive(200);
  EXPECT_EQ(std::ranges::count(master_.heard, "0A1 [8] 10 42 09 00 00 00 00 00"), 1);
  EXPECT_EQ(master_.ask("621 [8] 40 01 10 00 00 00 00 00"), "5A1 [8] 4F 01 10 00 09 00 00 00");
  imu_.inject_emcy(0x4210, false);
  stay_alive(200);
  EXPECT_EQ(std::ranges::count(master_.heard, "0A1 [8] 00 00 00 00 00 00 00 00"), 1);
}

TEST_F(Nodes, FramesThatAreNotForThemChangeNothing) {
  bring_up();
  CanFrame extended = frame("220 [1] 7F"), remote = extended;
  extended.extended = true;
  remote.remote = true;
  master_.tell(extended);
  master_.tell(remote);
  master_.tell("000 [1] 02");
  master_.tell("000 [2] 02 02");
  master_.tell("080 [1] 01");
  master_.run(5);
  EXPECT_FALSE(io_.clutch(0));
  EXPECT_EQ(wheel_.state(), Nmt::operational);
  EXPECT_THAT(master_.heard, IsEmpty());
}

}  // namespace
}  // namespace lss::sim::ardito
