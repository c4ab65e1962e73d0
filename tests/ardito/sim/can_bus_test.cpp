#include "tools/lss-sim/frame/can_bus.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <deque>

#include "tests/support/can_script.h"
#include "tools/lss-sim/ardito/vehicle.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss::sim {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Answers each SYNC with two frames, the higher identifier first.
class Echo final : public CanDevice {
 public:
  void receive(const CanFrame& received) override {
    heard.push_back(text(received));
    if (received.id != 0x080) return;
    waiting.push_back(frame("281 [8] 00 00 00 00 00 00 00 00"));
    waiting.push_back(frame("181 [2] AA 55"));
  }
  std::optional<CanFrame> send() override {
    if (waiting.empty()) return std::nullopt;
    const CanFrame next = waiting.front();
    waiting.pop_front();
    return next;
  }
  bool wants_to_send() const override { return !waiting.empty(); }

  std::vector<std::string> heard;
  std::deque<CanFrame> waiting;
};

class Bus : public testing::Test {
 protected:
  // Frames received by the master until then, stepping from wake to wake.
  std::vector<std::string> until(TimeNs end) {
    std::vector<std::string> received;
    for (TimeNs now = bus_.next_wake(); now <= end; now = bus_.next_wake()) {
      bus_.advance(now);
      for (const CanFrame& each : bus_.take(now)) received.push_back(text(each));
    }
    return received;
  }
  void send(const char* frame_text, TimeNs now) {
    bus_.from_master(frame(frame_text), now);
    bus_.advance(now);
  }
  Fault parse(const char* fault_text) { return parse_fault(fault_text, can_fault_kinds()).value(); }

  Echo nodes_;
  CanBus bus_{{.paced = true}, nodes_};
  TimeNs bus_now_ = 0;
};

TEST(CanBits, AFrameTakesItsBitsAndThoseThatAreStuffed) {
  // Counted apart from this program, the checksum by division of the whole string of bits.
  EXPECT_EQ(bits_on_wire(frame("555 [0]")), 48);
  EXPECT_EQ(bits_on_wire(frame("080 [0]")), 51);
  EXPECT_EQ(bits_on_wire(frame("701 [1] 05")), 58);
  EXPECT_EQ(bits_on_wire(frame("000 [8] 00 00 00 00 00 00 00 00")), 127);
  EXPECT_EQ(bits_on_wire(frame("7FF [8] FF FF FF FF FF FF FF FF")), 126);
  EXPECT_EQ(bits_on_wire(frame("181 [8] 37 02 37 06 00 00 78 00")), 120);
}

TEST_F(Bus, FramesTakeTheirTimeAndTheLowestIdentifierGoesFirst) {
  send("080 [0]", 0);
  const TimeNs sync_ns = bits_on_wire(frame("080 [0]")) * 2 * kMicrosecond;
  const TimeNs short_ns = bits_on_wire(frame("181 [2] AA 55")) * 2 * kMicrosecond;
  EXPECT_THAT(until(sync_ns + short_ns - 1), IsEmpty());
  EXPECT_THAT(until(sync_ns + short_ns), ElementsAre("181 [2] AA 55"));
  EXPECT_THAT(until(kMillisecond), ElementsAre("281 [8] 00 00 00 00 00 00 00 00"));
}

TEST_F(Bus, AFrameUnderWayIsNotInterruptedAndTheMastersQueueKeepsItsOrder) {
  nodes_.waiting.push_back(frame("700 [8] 00 00 00 00 00 00 00 00"));
  bus_.advance(0);
  send("205 [1] 01", 10 * kMicrosecond);
  send("000 [2] 01 00", 10 * kMicrosecond);
  nodes_.waiting.push_back(frame("201 [1] 02"));
  bus_.advance(20 * kMicrosecond);
  EXPECT_THAT(until(2 * kMillisecond),
              ElementsAre("700 [8] 00 00 00 00 00 00 00 00", "201 [1] 02"));
  EXPECT_THAT(nodes_.heard, ElementsAre("205 [1] 01", "000 [2] 01 00"));
}

TEST_F(Bus, WithoutPaceEverythingArrivesAtOnce) {
  CanBus bus({.paced = false}, nodes_);
  bus.from_master(frame("080 [0]"), 5);
  bus.advance(5);
  EXPECT_EQ(bus.take(5).size(), 2u);
}

TEST_F(Bus, ACutBusPassesNothingAndAWholeOneEverything) {
  bus_.faults.set(parse("bus-cut"), true);
  send("080 [0]", 0);
  EXPECT_THAT(until(kMillisecond), IsEmpty());
  EXPECT_THAT(nodes_.heard, IsEmpty());
  bus_.faults.set(parse("bus-cut"), false);
  send("080 [0]", kMillisecond);
  EXPECT_EQ(until(3 * kMillisecond).size(), 2u);
}

