#include "drivers/zebro/leg_module.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <numbers>
#include <string>

#include "idl/angles.h"

namespace lss::zebro {
namespace {

std::string text_of(const Frame& frame) {
  std::array<std::uint8_t, kMaxFrameCharacters> buffer{};
  const auto characters = encode(frame, Check::lrc, Stop::lf, buffer);
  return {characters.begin(), characters.end() - 1};
}

Frame frame_of(const std::string& text) {
  Receiver receiver(Check::lrc, Stop::lf);
  const std::string line = text + "\n";
  receiver.receive(std::vector<std::uint8_t>(line.begin(), line.end()), 0);
  return receiver.take().value().frame;
}

TEST(LegModule, CommandsAreTheGoldenFramesOfTheInterfaceDocument) {
  EXPECT_EQ(text_of(command(1, Code::start_motion_control)), ":01010000000000000000FE");
  EXPECT_EQ(text_of(command(6, Code::stop_motion_control)), ":06020000000000000000F8");
  EXPECT_EQ(text_of(rotate(3, Code::rotate_forward, 9'000, 1'000)), ":0303232803E800000000C4");
  EXPECT_EQ(text_of(rotate(2, Code::rotate_backward, 34'000, 3'000)), ":020484D00BB800000000E3");
  EXPECT_EQ(text_of(request(7, Page::status)), ":07050000000000000000F4");
  EXPECT_EQ(text_of(request(1, Page::health)), ":01050100000000000000F9");
  EXPECT_EQ(text_of(request(4, Page::identity)), ":04050200000000000000F5");
  EXPECT_EQ(text_of(command(kBroadcast, Code::emergency_stop)), ":00060000000000000000FA");
  EXPECT_EQ(text_of(command(2, Code::reset)), ":02070000000000000000F7");
}

TEST(LegModule, TheGoldenStatusIsDecodedToSiUnits) {
  const Frame frame = frame_of(":034000072328FB5000968A");
  EXPECT_EQ(frame.code, static_cast<std::uint8_t>(reply_code(Page::status)));
  const Status status = decode_status(frame.data);
  EXPECT_EQ(status.flags, kFlagMotionControl | kFlagCalibrated | kFlagMoving);
  EXPECT_DOUBLE_EQ(status.position_rad, 90 * kDegree);
  EXPECT_DOUBLE_EQ(status.velocity_rad_s, -120 * kDegree);
  EXPECT_DOUBLE_EQ(status.current_A, 0.150);
}

TEST(LegModule, TheGoldenHealthIsDecodedToSiUnits) {
  const Frame frame = frame_of(":0141FBE62EE0232802EE94");
  EXPECT_EQ(frame.code, static_cast<std::uint8_t>(reply_code(Page::health)));
  const Health health = decode_health(frame.data);
  EXPECT_DOUBLE_EQ(health.temperature_degC, -10.5);
  EXPECT_DOUBLE_EQ(health.supply_V, 12.0);
  EXPECT_DOUBLE_EQ(health.set_point_rad, 90 * kDegree);
  EXPECT_DOUBLE_EQ(health.time_left_s, 0.75);
}

TEST(LegModule, TheGoldenIdentityIsDecoded) {
  const Frame frame = frame_of(":0442010203070001E2408A");
  EXPECT_EQ(frame.code, static_cast<std::uint8_t>(reply_code(Page::identity)));
  const Identity identity = decode_identity(frame.data);
  EXPECT_EQ(identity.firmware_major, 1);
  EXPECT_EQ(identity.firmware_minor, 2);
  EXPECT_EQ(identity.reset_cause, static_cast<std::uint8_t>(ResetCause::command));
  EXPECT_EQ(identity.dropped_frames, 7);
  EXPECT_DOUBLE_EQ(identity.uptime_s, 123.456);
}

TEST(LegModule, AnAngleJustBelowAFullTurnIsStraightDown) {
  EXPECT_EQ(position_cdeg(-1e-9), 0);
  EXPECT_EQ(position_cdeg(2 * std::numbers::pi - 1e-9), 0);
  EXPECT_EQ(position_cdeg(-90 * kDegree), 27'000);
  EXPECT_EQ(position_cdeg(450 * kDegree), 9'000);
}

RC_GTEST_PROP(LegModule, EveryPositionComesBackFromRadiansAfterAnyNumberOfTurns, ()) {
  const auto cdeg = static_cast<std::uint16_t>(*rc::gen::inRange(0, int{kTurn_cdeg}));
  const int turns = *rc::gen::inRange(-100, 100);
  const double angle_rad = cdeg * 0.01 * kDegree + turns * 2 * std::numbers::pi;
  RC_ASSERT(position_cdeg(angle_rad) == cdeg);
}

RC_GTEST_PROP(LegModule, AnyAngleGivesALegalPosition, (double angle_rad)) {
  RC_PRE(std::isfinite(angle_rad));
  RC_ASSERT(position_cdeg(angle_rad) < kTurn_cdeg);
}

}  // namespace
}  // namespace lss::zebro
