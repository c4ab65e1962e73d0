#pragma once

// Which of many similar cases run: a sample, a different one at each commit, or all of them with
// LSS_EVERYTHING=1.

#include <cstddef>
#include <cstdlib>

namespace lss::testing_support {

inline bool everything() { return std::getenv("LSS_EVERYTHING") != nullptr; }

// Whether the case of this number is in the sample of one in `of`. tools/test sets LSS_SAMPLE from
// the commit.
inline std::size_t sample_shift(std::size_t of) {
  const char* sample = std::getenv("LSS_SAMPLE");
  return sample == nullptr ? 0 : std::strtoul(sample, nullptr, 10) % of;
}

inline bool in_sample(std::size_t number, std::size_t of) {
  return everything() || (number + sample_shift(of)) % of == 0;
}

}  // namespace lss::testing_support

// For the begin of a TEST_P.
#define LSS_SKIP_OUTSIDE_SAMPLE(number, of)         \
  if (!lss::testing_support::in_sample(number, of)) \
  GTEST_SKIP() << "skipped: not in the sample of one in " << (of) << "; LSS_EVERYTHING=1 runs all"