TEST_F(Bus, FramesAreLostWrongDoubledAndLateAsOftenAsItSays) {
  const auto received = [&](const char* fault) {
    bus_.faults = {};
    bus_.faults.set(parse(fault), true);
    std::vector<std::string> all;
    for (int i = 0; i < 500; ++i) {
      nodes_.waiting.push_back(frame("181 [2] AA 55"));
      bus_.advance(bus_now_);
      const auto some = until(bus_now_ += kMillisecond);
      all.insert(all.end(), some.begin(), some.end());
    }
    return all;
  };
  EXPECT_NEAR(static_cast<double>(received("drop:0.2").size()), 400, 40);
  EXPECT_NEAR(static_cast<double>(received("duplicate:0.2").size()), 600, 40);
  const auto noisy = received("noise:0.2");
  EXPECT_EQ(noisy.size(), 500u);
  EXPECT_NEAR(static_cast<double>(std::ranges::count(noisy, "181 [2] AA 55")), 400, 40);
}

TEST_F(Bus, LateFramesComeLaterAndInTheirOrder) {
  bus_.faults.set(parse("late:50"), true);
  send("080 [0]", 0);
  EXPECT_THAT(until(50 * kMillisecond), IsEmpty());
  EXPECT_EQ(until(51 * kMillisecond).size(), 2u);
}

TEST_F(Bus, BusOffIsReportedAndSoIsItsEnd) {
  bus_.bus_off(0, 100 * kMillisecond);
  const auto report = bus_.take(0);
  ASSERT_EQ(report.size(), 1u);
  EXPECT_TRUE(report[0].error);
  EXPECT_EQ(report[0].id, 0x40u);
  send("080 [0]", kMillisecond);
  EXPECT_TRUE(bus_.is_off());
  EXPECT_THAT(until(99 * kMillisecond), IsEmpty());
  EXPECT_THAT(until(101 * kMillisecond), ElementsAre("100 [8] 00 00 00 00 00 00 00 00"));
  EXPECT_FALSE(bus_.is_off());
}

class ArditoFaults : public testing::Test {
 protected:
  std::unique_ptr<VehicleKind> vehicle_ = make_ardito_kind();
  std::vector<FaultKind> kinds_ = fault_kinds_of(*vehicle_);
};

TEST_F(ArditoFaults, NodesAreWrittenInHexadecimalAndReadEitherWay) {
  EXPECT_THAT(parse_fault("node-silent:0x11", kinds_)->values, ElementsAre(0x11));
  EXPECT_THAT(parse_fault("node-silent:17", kinds_)->values, ElementsAre(0x11));
  EXPECT_EQ(to_text(*parse_fault("node-silent:17", kinds_)), "node-silent:0x11");
  EXPECT_THAT(parse_fault("emcy:0x01:0x8130", kinds_)->values, ElementsAre(1, 0x8130));
}

TEST_F(ArditoFaults, WhatIsNotThereCannotBreak) {
  for (const auto& [text, said] : {std::pair{"node-silent:0x13", "one of 0x01, 0x02"},
                                   {"SM:3", "one of 1, 2, 5, 6"},
                                   {"TM:7", "from 1 to 6"},
                                   {"node-silent:0x", "must be"},
                                   {"TX:1", "unknown fault"}}) {
    const auto fault = parse_fault(text, kinds_);
    ASSERT_FALSE(fault) << text;
    EXPECT_THAT(fault.error(), testing::HasSubstr(said));
  }
}

TEST_F(ArditoFaults, EveryKindReadsBackWhatItWrites) {
  for (const FaultKind& kind : kinds_) {
    Fault fault{.kind = &kind, .values = {}, .clear = false};
    for (const FaultArgument& argument : kind.arguments) {
      fault.values.push_back(argument.choices.empty() ? argument.max : argument.choices.back());
    }
    const auto again = parse_fault(to_text(fault), kinds_);
    ASSERT_TRUE(again) << again.error();
    EXPECT_EQ(again->values, fault.values);
  }
}

TEST_F(ArditoFaults, TwoValuesOfOneNodeBreakEachOnItsOwn) {
  std::vector<std::string> acts;
  FaultBoard board([&](const Fault& fault,
                       bool attach) { acts.push_back((attach ? "+" : "-") + to_text(fault)); },
                   [](const Fault&) { return true; });
  for (const char* each : {"stuck:0x01:1", "stuck:0x01:2", "stuck:0x02:1", "clear:stuck:0x01:2"}) {
    board.inject(*parse_fault(each, kinds_));
  }
  EXPECT_THAT(board.attached(), ElementsAre("stuck:0x01:1", "stuck:0x02:1"));
  board.inject(*parse_fault("clear:stuck:0x01", kinds_));
  EXPECT_THAT(board.attached(), ElementsAre("stuck:0x02:1"));
}

}  // namespace
}  // namespace lss::sim
