#pragma once

// What the tests of Ardito on soil have in common: their seeds, and their sections of docs/soil.md,
// which they write when LSS_WRITE_RESULTS is set.

#include <cstdlib>
#include <string>
#include <vector>

#include "tests/ardito/chain/chain.h"
#include "tests/ardito/chain/jobs.h"
#include "tests/support/everything.h"
#include "tests/support/section.h"
#include "tests/support/stamp.h"

namespace lss::ardito {

using sim::ardito::Ground;
using sim::soil::kEarth_m_s2;
using sim::soil::kMoon_m_s2;

inline bool writing() { return std::getenv("LSS_WRITE_RESULTS") != nullptr; }

inline constexpr unsigned kSeedsOfResults = 20;

// From the first on: 20, or LSS_RESULTS_SEEDS, for the document; in a test one of 20
// (tests/support/everything.h).
inline std::vector<unsigned> seeds_from(unsigned first) {
  const char* wanted = writing() ? std::getenv("LSS_RESULTS_SEEDS") : nullptr;
  const unsigned count =
      wanted == nullptr ? kSeedsOfResults : static_cast<unsigned>(std::atoi(wanted));
  std::vector<unsigned> seeds;
  for (unsigned n = 0; n < count; ++n) {
    if (writing() || testing_support::in_sample(n, kSeedsOfResults)) seeds.push_back(first + n);
  }
  return seeds;
}

// Limits of the detection of a single wheel that digs itself in were chosen with seeds below this.
inline constexpr unsigned kNewSeeds = 101;

inline void write(const std::string& title, const std::string& test, const std::string& text) {
  testing_support::write_section(
      LSS_DOCUMENT, title,
      "Measured " + testing_support::stamp(LSS_DOCUMENT) +
          " by\n`LSS_WRITE_RESULTS=1 ardito_soil_results_test --gtest_filter=" + test + "`.\n" +
          text);
}

}  // namespace lss::ardito
