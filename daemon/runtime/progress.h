#pragma once

// Detects threads that stand still: each counts its turns, main checks. A stuck frame, bus or
// publisher thread is reported separately; only a stuck frame thread stops the feeding of the
// watchdog. Time is data.

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "drivers/time.h"

namespace lss {

struct Progress {
  std::string thread;
  std::uint64_t turns = 0;
  bool orders = true;  // of a bus: it takes orders to modules, not only measurements from them
};

class ProgressWatch {
 public:
  explicit ProgressWatch(TimeNs limit_ns) : limit_ns_(limit_ns) {}

  // Changes: {thread, how long it stood still}. A thread appears when it stood still for the limit,
  // and again, with stuck false, when it runs.
  struct Change {
    std::string thread;
    bool stuck = false;
    TimeNs still_ns = 0;
    bool orders = true;
  };
  std::vector<Change> look(const std::vector<Progress>& now_running, TimeNs now) {
    std::vector<Change> changes;
    known_.resize(now_running.size());
    for (std::size_t i = 0; i < now_running.size(); ++i) {
      Known& known = known_[i];
      if (known.since_ns == 0 || known.turns != now_running[i].turns) {
        if (std::exchange(known.stuck, false))
          changes.push_back(change(now_running[i], false, now - known.since_ns));
        known = {now_running[i].turns, now, false};
      } else if (!known.stuck && now - known.since_ns >= limit_ns_) {
        known.stuck = true;
        changes.push_back(change(now_running[i], true, now - known.since_ns));
      }
    }
    return changes;
  }
  // What is missing while the thread stands still.
  static const char* effect(const Change& change) {
    if (change.thread == "frame") return "the watchdog is not reset";
    if (change.thread == "publish") return "frames continue, without DDS output";
    if (change.thread == "log") return "frames before a fault are not saved";
    return change.orders ? "no orders reach the modules" : "it brings no measurements";
  }
  bool stuck(std::size_t i) const { return i < known_.size() && known_[i].stuck; }

 private:
  static Change change(const Progress& of, bool stuck, TimeNs still_ns) {
    return {.thread = of.thread, .stuck = stuck, .still_ns = still_ns, .orders = of.orders};
  }
  struct Known {
    std::uint64_t turns = 0;
    TimeNs since_ns = 0;
    bool stuck = false;
  };
  TimeNs limit_ns_;
  std::vector<Known> known_;
};

}  // namespace lss
