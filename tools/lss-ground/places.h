#pragma once

// Selects which names on the domain have a place in a list of limited length. Any participant of
// the domain can invent any number of names; a real vehicle must keep its place, and find one when
// it comes later. So:
// - a name that a page drives, or that answered a command recently, never leaves;
// - when there is no place, the participant with the most places (`origin`: the publishing DDS
//   participant) gives up its newest one; no participant gives up its only place for the second
//   place of another;
// - only when each has one place, the name that is silent for the longest time leaves. Pure
//   functions of the given time.

#include <cstddef>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "idl/topics.h"
#include "tools/lss-ground/outbox.h"

namespace lss::ground {

class Places {
 public:
  static constexpr std::size_t kMost = 128;
  static constexpr Clock::duration kSilent =
      std::chrono::seconds(3);  // heartbeats come each second
  static constexpr Clock::duration kForget = std::chrono::minutes(5);  // a name that never answered
  static constexpr Clock::duration kRemember =
      std::chrono::minutes(10);  // a name that has answered
  static constexpr Clock::duration kTurnedAway = std::chrono::seconds(10);

  explicit Places(std::function<bool(const std::string&)> driven = {})
      : driven_(std::move(driven)) {}

  struct Admission {
    bool in = false;
    std::string left;  // the name that had to leave; empty: none
  };
  // A message under a name that has no place yet.
  Admission admit(const std::string& id, const dds::Guid& origin, Clock::time_point now);
  void heard(const std::string& id, Clock::time_point now);
  void answered(const std::string& id, Clock::time_point now);
  void leave(const std::string& id) { places_.erase(id); }
  // Removes the names that were silent for too long.
  std::vector<std::string> forget(Clock::time_point now);
  // Recently a name found no place.
  bool crowded(Clock::time_point now) const {
    return turned_away_ != Clock::time_point{} && now - turned_away_ < kTurnedAway;
  }

 private:
  struct Place {
    dds::Guid origin{};
    Clock::time_point since{}, heard{}, answered{};
  };
  bool stays(const std::string& id, const Place& place, Clock::time_point now) const;
  std::size_t held_by(const dds::Guid& origin) const;
  std::string victim(std::size_t asking, Clock::time_point now) const;

  std::function<bool(const std::string&)> driven_;
  std::map<std::string, Place> places_;
  Clock::time_point turned_away_{};
};

}  // namespace lss::ground
