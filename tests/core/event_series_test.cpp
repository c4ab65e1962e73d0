#include "daemon/cycle/event_series.h"

#include <gtest/gtest.h>

#include <vector>

namespace lss {
namespace {

EventRecord event(TimeNs time_ns, EventId id, Severity severity = Severity::warning,
                  std::uint16_t subject = 0, double argument = 0) {
  return {.time_ns = time_ns,
          .severity = severity,
          .id = static_cast<std::uint16_t>(id),
          .subject = subject,
          .argument = {argument}};
}

class EventSeriesTest : public testing::Test {
 protected:
  void add(const EventRecord& e) {
    series_.add(e, [this](const EventRecord& r) { reports_.push_back(r); });
  }
  void pass(TimeNs now) {
    series_.report_due(now, [this](const EventRecord& r) { reports_.push_back(r); });
  }

  EventSeries series_;
  std::vector<EventRecord> reports_;
};

TEST_F(EventSeriesTest, TheFirstIsReportedAtOnceAndAFloodByItsCountAndTimes) {
  constexpr int kFlood = 60'000;  // a minute
  for (int i = 0; i < kFlood; ++i) {
    pass(i * kMillisecond);
    add(event(i * kMillisecond, EventId::frame_late, Severity::warning, 0, i));
    if (i == 0) {
      ASSERT_EQ(reports_.size(), 1u);
    }
  }
  EXPECT_LE(reports_.size(), 8u) << "after 1, 3, 7, 15, 31 s";
  pass(10 * 60 * kSecond);
  const EventRecord& last = reports_.back();
  EXPECT_EQ(last.count, kFlood);
  EXPECT_EQ(last.first_ns, 0);
  EXPECT_EQ(last.time_ns, (kFlood - 1) * kMillisecond);
  EXPECT_EQ(last.argument[0], kFlood - 1);
  EXPECT_EQ(reports_.front().count, 1u);
}

TEST_F(EventSeriesTest, AfterAMinuteWithoutItItIsAnotherSeries) {
  add(event(kSecond, EventId::frame_late));
  add(event(kSecond + EventSeries::kSeries - 1, EventId::frame_late));
  add(event(kSecond + 2 * EventSeries::kSeries - 1, EventId::frame_late));
  ASSERT_EQ(reports_.size(), 3u) << "the second is reported before it is forgotten";
  EXPECT_EQ(reports_[1].count, 2u);
  EXPECT_EQ(reports_[2].count, 1u);
  EXPECT_EQ(reports_[2].first_ns, kSecond + 2 * EventSeries::kSeries - 1);
}

TEST_F(EventSeriesTest, ASlowRepetitionIsReportedInTheNextFrame) {
  add(event(0, EventId::frame_late));
  pass(5 * kSecond);
  add(event(5 * kSecond, EventId::frame_late));
  pass(5 * kSecond + 1);
  ASSERT_EQ(reports_.size(), 2u);
  EXPECT_EQ(reports_[1].count, 2u);
}

TEST_F(EventSeriesTest, SubjectsRejectedCommandsAndCodesAreSeriesOfTheirOwn) {
  add(event(0, EventId::module_was_reset, Severity::warning, 1));
  add(event(0, EventId::module_was_reset, Severity::warning, 2));
  add(event(0, EventId::command_rejected, Severity::warning, 0, 1));
  add(event(0, EventId::command_rejected, Severity::warning, 0, 2));
  add(event(0, EventId::emergency_message, Severity::warning, 3, 0x8130));
  add(event(0, EventId::emergency_message, Severity::warning, 3, 0x2310));
  EXPECT_EQ(reports_.size(), 6u);
}

TEST_F(EventSeriesTest, StepsAndFatalFaultsAreReportedOneByOne) {
  for (int i = 0; i < 10; ++i) {
    add(event(i, EventId::state_changed, Severity::info));
    EventRecord fault = event(i, EventId::started, Severity::fatal, 3);
    fault.id = kFaultEventBase + 4;
    add(fault);
  }
  EXPECT_EQ(reports_.size(), 20u);
}

TEST_F(EventSeriesTest, OneSeriesTooManyReplacesTheOldestAndLosesNoCount) {
  std::uint32_t added = 0;
  for (int round = 0; round < 3; ++round) {
    for (std::uint16_t subject = 0; subject < 2 * EventSeries::kMost; ++subject, ++added)
      add(event(added, EventId::module_was_reset, Severity::warning, subject));
  }
  std::uint32_t counted = 0;
  for (const EventRecord& r : reports_) counted += r.count;
  EXPECT_EQ(counted, added);
}

TEST_F(EventSeriesTest, AtTheEndNothingIsUnreported) {
  add(event(0, EventId::frame_late));
  add(event(1, EventId::frame_late));
  for (int i = 0; i < 2; ++i)
    series_.report_all([this](const EventRecord& r) { reports_.push_back(r); });
  ASSERT_EQ(reports_.size(), 2u);
  EXPECT_EQ(reports_[1].count, 2u);
}

}  // namespace
}  // namespace lss
