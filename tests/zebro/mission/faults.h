#pragma once

// Faults at random times: lss-sim's own types, some temporary, some permanent. The same seed gives
// the same faults at the same times of operation.

#include <array>
#include <optional>
#include <random>
#include <string>
#include <vector>

namespace lss::zebro::mission {

struct FaultShape {
  const char* name;     // of lss-sim
  double weight;        // how often
  double from_s, to_s;  // how long it lasts; 0: it happens once, or ends by a reset
  double least, most;   // second argument; both 0: none
  int last_unit;        // 0: not of a module; 6: of a leg; 7: of any
  double for_good = 0;  // share of them that only a person ends
  bool lies = false;    // the leg is elsewhere than its module says, or does not follow
};

inline constexpr std::array<FaultShape, 16> kFaultShapes = {{
    {"module-reset", 3, 0, 0, 0, 0, 7},
    {"module-dead", 3, 0.1, 5, 0, 0, 7, 0.03},
    {"leg-stuck", 3, 1, 120, 0, 0, 6, 0.03},
    {"over-current", 3, 1, 120, 0.1, 0.9, 6},
    {"driver-fault", 3, 0, 0, 0, 0, 7},
    {"hall-lost", 1, 600, 20000, 0, 0, 6},
    {"encoder-frozen", 1, 1, 300, 0, 0, 6, 0.03, true},
    {"encoder-random", 1, 1, 300, 0, 0, 6, 0.03, true},
    {"encoder-jumps", 1, 1, 300, 10, 180, 6, 0.03, true},
    {"encoder-drifts", 1, 1, 300, 1, 30, 6, 0.03, true},
    {"gear-slips", 1, 10, 1000, 0.05, 0.9, 6, 0.03, true},
    {"leg-limp", 1, 1, 300, 0, 0, 6, 0.03, true},
    {"temperature", 1, 60, 1800, 60, 100, 6},
    {"noise", 2, 0.2, 20, 0.001, 0.05, 0},
    {"bus-cut", 1, 0.05, 3, 0, 0, 0},
    {"unplug", 1, 0.3, 3, 0, 0, 0},
}};

struct DueFault {
  std::size_t shape = 0;
  int unit = 0;
  std::string attach;  // as for Chain::inject
};

class Faults {
 public:
  // `mean_h`: hours of operation between two. `lying`: also those by which a leg lies.
  Faults(unsigned seed, double mean_h, bool lying);

  // At most one begins, by the time of operation, and lasts in the time of the day.
  std::optional<DueFault> begin(double operated_s, double now_s);
  // The commands that clear expired faults.
  std::vector<std::string> end(double now_s);
  // Active faults.
  std::vector<std::string> attached() const;
  // A person has repaired everything.
  void forget() { active_.clear(); }

 private:
  struct Active {
    std::string attach, clear;
    double until_s;
  };

  double uniform(double from, double to);

  std::mt19937 random_;
  double mean_s_, next_s_ = 0;
  bool lying_;
  std::vector<Active> active_;
};

}  // namespace lss::zebro::mission
