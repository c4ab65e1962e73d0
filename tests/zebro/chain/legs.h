#pragma once

// Legs that fail, one or two, for tests of each: all that leave a gait.

#include <gtest/gtest.h>

#include <vector>

namespace lss::zebro {

struct Legs {
  const char* name;
  std::vector<int> legs;  // numbers of modules
};

inline auto one_or_two_legs() {
  return testing::Values(Legs{"LF", {1}}, Legs{"RF", {2}}, Legs{"LM", {3}}, Legs{"RM", {4}},
                         Legs{"LH", {5}}, Legs{"RH", {6}}, Legs{"LM_RM", {3, 4}},
                         Legs{"LF_RH", {1, 6}}, Legs{"RF_LH", {2, 5}}, Legs{"LF_LH", {1, 5}},
                         Legs{"RF_RH", {2, 6}}, Legs{"LF_RM", {1, 4}}, Legs{"RF_LM", {2, 3}},
                         Legs{"LM_RH", {3, 6}}, Legs{"RM_LH", {4, 5}});
}

inline std::string name_of_legs(const testing::TestParamInfo<Legs>& legs) {
  return legs.param.name;
}

}  // namespace lss::zebro
