// An independent check of TALARIS' table, by a plain search: the events accepted in each mode, and
// those that end a flight; and that the explorer finds the mistakes that the table once had.

#include <gtest/gtest.h>

#include <array>
#include <functional>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <vector>

#include "daemon/vehicles/talaris/modes.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::talaris {
namespace {

using lc::ControllerState;
using lc::Happening;
using Names = std::set<std::string>;

const lc::Verified& vehicle() { return *lc::verified_vehicle("talaris"); }
lc::Model whole(const lc::Table& table = kTable) {
  return vehicle().model(table, vehicle().modules);
}

// Every state that can be reached.
std::vector<ControllerState> all_states() {
  const lc::Model m = whole();
  std::set<lc::Key> seen{lc::pack(m.begin)};
  std::vector<ControllerState> found{m.begin};
  for (std::size_t i = 0; i < found.size(); ++i) {
    for (const Happening h : m.happenings) {
      const ControllerState next = lc::step(kTable, found[i], h.event, h.subject).next;
      if (seen.insert(lc::pack(next)).second) found.push_back(next);
    }
  }
  return found;
}

// Events that do this in any of the states; those of each module once.
using Asked = std::function<bool(const ControllerState&, const lc::Result&)>;
Names events_that(const Asked& asked) {
  const lc::Model m = whole();
  Names names;
  for (const ControllerState& s : all_states()) {
    for (const Happening h : m.happenings) {
      const lc::Result r = lc::step(kTable, s, h.event, h.subject);
      if (r.row >= 0 && asked(s, r)) names.insert(lc::text(vehicle(), {h.event, 0}));
    }
  }
  return names;
}
Names taken_in(Mode mode) {
  return events_that([&](const ControllerState& s, const lc::Result&) {
    return s.state == State::operational && s.mode == static_cast<std::uint8_t>(mode);
  });
}
// Of commands only, without those that are taken always.
Names commands_in(Mode mode) {
  Names commands;
  const Names taken = taken_in(mode);
  for (const lc::EventInfo& e : kTable.events) {
    if (e.command && taken.count(e.name) != 0) commands.insert(e.name);
  }
  return commands;
}

TEST(TalarisExplored, ThePlainSearchFindsTheSameStates) {
  EXPECT_EQ(all_states().size(), lc::explore(whole()).states);
}

// All events that end a flight. The daemon does not pass on those with which it can still land: the
// silence of nodes, of the port and of the OBC, and a reset.
TEST(TalarisExplored, OnlyTouchingDownOrAnAllStopEndsAFlight) {
  const Names down = events_that([](const ControllerState& s, const lc::Result& r) {
    return airborne(s) && !airborne(r.next) && (r.actions & lc::kEmergencyStop) == 0;
  });
  EXPECT_EQ(down, Names{"flight over"});
  const Names all_stop = events_that([](const ControllerState& s, const lc::Result& r) {
    return airborne(s) && !airborne(r.next) && (r.actions & lc::kEmergencyStop) != 0;
  });
  EXPECT_EQ(all_stop, (Names{"estop", "fatal fault", "reset lc", "module silent", "port closed",
                             "OBC silent"}));
  const Names lands = events_that([](const ControllerState& s, const lc::Result& r) {
    return airborne(s) && airborne(r.next) && (r.actions & kLand) != 0;
  });
  EXPECT_EQ(lands, (Names{"land", "stop", "lease expired"}));
}

TEST(TalarisExplored, EachModeTakesItsOwnCommandsOnly) {
  const Names modes{"stop", "manual", "duty-cycle", "gnc standby"};
  const auto and_modes = [&](Names names) {
    names.insert(modes.begin(), modes.end());
    return names;
  };
  EXPECT_EQ(
      commands_in(Mode::manual),
      and_modes({"valve", "enable", "edf-arm start-up", "edf-arm done", "edf-throttle, edf-rpm",
                 "plan", "gains", "script-begin, script-step", "script-run"}));
  EXPECT_EQ(commands_in(Mode::duty_cycle),
            and_modes({"pulse", "enable", "edf-throttle, edf-rpm", "plan", "gains",
                       "script-begin, script-step", "script-run"}));
  EXPECT_EQ(commands_in(Mode::script), (Names{"stop", "script-abort"}));
  EXPECT_EQ(commands_in(Mode::standby),
            and_modes({"gnc calibrate", "gnc execute", "enable", "plan", "gains"}));
  EXPECT_EQ(commands_in(Mode::calibrate), and_modes({"plan"}));
  EXPECT_EQ(commands_in(Mode::execute), and_modes({"land"}));
}

// TALARIS thesis A.5.3: nothing is accepted until it is solved.
TEST(TalarisExplored, FatalErrorTakesNothingThatActs) {
  Names commands;
  for (const ControllerState& s : all_states()) {
    if (s.state != State::fatal_error) continue;
    for (const std::span<const lc::EventInfo> events : {lc::kCommonEvents, kTable.events}) {
      for (const lc::EventInfo& e : events) {
        if (e.command && lc::step(kTable, s, e.event).row >= 0) commands.insert(e.name);
      }
    }
  }
  EXPECT_EQ(commands, (Names{"estop", "solve", "reset lc", "reset module", "restore", "data",
                             "reset-timing"}));
}

// TALARIS thesis 4.5.1: the three steps in their order, which is the shortest way to a flight.
TEST(TalarisExplored, TheShortestWayToAFlightIsTheOrderOfTheThreeSteps) {
  lc::Model m = whole();
  static constexpr std::array kNever = {
      lc::StateProperty{"never in the air", "test",
                        [](const lc::Table&, const ControllerState& s) { return !airborne(s); }}};
  m.states = lc::state_properties<kNever>();
  const lc::Exploration e = lc::explore(m);
  ASSERT_TRUE(e.violation.has_value());
  std::vector<lc::Event> way;
  for (const Happening h : e.violation->trace) {
    const bool link = static_cast<std::uint8_t>(h.event) < lc::kVehicleEvents;
    if (!link && h.event != event::plan) way.push_back(h.event);
  }
  EXPECT_EQ(way, (std::vector{event::start, event::standby, event::calibrate, event::calibrated,
                              event::execute, event::lifted_off}));
}

// ---- mistakes

// The table with these rows changed.
class Changed {
 public:
  explicit Changed(const std::function<void(lc::Row&)>& change)
      : rows_(kTable.rows->rows.begin(), kTable.rows->rows.end()) {
    for (lc::Row& row : rows_) change(row);
    indexed_.emplace(rows_);
    table_.rows = &*indexed_;
  }
  Changed(const Changed&) = delete;
  Changed& operator=(const Changed&) = delete;
  std::string broken() const {
    const lc::Exploration e = lc::explore(whole(table_));
    return e.violation ? e.violation->property : "";
  }

