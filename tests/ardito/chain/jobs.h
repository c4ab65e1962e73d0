#pragma once

// Many runs of the chain at once, for tests that measure.

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <functional>
#include <thread>
#include <vector>

namespace lss::ardito {

// Runs are independent of each other: jobs 0 to count-1 on as many threads as there are processors,
// or LSS_RESULTS_THREADS. Results do not depend on their number.
inline void for_each_job(std::size_t count, const std::function<void(std::size_t)>& job) {
  const char* text = std::getenv("LSS_RESULTS_THREADS");
  const unsigned most = text == nullptr ? std::thread::hardware_concurrency()
                                        : static_cast<unsigned>(std::atoi(text));
  std::atomic<std::size_t> next = 0;
  std::vector<std::jthread> threads;
  for (unsigned n = 0; n < std::max(most, 1u); ++n) {
    threads.emplace_back([&] {
      for (std::size_t i = next++; i < count; i = next++) job(i);
    });
  }
}

}  // namespace lss::ardito
