#include <algorithm>

#include "tests/bench/growth.h"

namespace lss::bench {

std::vector<Step> steps(const Growth& growth) {
  std::vector<Step> all;
  for (std::size_t i = 1; i < growth.points.size(); ++i) {
    const Point &a = growth.points[i - 1], &b = growth.points[i];
    const double before = median(a.cost), after = median(b.cost);
    const auto spread = [](const Point& p) { return quantile(p.cost, 1) / quantile(p.cost, 0); };
    Step step{.from = a.count,
              .to = b.count,
              .each_more = (after - before) / (b.count - a.count),
              .of_linear = after / before * a.count / b.count,
              .noise = std::max(spread(a), spread(b))};
    const bool is = step.of_linear <= 1;
    const bool still = (is ? step.of_linear * step.noise : step.of_linear / step.noise) <= 1;
    if (is == still) step.met = is ? Met::yes : Met::no;
    all.push_back(step);
  }
  return all;
}

}  // namespace lss::bench
