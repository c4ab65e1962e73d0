#pragma once

// How many times this test program allocated with operator new so far, on any thread. Link
// lss_allocations, which replaces the operators.

#include <cstdint>

namespace lss::testing_support {
std::uint64_t allocations() noexcept;
}
