#include <algorithm>

#include "tests/bench/growth.h"

namespace lss::bench {
namespace {

// The step after one of that slope; without one the first.
Met judged(const Step& step, const Step* before, double least_of_proportional,
           double most_of_proportional) {
  const bool worse = least_of_proportional > 1 || (before && step.least_more > before->most_more);
  const bool rises = before && step.each_more > before->most_more;
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
