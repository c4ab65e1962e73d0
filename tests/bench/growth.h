#pragma once

// How cost grows with the number of something: samples in a frame, modules, subscribers, vehicles,
// minutes of a recording. Each count is measured in several rounds, in turn with the others where
// that is possible, so that a busy minute of the machine is seen by all of them.

#include <string>
#include <vector>

#include "tests/bench/bench.h"
#include "tests/bench/report.h"

namespace lss::bench {

struct Point {
  double count = 0;
  Samples cost{};  // of each round
};

struct Growth {
  std::string name;  // of its picture, too
  std::string what;  // is counted
  std::string cost, unit;
  std::vector<Point> points{};  // by rising count
  std::string note{};           // how it was measured; or why it was not
};

// A step from one count to the next. It is not worse than linear when one more costs no more than
// in the step before, and the step no more than if all of the cost grew with the count. The lowest
// and the highest round of both counts say how far each is to be trusted.
struct Step {
  double from = 0, to = 0;
  double each_more = kNone;                      // cost of one more, in the unit: of the medians
  double least_more = kNone, most_more = kNone;  // by the rounds
  double of_proportional = kNone;
  Met met = Met::undecided;
};
std::vector<Step> steps(const Growth& growth);

// `failed`: one could not be measured although this machine should be able to.
std::vector<Growth> growth(const Options& options, bool& failed);

std::string table(const std::vector<Growth>& all);
// `pictures`: where they are, from the document.
std::string markdown(const std::vector<Growth>& all, const Machine& machine,
                     const std::string& command, const std::string& pictures);
std::string picture(const Growth& growth);  // SVG

}  // namespace lss::bench
