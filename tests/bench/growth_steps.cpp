#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/bench/growth.h"

namespace lss::bench {
namespace {

// `before`: the step before, if any. A cost that falls less than before does not rise.
Met judged(const Step& step, const Step* before, double least_of_proportional,
           double most_of_proportional) {
  const double most_before =
      before ? std::max(before->most_more, 0.0) : std::numeric_limits<double>::infinity();
  const bool worse = least_of_proportional > 1 || step.least_more > most_before;
  const bool rises = step.each_more > most_before;
  if (worse) return Met::no;
  return step.of_proportional > 1 || most_of_proportional > 1 || rises ? Met::undecided : Met::yes;
}

}  // namespace

std::vector<Step> steps(const Growth& growth) {
  std::vector<Step> all;
  for (std::size_t i = 1; i < growth.points.size(); ++i) {
    const Point &a = growth.points[i - 1], &b = growth.points[i];
    const auto least = [](const Point& p) { return quantile(p.cost, 0); };
    const auto most = [](const Point& p) { return quantile(p.cost, 1); };
    const double more = b.count - a.count, share = a.count / b.count;
    Step step{.from = a.count,
              .to = b.count,
              .each_more = (median(b.cost) - median(a.cost)) / more,
              .least_more = (least(b) - most(a)) / more,
              .most_more = (most(b) - least(a)) / more,
              .of_proportional = median(b.cost) / median(a.cost) * share};
    const double low = least(b) / most(a) * share, high = most(b) / least(a) * share;
    if (least(a) > 0 && std::isfinite(high))
      step.met = judged(step, all.empty() ? nullptr : &all.back(), low, high);
    all.push_back(step);
  }
  return all;
}

}  // namespace lss::bench
