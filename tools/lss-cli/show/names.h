#pragma once

// Finds the intended name. Pure functions.

#include <string>
#include <string_view>
#include <vector>

namespace lss::cli {

// The name nearest to `wrong`, or empty when none is near enough.
std::string nearest(std::string_view wrong, const std::vector<std::string>& names);

// "did you mean X?", or empty.
std::string did_you_mean(std::string_view wrong, const std::vector<std::string>& names);

}  // namespace lss::cli
