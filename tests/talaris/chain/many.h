#pragma once

// Many runs of a campaign, and their statistics.

#include <algorithm>
#include <atomic>
#include <cmath>
#include <thread>
#include <vector>

#include "tests/support/everything.h"

namespace lss::talaris {

// run(seed) for seeds 1..count on two threads; each run is a world of its own. In order of seeds.
template <class Run>
auto runs(unsigned count, Run&& run) {
  using Result = decltype(run(1u));
  std::vector<Result> results(count);
  std::atomic<unsigned> next{1};
  const auto work = [&] {
    for (unsigned seed = next++; seed <= count; seed = next++) results[seed - 1] = run(seed);
  };
  std::thread second(work);
  work();
  second.join();
  return results;
}

// run(seed) for one in three of the seeds 1..count, others at each commit.
template <class Run>
auto sampled_runs(unsigned count, Run&& run) {
  if (testing_support::everything()) return runs(count, run);
  const auto first = static_cast<unsigned>(1 + testing_support::sample_shift(3));
  return runs(count / 3, [&](unsigned n) { return run(first + 3 * (n - 1)); });
}

// Of one figure of all runs.
class Figures {
 public:
  void add(double value) { values_.push_back(value); }
  double share(double below) const {  // quantile: 0 least, 0.5 median, 1 most
    if (values_.empty()) return 0;
    std::vector<double> sorted = values_;
    std::ranges::sort(sorted);
    const auto last = static_cast<double>(sorted.size() - 1);
    return sorted[static_cast<std::size_t>(std::lround(below * last))];
  }
  double most() const { return share(1); }
  double mean() const {
    double sum = 0;
    for (const double value : values_) sum += value;
    return values_.empty() ? 0 : sum / static_cast<double>(values_.size());
  }
  std::size_t size() const { return values_.size(); }

 private:
  std::vector<double> values_;
};

template <class Result, class Get>
Figures figures(const std::vector<Result>& results, Get&& get) {
  Figures all;
  for (const Result& result : results) all.add(get(result));
  return all;
}

template <class Result, class Is>
unsigned count(const std::vector<Result>& results, Is&& is) {
  return static_cast<unsigned>(std::ranges::count_if(results, is));
}

}  // namespace lss::talaris
