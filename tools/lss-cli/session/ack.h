#pragma once

// An acknowledgement in words, for people and for programs. Pure functions.

#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "idl/codes.h"
#include "lss.h"

namespace lss::cli {

// `reasons`: of the vehicle.
using Reasons = std::span<const CodeInfo>;

// nullptr for a number that is not in the list.
const CodeInfo* reason_of(const lss_CommandAck& ack, Reasons reasons = kReasons);

// The daemon's sentence without the phase before it and the advice after it.
std::string reason_text(const lss_CommandAck& ack, Reasons reasons = kReasons);

// phase, reason (null: none), text, measured and limit (null: no number).
nlohmann::json ack_json(const lss_CommandAck& ack, Reasons reasons = kReasons);

}  // namespace lss::cli
