#pragma once

// Numbers as people write them, to and from SI: angles in degrees unless they say rad, times in
// seconds unless they say ms, min or h. Pure functions. Errors are a Failure with ExitCode::usage.

#include <cstdint>
#include <string>
#include <string_view>

namespace lss::cli {

// "30", "30deg", "0.5rad" to rad; "20", "20s", "500ms", "1.5min" to s; other units: a number, which
// may carry its unit. `what` names the value in the error text.
double parse_quantity(std::string_view text, std::string_view unit, std::string_view what);

// "1,3,5" to the bits 0, 2 and 4; all of them must be in `all`.
double parse_set(std::string_view text, std::uint64_t all, std::string_view what);
std::string format_set(std::uint64_t set);

// A duration in seconds, above zero.
double parse_duration_s(std::string_view text, std::string_view what);

// "30 deg", "20 s", "0.25 m".
std::string format_quantity(double value, std::string_view unit);

// "0.4 s", "12 s", "3 min 20 s", "2 h 5 min".
std::string format_duration(double seconds);

}  // namespace lss::cli
