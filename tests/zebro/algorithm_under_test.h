#pragma once

// LSS_ALGORITHM=table: the tests run with the other locomotion algorithm.

#include <cstdlib>
#include <string_view>

#include "gnc/zebro/schedule.h"

namespace lss::zebro {

inline gnc::zebro::Algorithm algorithm_under_test() {
  const char* name = std::getenv("LSS_ALGORITHM");
  return name != nullptr && std::string_view(name) == "table" ? gnc::zebro::Algorithm::table
                                                              : gnc::zebro::Algorithm::max_plus;
}

}  // namespace lss::zebro
