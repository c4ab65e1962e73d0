#pragma once

// The texts of lss.idl and NAME.idl, as they were compiled in, for those who pass types on with
// what they record. Pure data.

#include <string_view>

namespace lss {

// "lss" or the name of a vehicle; empty for what is not in this build.
std::string_view idl_text(std::string_view name);

}  // namespace lss
