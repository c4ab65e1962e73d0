#pragma once

// Which of the names that were heard on the domain have a place in a list of limited length. Anyone
// on the domain can invent names, as many and as often as he likes; what is really there must keep
// its place, and find one when it comes later. So:
// - a name that a page drives, or that answered a command lately, never leaves;
// - when there is no place, he who has taken the most gives one up (`origin`: the DDS participant
//   that speaks), the newest of his; nobody gives up his only place for the second one of another;
// - only where each has one place does the name leave that is silent for longest.
// Pure functions of the time that they are given.

#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/lss-ground/outbox.h"

namespace lss::ground {

class Places {
 public:
  static constexpr std::size_t kMost = 32;
  static constexpr Clock::duration kSilent = std::chrono::seconds(3);  // status comes each second
  static constexpr Clock::duration kForget = std::chrono::minutes(5);  // what never answered
  static constexpr Clock::duration kRemember = std::chrono::minutes(10);  // what did
  static constexpr Clock::duration kTurnedAway = std::chrono::seconds(10);

  explicit Places(std::function<bool(const std::string&)> driven = {})
      : driven_(std::move(driven)) {}

  struct Admission {
    bool in = false;
    std::string left;  // who had to leave for it; empty: nobody
  };
  // A name that has no place yet was heard.
  Admission admit(const std::string& id, std::uint64_t origin, Clock::time_point now);
  void heard(const std::string& id, Clock::time_point now);
  void answered(const std::string& id, Clock::time_point now);
  void leave(const std::string& id) { places_.erase(id); }
  // Silent for so long that they left now.
  std::vector<std::string> forget(Clock::time_point now);
  // Lately there was no place for somebody.
  bool crowded(Clock::time_point now) const {
    return turned_away_ != Clock::time_point{} && now - turned_away_ < kTurnedAway;
  }

 private:
  struct Place {
    std::uint64_t origin = 0;
    Clock::time_point since{}, heard{}, answered{};
  };
  bool stays(const std::string& id, const Place& place, Clock::time_point now) const;
  std::size_t held_by(std::uint64_t origin) const;
  std::string victim(std::size_t asking, Clock::time_point now) const;

  std::function<bool(const std::string&)> driven_;
  std::map<std::string, Place> places_;
  Clock::time_point turned_away_{};
};

}  // namespace lss::ground
