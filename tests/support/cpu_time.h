#pragma once

// CPU time of this thread, for tests of what something costs.

#include <ctime>

namespace lss::testing_support {

inline double cpu_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

// Of a call.
template <class Work>
double cpu_s_of(Work&& work) {
  const double before_s = cpu_s();
  work();
  return cpu_s() - before_s;
}

}  // namespace lss::testing_support
