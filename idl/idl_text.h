#pragma once

// The texts of lss.idl and NAME.idl as compiled in, for programs that record types with their
// samples. Pure data.

#include <string_view>

namespace lss {

// "lss" or the name of a vehicle; empty for one that is not in this build.
std::string_view idl_text(std::string_view name);

}  // namespace lss