 private:
  std::vector<lc::Row> rows_;
  std::optional<lc::Rows> indexed_;
  lc::Table table_ = kTable;
};

TEST(TalarisExplored, ATableThatIsNotChangedBreaksNothing) {
  EXPECT_EQ(Changed([](lc::Row&) {}).broken(), "");
}

// A measurement with an invalid IMU is no calibration.
TEST(TalarisExplored, ACalibrationWithALostImuIsNoticed) {
  const Changed table([](lc::Row& row) {
    if (row.event == event::calibrated) row.guards = 0;
  });
  EXPECT_EQ(table.broken(), "calibrated: taken when it must not be");
}

// The flight has no plan any more: executing it again would be an emergency.
TEST(TalarisExplored, APlanThatOutlivesItsRunIsNoticed) {
  for (const lc::Event left_by : {event::manual, event::duty_cycle, event::standby}) {
    const Changed table([&](lc::Row& row) {
      if (row.event == left_by) row.actions &= ~lc::ActionSet{kEndFlight};
    });
    EXPECT_EQ(table.broken(), "after a run it has to be calibrated and planned again");
  }
}

// Wider than any single change that `lss-lc mutate` makes.
TEST(TalarisExplored, RowsThatTakeTooMuchAreNoticed) {
  const auto everywhere = [](lc::Event event) {
    return Changed([event](lc::Row& row) {
      const bool in_modes = (row.from & lc::in(State::operational)) != 0;
      if (row.event == event && in_modes) row.modes = lc::kAnyMode;
    });
  };
  for (const lc::EventInfo& e : kTable.events) {
    const bool any_mode = e.event == event::start || e.event == event::fans_unarmed ||
                          e.event == event::imu_good || e.event == event::imu_lost ||
                          e.event == event::altimeter_good || e.event == event::altimeter_lost;
    EXPECT_EQ(everywhere(e.event).broken().empty(), any_mode) << e.name;
  }
}

}  // namespace
}  // namespace lss::talaris
