#pragma once

// The command to set a parameter, for tests with commands of their own.

#include "idl/commands.h"

namespace lss {

constexpr CommandInfo set_parameter_command(Access access) {
  return {.kind = 9,
          .name = "set-parameter",
          .access = access,
          .leased = false,
          .summary = "",
          .parameters = SetParameter::kParameters,
          .named = true};
}

}  // namespace lss
