#pragma once

// What the subject of a refused command is the number of, by its reason. Pure data.

#include <cstdint>

#include "idl/codes.h"

namespace lss {

enum class SubjectIs : std::uint8_t { module, argument, tunable, step };

constexpr SubjectIs subject_is(Reason reason) noexcept {
  switch (reason) {
    case Reason::not_finite:
    case Reason::out_of_range:
    case Reason::not_a_choice:
    case Reason::unused_parameter: return SubjectIs::argument;
    case Reason::parameter_range:
    case Reason::parameter_whole:
    case Reason::parameter_together: return SubjectIs::tunable;
    case Reason::script_overlap:
    case Reason::script_backwards:
    case Reason::script_too_long:
    case Reason::script_actuator:
    case Reason::script_value:
    case Reason::script_other:
    case Reason::script_order: return SubjectIs::step;
    default: return SubjectIs::module;
  }
}

}  // namespace lss
