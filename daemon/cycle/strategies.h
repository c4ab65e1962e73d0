#pragma once

// Runs the strategies of error solving one after the other, each within its budget, until nothing
// has been wrong for a while. Shared by all vehicles. Frame thread; time is data; no allocation.

#include <array>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "daemon/cycle/controller.h"

namespace lss {

enum class Treatment : std::uint8_t {
  running,  // is called again in the next frame
  done,     // its effect shows in the next frames
  failed,   // the next strategy
};

// Of a fault, by a table of a vehicle.
template <class Class, std::size_t kFaults>
constexpr Class class_in(const std::pair<FaultId, Class> (&table)[kFaults], FaultId fault,
                         Class otherwise) noexcept {
  for (const auto& [id, of] : table) {
    if (id == fault) return of;
  }
  return otherwise;
}

// Kind{} is none and ends a list.
template <class Kind>
class Strategies {
 public:
  using List = std::array<Kind, lc::kMaxStrategies>;
  enum class Report : std::uint8_t { running, next, solved, unsolved };

  // The first one begins with the next step.
  void begin(const List& list) noexcept {
    list_ = list;
    at_ = 0;
    running_ = true;
    begun_ = false;
  }
  void end() noexcept { running_ = false; }
  bool running() const noexcept { return running_; }
  Kind kind() const noexcept { return list_[at_]; }

  // Once per frame while running. `healthy`: no fault at all in this frame. begin_one(): the
  // strategy kind() begins; returns its budget. treat(): one frame of it. next: it did not help;
  // call again when the locomotion controller agreed to the next one.
  template <class BeginOne, class Treat>
  Report step(TimeNs now, bool healthy, BeginOne&& begin_one, Treat&& treat) noexcept {
    if (!begun_) {
      begun_ = treating_ = true;
      healthy_since_ns_ = 0;
      until_ns_ = now + begin_one();
    }
    if (now > until_ns_) return give_up();
    if (treating_) {
      const Treatment treatment = treat();
      if (treatment == Treatment::failed) return give_up();
      treating_ = treatment == Treatment::running;
      return Report::running;
    }
    if (!healthy) {
      healthy_since_ns_ = 0;
    } else if (healthy_since_ns_ == 0) {
      healthy_since_ns_ = now;
    } else if (now - healthy_since_ns_ >= kProof) {
      return Report::solved;
    }
    return Report::running;
  }

 private:
  static constexpr TimeNs kProof = kSecond;

  Report give_up() noexcept {
    if (at_ + 1 == list_.size() || list_[at_ + 1] == Kind{}) return Report::unsolved;
    ++at_;
    begun_ = false;
    return Report::next;
  }

  List list_{};
  std::size_t at_ = 0;
  bool running_ = false;
  bool begun_ = false;     // the strategy at at_
  bool treating_ = false;  // then it waits until nothing is wrong
  TimeNs until_ns_ = 0;
  TimeNs healthy_since_ns_ = 0;  // 0: it is not
};

}  // namespace lss
