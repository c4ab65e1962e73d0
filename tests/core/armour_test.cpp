#include "daemon/cycle/armour.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <limits>
#include <string>

#include "tests/core/set_parameter.h"

namespace lss {
namespace {

constexpr const char* kColours[] = {"red", "green"};
constexpr ParameterInfo kParameters[] = {
    {"angle", "rad", -1, 1, 0, nullptr, ""},
    {"colour", "choice", 0, 1, 0, kColours, ""},
};
constexpr CommandInfo kMove{7, "move", Access::holder, true, "", kParameters};
constexpr CommandInfo kData{6, "data", Access::anyone, false, "", {}};

constexpr CommandInfo kSetIt = set_parameter_command(Access::anyone);
constexpr TunableInfo kTunables[] = {
    {"limits.current_A", "A", 0, 2, Change::always, false, "above it: emergency"},
    {"gait.flight_s", "s", 0, 2, Change::at_rest, false, "a leg in the air"}};

constexpr CommandInfo kArmourCommands[] = {kMove, kSetIt, kData};

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
  Reason check(const Request& r, std::uint64_t writer = 1, const Name& holder = {}) {
    return armour_.check(r, writer, holder).reason;
  }
  Armour armour_{kArmourCommands, kTunables, 200, 60'000};
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
  const Verdict v = armour_.check(move(1, 1.5), 1, {});
  EXPECT_EQ(v.reason, Reason::out_of_range);
  EXPECT_EQ(v.measured, 1.5);
  EXPECT_EQ(v.limit, 1.0);
  EXPECT_EQ(v.subject, 1);
}

TEST_F(ArmourTest, RefusesAChoiceBetweenChoices) {
  EXPECT_EQ(check(move(1, 0, 0.5)), Reason::not_a_choice);
}

Request set(std::string_view name) {
  Request r = move(1);
  r.kind = kSetIt.kind;
  name.copy(r.name.data(), r.name.size());
  return r;
}

TEST_F(ArmourTest, LetsTheNameOfAParameterThroughThatThereIs) {
  EXPECT_EQ(check(set("limits.current_A")), Reason::none);
  EXPECT_EQ(check(set("gait.flight_s")), Reason::none);
}

TEST_F(ArmourTest, RefusesANameOfNoParameter) {
  for (const char* name :
       {"limits.current", "limits.current_AA", "Limits.current_A", " ", "mobility.ratio_p"})
    EXPECT_EQ(check(set(name)), Reason::no_such_parameter) << name;
}

TEST_F(ArmourTest, RefusesANameThatIsEmptyNotTerminatedOrNotPrintable) {
  EXPECT_EQ(check(set("")), Reason::bad_name);
  EXPECT_EQ(check(set(std::string(kNameSize, 'x'))), Reason::bad_name);
  EXPECT_EQ(check(set("limits.current_A\n")), Reason::bad_name);
  EXPECT_EQ(check(set("limits.\xff")), Reason::bad_name);
  EXPECT_EQ(check(set(std::string(kNameSize - 1, 'x'))), Reason::no_such_parameter);
}

TEST_F(ArmourTest, RefusesANameThatIsNotTerminatedAlthoughItBeginsWithOneThatThereIs) {
  Request r = set("limits.current_A");
  r.name.back() = 'x';  // behind the terminator: garbage of the sender
  EXPECT_EQ(check(r), Reason::bad_name);
}

TEST_F(ArmourTest, RefusesANameThatTheCommandDoesNotHave) {
  Request r = move(1);
  r.name = set("limits.current_A").name;
  EXPECT_EQ(check(r), Reason::unused_name);
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

TEST_F(ArmourTest, KeepsSequencesOfWritersApartNotThoseOfNames) {
  EXPECT_EQ(check(move(5), 1), Reason::none);
  EXPECT_EQ(check(move(1), 2), Reason::none) << "the same name in another process";
  Request other = move(2);
  other.source = name("other");
  EXPECT_EQ(check(other, 1), Reason::stale_sequence) << "another name of the same writer";
}

TEST_F(ArmourTest, TheLargestNumberOfOneWriterLocksNobodyElseOut) {
  Request largest = move(1);
  largest.sequence = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(check(largest, 2), Reason::none);
  EXPECT_EQ(check(move(1), 1), Reason::none);
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

TEST_F(ArmourTest, WhatAnyoneMayAskTakesNoRoomAndUsesNoNumber) {
  const Request data{.source = name("test"), .sequence = 7, .kind = kData.kind};
  EXPECT_EQ(check(data), Reason::none);
  EXPECT_EQ(check(data), Reason::none);
  EXPECT_EQ(check(move(1)), Reason::none);
}

// A writer that lost its place may begin again with any number: rejection of an old one shows that
// it is remembered.
TEST_F(ArmourTest, ManyWritersPushOutTheOneThatWasSilentForLongest) {
  ASSERT_EQ(check(move(1000), 1), Reason::none);
  for (std::uint64_t writer = 2; writer <= 1'000'000; ++writer) {
    Request r = move(2000 + writer);
    ASSERT_EQ(check(r, writer), Reason::none) << "nobody is kept out";
  }
  EXPECT_EQ(check(move(999), 1), Reason::none) << "forgotten";
}

TEST_F(ArmourTest, ManyWritersDoNotPushOutTheHolderOfAuthority) {
  Request mine = move(1000);
  mine.source = name("pilot");
  ASSERT_EQ(check(mine, 1, name("pilot")), Reason::none);
  for (std::uint64_t writer = 2; writer <= 1000; ++writer)
    ASSERT_EQ(check(move(2000 + writer), writer, name("pilot")), Reason::none);
  EXPECT_EQ(check(mine, 1, name("pilot")), Reason::stale_sequence) << "still remembered";
}

// [Env-2]
TEST_F(ArmourTest, OnlyValidCommandsPass) {
  EXPECT_TRUE(rc::check([](const std::array<double, 8>& parameter, std::uint16_t kind,
                           std::uint64_t sequence, std::uint32_t lease,
                           const std::array<char, 32>& source) {
    Armour armour(kArmourCommands, kTunables, 200, 60'000);
    Request r{.source = source,
              .sequence = sequence,
              .kind = static_cast<std::uint16_t>(kind % 9),
              .lease_ms = lease};
    r.parameter = parameter;
    if (armour.check(r, 1, {}).reason != Reason::none || r.kind != kMove.kind) return;
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
