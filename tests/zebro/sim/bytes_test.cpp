// The bytes on the wire (golden frames of docs/icd-zebro.md).

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <string>

#include "tools/lss-sim/frame/runner.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::sim::zebro {
namespace {

class Bytes : public testing::Test {
 protected:
  std::string say(const std::string& characters) { return say(zebro_, characters); }
  static std::string say(Zebro& zebro, const std::string& characters) {
    std::string heard;
    for (const char c : characters) {
      const auto reply = zebro.receive(static_cast<std::uint8_t>(c), 0);
      heard.append(reply.begin(), reply.end());
    }
    return heard;
  }
  void run(double seconds) {
    for (long i = std::lround(seconds / kStep_s); i > 0; --i) zebro_.step();
  }
  void inject(const char* text, bool attach = true) {
    const auto vehicle = make_zebro_kind();
    zebro_.set_fault(parse_fault(text, vehicle->fault_kinds()).value(), attach);
  }

  Zebro zebro_{ZebroOptions{}};
};

TEST_F(Bytes, AStatusRequestIsAnsweredWithTheModulesOwnAddress) {
  EXPECT_EQ(say(":01050000000000000000FA\n"), ":014000800000000000003F\n");
  EXPECT_EQ(say(":01050000000000000000FA\n"), ":01400000000000000000BF\n");
}

TEST_F(Bytes, ThePanelIsCalibratedAtItsSensorFromTheStart) {
  EXPECT_EQ(say(":07050000000000000000F4\n"), ":074000C2000000000000F7\n");
}

TEST_F(Bytes, HealthAndIdentityAreAnsweredOnTheirPages) {
  EXPECT_EQ(say(":01050100000000000000F9\n"), ":014108A22EE00000000006\n");
  EXPECT_EQ(say(":04050200000000000000F5\n"), ":04420100000000000000B9\n");
}

TEST_F(Bytes, CommandsAreNotAnsweredAndTakeEffectBeforeTheNextRequest) {
  EXPECT_EQ(say(":01010000000000000000FE\n"), "");
  EXPECT_EQ(say(":01050000000000000000FA\n"), ":014000810000000000003E\n");
}

TEST_F(Bytes, TheEmergencyStopReachesAllByOneFrame) {
  for (const char* start : {":01010000000000000000FE\n", ":06010000000000000000F9\n"}) say(start);
  EXPECT_EQ(say(":00060000000000000000FA\n"), "");
  EXPECT_EQ(say(":01050000000000000000FA\n"), ":014000800000000000003F\n");
  EXPECT_EQ(say(":06050000000000000000F5\n"), ":064000800000000000003A\n");
}

TEST_F(Bytes, BrokenFramesAreDroppedSilentlyAndCounted) {
  EXPECT_EQ(say(":01050000000000000000FB\n"), "");   // check
  EXPECT_EQ(say("garbage\n"), "");                   // start
  EXPECT_EQ(say(":0105000000\n"), "");               // length
  EXPECT_EQ(say(":0105000000000000000g0FA\n"), "");  // character
  EXPECT_EQ(say(":01050200000000000000F8\n"), ":01420100000400000000B8\n");
}

TEST_F(Bytes, OtherAddressesAndRepliesAreIgnored) {
  EXPECT_EQ(say(":08050000000000000000F3\n"), "");
  EXPECT_EQ(say(":014000800000000000003F\n"), "");
  EXPECT_EQ(say(":01050200000000000000F8\n"), ":01420100000000000000BC\n");
}

TEST_F(Bytes, TheOtherCheckAndStopAreUsedToo) {
  Zebro zebro({.terrain = {}, .check = lss::zebro::Check::crc8, .stop = lss::zebro::Stop::crlf});
  const std::string reply = say(zebro, ":0705000000000000000058\r\n");
  EXPECT_EQ(reply.size(), 25u);
  EXPECT_EQ(reply.substr(0, 21), ":074000C2000000000000");
  EXPECT_EQ(reply.substr(23), "\r\n");
}

TEST_F(Bytes, ThePanelDeploysAndStopsAtItsEnd) {
  say(":07010000000000000000F8\n");
  say(":07032AF80FA00000000025\n");  // forward to 110.00 deg in 4000 ms
  run(4.2);
  EXPECT_NEAR(zebro_.truth()["panel_rad"].get<double>(), 110 * std::numbers::pi / 180, 0.02);
  say(":0703465007D00000000089\n");  // to 180 deg: past its stop
  run(2.5);
  EXPECT_NEAR(zebro_.truth()["panel_rad"].get<double>(), 110 * std::numbers::pi / 180, 0.06);
  const std::string status = say(":07050000000000000000F4\n");
  EXPECT_EQ(std::stoi(status.substr(5, 4), nullptr, 16) & 0x09, 0x08) << status;  // over-current
}

TEST_F(Bytes, AResetModuleIsSilentThenUncalibratedAndSaysSo) {
  inject("module-reset:7");
  EXPECT_EQ(say(":07050000000000000000F4\n"), "");
  run(0.3);
  EXPECT_EQ(say(":07050200000000000000F2\n").substr(5, 6), "010002");  // brown-out
}

TEST_F(Bytes, ADeadModuleIsSilentAndTheOthersAnswer) {
  inject("module-dead:1");
  EXPECT_EQ(say(":01050000000000000000FA\n"), "");
  EXPECT_NE(say(":07050000000000000000F4\n"), "");
  inject("module-dead:1", false);
  run(0.3);
  EXPECT_NE(say(":01050000000000000000FA\n"), "");
}

TEST_F(Bytes, AStuckLegStallsItsModuleAndDoesNotMove) {
  inject("leg-stuck:1");
  const double before = zebro_.truth()["leg_angle_rad"][0];
  say(":01010000000000000000FE\n");
  say(":0103232803E800000000C6\n");  // forward to 90.00 deg in 1000 ms
  run(0.3);
  EXPECT_NEAR(zebro_.truth()["leg_angle_rad"][0].get<double>(), before, 1e-3);
  const std::string status = say(":01050000000000000000FA\n");
  EXPECT_EQ(std::stoi(status.substr(5, 4), nullptr, 16) & 0x09, 0x08) << status;
}

TEST_F(Bytes, ADraggingLegDrawsMoreButStillMoves) {
  inject("over-current:1:0.5");
  say(":01010000000000000000FE\n");
  say(":0103465007D0000000008F\n");  // forward to 180.00 deg in 2000 ms
  run(0.3);
  const std::string status = say(":01050000000000000000FA\n");
  EXPECT_GT(std::stoi(status.substr(17, 4), nullptr, 16), 900) << status;  // mA
  EXPECT_EQ(std::stoi(status.substr(5, 4), nullptr, 16) & 0x0D, 0x05) << status;
}

}  // namespace
}  // namespace lss::sim::zebro
