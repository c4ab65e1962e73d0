#pragma once

// Reject reasons of D.I.A.N.A. Ardito itself, numbered from kFirstOwnCode on (idl/codes.h). Pure
// data.

#include "idl/codes.h"

namespace lss::ardito {

inline constexpr Reason kOverHeading{500};

inline constexpr CodeInfo kOwnReasons[] = {
    {500, "over_heading", 1, "heading beyond the limit of the parameters: rad",
     "steer less, or at rest: lss-cli param set mobility.heading_limit_deg DEGREES"},
};

inline constexpr OwnCodes kOwnCodes{.reasons = kOwnReasons};

}  // namespace lss::ardito
