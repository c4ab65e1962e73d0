#pragma once

// Whether also those cases run that take minutes and differ little from others: LSS_EVERYTHING=1.

#include <cstdlib>

namespace lss::testing_support {

inline bool everything() { return std::getenv("LSS_EVERYTHING") != nullptr; }

}  // namespace lss::testing_support
