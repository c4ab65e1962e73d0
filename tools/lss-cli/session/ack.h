#pragma once

// An acknowledgement in words, for people and for programs. Pure functions.

#include <nlohmann/json.hpp>
#include <string>

#include "idl/codes.h"
#include "lss.h"

namespace lss::cli {

// `own`: the codes of the vehicle. The daemon's sentence without the phase before it and the advice
// after it.
std::string reason_text(const lss_CommandAck& ack, const OwnCodes& own = {});

// phase, reason (null: none), text, measured and limit (null: no number).
nlohmann::json ack_json(const lss_CommandAck& ack, const OwnCodes& own = {});

}  // namespace lss::cli
