#include "tools/lss-ground/places.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

namespace lss::ground {
namespace {

using std::chrono::milliseconds;
using std::chrono::minutes;
using std::chrono::seconds;

const Clock::time_point kStart{seconds(100)};
constexpr int kOurs = 1, kTheirs = 2;  // participants
constexpr int kMost = Places::kMost;

dds::Guid participant(int n) {
  return {static_cast<std::uint8_t>(n), static_cast<std::uint8_t>(n >> 8)};
}

// The use by the fleet.
struct List {
  Places places;
  std::set<std::string> ids;

  bool hear(const std::string& id, int origin, Clock::time_point now) {
    if (!ids.contains(id)) {
      const Places::Admission admission = places.admit(id, participant(origin), now);
      if (!admission.in) return false;
      ids.erase(admission.left);
      ids.insert(id);
    }
    places.heard(id, now);
    return true;
  }
  void forget(Clock::time_point now) {
    for (const std::string& id : places.forget(now)) ids.erase(id);
  }
};

std::string invented(int i) { return "ghost-" + std::to_string(i); }

TEST(Places, AVehicleKeepsItsPlaceWhileAThousandNamesASecondAreInvented) {
  List list;
  ASSERT_TRUE(list.hear("real", kOurs, kStart));
  int ghost = 0;
  for (int ms = 0; ms < 600'000; ms += ms < 20'000 ? 1 : 10) {
    const Clock::time_point now = kStart + milliseconds(ms);
    list.hear(invented(ghost++), kTheirs, now);
    // The link is bad: a message every 20 s only.
    if (ms % 20'000 == 0) {
      ASSERT_TRUE(list.hear("real", kOurs, now));
    }
    if (ms % 1000 == 0) list.forget(now);
    ASSERT_TRUE(list.ids.contains("real")) << ms;
    ASSERT_LE(list.ids.size(), Places::kMost);
  }
}

TEST(Places, AVehicleThatComesAfterTheInventedOnesFindsAPlaceAndTheNewestOfThemLeaves) {
  List list;
  for (int i = 0; i < 2 * kMost; ++i) list.hear(invented(i), kTheirs, kStart + milliseconds(i));
  EXPECT_TRUE(list.places.crowded(kStart + seconds(1)));
  ASSERT_TRUE(list.hear("real", kOurs, kStart + seconds(1)));
  EXPECT_EQ(list.ids.size(), Places::kMost);
  EXPECT_TRUE(list.ids.contains(invented(0)));
  EXPECT_FALSE(list.ids.contains(invented(kMost - 1))) << "the newest that had a place";
  // All of them speak on.
  for (int round = 0; round < 100; ++round) {
    for (int i = 0; i < 2 * kMost; ++i)
      list.hear(invented(i), kTheirs, kStart + seconds(2 + round));
    ASSERT_TRUE(list.ids.contains("real"));
  }
}

TEST(Places, OfManyThatInventOneNameEachTheSilentOnesLeaveAndNobodyWhoAnswered) {
  List list;
  ASSERT_TRUE(list.hear("real", kOurs, kStart));
  list.places.answered("real", kStart);
  int origin = 10;
  for (int ms = 0; ms < 60'000; ms += 100) {
    list.hear(invented(origin), origin, kStart + milliseconds(ms));
    ++origin;
    ASSERT_TRUE(list.ids.contains("real")) << "silent since the beginning";
  }
  // Another one comes: each of the list has sent within 3 s or is silent for longer.
  EXPECT_TRUE(list.hear("late", origin, kStart + seconds(64)));
  EXPECT_TRUE(list.ids.contains("real"));
}

TEST(Places, AVehicleThatStillSendsIsNotReplacedByAnotherOne) {
  List list;
  for (int i = 0; i < kMost; ++i) list.hear(invented(i), 10 + i, kStart);
  EXPECT_FALSE(list.hear("one more", kOurs, kStart + seconds(1)));
  EXPECT_TRUE(list.places.crowded(kStart + seconds(2)));
  EXPECT_FALSE(list.places.crowded(kStart + seconds(12)));
}

TEST(Places, WhatIsDrivenNeverLeaves) {
  List list{.places = Places([](const std::string& id) { return id == invented(kMost - 1); }),
            .ids = {}};
  for (int i = 0; i < kMost; ++i) list.hear(invented(i), kTheirs, kStart + milliseconds(i));
  list.hear("real", kOurs, kStart + seconds(1));
  EXPECT_TRUE(list.ids.contains(invented(kMost - 1)));
  list.forget(kStart + minutes(60));
  EXPECT_THAT(list.ids, testing::ElementsAre(invented(kMost - 1)));
}

TEST(Places, TheSilentLeaveAfterAWhileUnlessTheyAnswered) {
  List list;
  list.hear("looked at", 10, kStart);
  list.hear("commanded", 11, kStart);
  list.places.answered("commanded", kStart);
  list.forget(kStart + Places::kForget - milliseconds(1));
  EXPECT_THAT(list.ids, testing::ElementsAre("commanded", "looked at"));
  list.forget(kStart + Places::kForget);
  EXPECT_THAT(list.ids, testing::ElementsAre("commanded"));
  list.forget(kStart + Places::kRemember);
  EXPECT_THAT(list.ids, testing::IsEmpty());
}

}  // namespace
}  // namespace lss::ground
