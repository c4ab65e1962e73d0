#pragma once

// The result of a fault campaign, as a line and as a document.

#include <map>
#include <string>
#include <vector>

#include "tests/campaign/campaign.h"

namespace lss::campaign {

struct Summary : Tally {
  explicit Summary(const Subject& of) : subject(of) {}

  Subject subject;
  unsigned runs = 0, broken = 0;
  double cpu_s = 0;
  std::map<std::string, unsigned> outcomes;  // of vehicles that can fall
  std::vector<std::string> complaints;       // "17: 3.2 s: ..."

  void add(const Run& run);
  void add(const Summary& other);  // of other scenarios of the same vehicle
  std::string line() const;
  // Of one processor; 0 where nothing was simulated.
  double times_real_time() const { return cpu_s > 0 ? simulated_s / cpu_s : 0; }
};

// `command`: that made it; `stamp`: when, and of which commit.
std::string document(const std::vector<Summary>& summaries, const std::string& command,
                     const std::string& stamp);

}  // namespace lss::campaign
