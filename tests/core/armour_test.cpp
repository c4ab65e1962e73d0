#include "daemon/core/armour.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <string>

#include "daemon/core/command_port.h"

namespace lss {
namespace {

constexpr const char* kColours[] = {"red", "green"};
constexpr ParameterInfo kParameters[] = {
    {"angle", "rad", -1, 1, 0, nullptr, ""},
    {"colour", "choice", 0, 1, 0, kColours, ""},
};
constexpr CommandInfo kMove{7, "move", Access::holder, true, "", kParameters};
constexpr CommandInfo kStop{3, "estop", Access::anyone, false, "", {}};

const CommandInfo* lookup(std::uint16_t kind) {
  if (kind == kMove.kind) return &kMove;
  return kind == kStop.kind ? &kStop : nullptr;
}

Name name(const std::string& text) {
  Name n{};
  text.copy(n.data(), n.size() - 1);
  return n;
}

Request move(std::uint64_t sequence, double angle = 0, double colour = 0) {
  Request r{.source = name("test"), .sequence = sequence, .kind = kMove.kind, .lease_ms = 1000};
  r.parameter[0] = angle;
  r.parameter[1] = colour;
  r.arrival_ns = static_cast<TimeNs>(sequence);
  return r;
}

class ArmourTest : public testing::Test {
 protected:
  Reason check(const Request& r) { return armour_.check(r).reason; }
  Armour armour_{lookup, 200, 60'000};
};

TEST_F(ArmourTest, LetsAGoodCommandThrough) { EXPECT_EQ(check(move(1, 0.5, 1)), Reason::none); }

TEST_F(ArmourTest, RefusesAnUnknownKind) {
  Request r = move(1);
  r.kind = 4711;
  EXPECT_EQ(check(r), Reason::unknown_command);
}

TEST_F(ArmourTest, RefusesNumbersThatAreNotFinite) {
  EXPECT_EQ(check(move(1, std::nan(""))), Reason::not_finite);
  EXPECT_EQ(check(move(1, std::numeric_limits<double>::infinity())), Reason::not_finite);
}

TEST_F(ArmourTest, SaysWhatItMeasuredAndWhatIsAllowed) {
  const Verdict v = armour_.check(move(1, 1.5));
  EXPECT_EQ(v.reason, Reason::out_of_range);
  EXPECT_EQ(v.measured, 1.5);
  EXPECT_EQ(v.limit, 1.0);
  EXPECT_EQ(v.subject, 1);
}

TEST_F(ArmourTest, RefusesAChoiceBetweenChoices) {
  EXPECT_EQ(check(move(1, 0, 0.5)), Reason::not_a_choice);
}

TEST_F(ArmourTest, RefusesParametersTheCommandDoesNotHave) {
  Request r = move(1);
  r.parameter[5] = 1;
  EXPECT_EQ(check(r), Reason::unused_parameter);
}

TEST_F(ArmourTest, RefusesStaleAndRepeatedSequenceNumbers) {
  EXPECT_EQ(check(move(5)), Reason::none);
  EXPECT_EQ(check(move(5)), Reason::stale_sequence);
  EXPECT_EQ(check(move(4)), Reason::stale_sequence);
  EXPECT_EQ(check(move(6)), Reason::none);
}

TEST_F(ArmourTest, KeepsSequencesOfSourcesApart) {
  EXPECT_EQ(check(move(5)), Reason::none);
  Request other = move(1);
  other.source = name("other");
  EXPECT_EQ(check(other), Reason::none);
}

TEST_F(ArmourTest, ARefusedCommandDoesNotUseUpItsNumber) {
  EXPECT_EQ(check(move(5, 99)), Reason::out_of_range);
  EXPECT_EQ(check(move(5)), Reason::none);
}

TEST_F(ArmourTest, RefusesSourcesWithoutANameOrAnEnd) {
  Request r = move(1);
  r.source = {};
  EXPECT_EQ(check(r), Reason::bad_source);
  r.source.fill('x');
  EXPECT_EQ(check(r), Reason::bad_source);
  r.source = name("bell\a");
  EXPECT_EQ(check(r), Reason::bad_source);
}

TEST_F(ArmourTest, RefusesLeasesOutOfBounds) {
  Request r = move(1);
  r.lease_ms = 10;
  EXPECT_EQ(check(r), Reason::bad_lease);
  r.lease_ms = 70'000;
  EXPECT_EQ(check(r), Reason::bad_lease);
}

TEST_F(ArmourTest, TakesAnEmergencyStopFromAnyoneHoweverBadlyItIsPut) {
  Request r{.kind = kStop.kind};
  r.source.fill('x');
  r.parameter.fill(std::nan(""));
  EXPECT_EQ(check(r), Reason::none);
  EXPECT_EQ(check(r), Reason::none);
}

TEST_F(ArmourTest, MakesRoomForNewSourcesOnlyWhenOldOnesAreSilent) {
  for (int i = 0; i < 32; ++i) {
    Request r = move(1);
    r.source = name("s" + std::to_string(i));
    r.arrival_ns = kSecond;
    ASSERT_EQ(check(r), Reason::none);
  }
  Request late = move(1);
  late.source = name("late");
  late.arrival_ns = 2 * kSecond;
  EXPECT_EQ(check(late), Reason::too_many_sources);
  late.arrival_ns = 20 * kSecond;
  EXPECT_EQ(check(late), Reason::none);
}

// [Env-2]
TEST_F(ArmourTest, WhateverComesInOnlySaneCommandsPass) {
  EXPECT_TRUE(rc::check([](const std::array<double, 8>& parameter, std::uint16_t kind,
                           std::uint64_t sequence, std::uint32_t lease,
                           const std::array<char, 32>& source) {
    Armour armour(lookup, 200, 60'000);
    Request r{.source = source,
              .sequence = sequence,
              .kind = static_cast<std::uint16_t>(kind % 9),
              .lease_ms = lease};
    r.parameter = parameter;
    if (armour.check(r).reason != Reason::none || r.kind != kMove.kind) return;
    RC_ASSERT(std::abs(r.parameter[0]) <= 1);
    RC_ASSERT(r.parameter[1] == 0 || r.parameter[1] == 1);
    for (std::size_t i = 2; i < 8; ++i) RC_ASSERT(r.parameter[i] == 0);
    RC_ASSERT(sequence > 0);
    RC_ASSERT(lease >= 200 && lease <= 60'000);
    RC_ASSERT(source.back() == '\0' && source.front() != '\0');
  }));
}

}  // namespace
}  // namespace lss
