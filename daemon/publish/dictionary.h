#pragma once

// What a daemon says of itself on lss/dictionary: commands with their parameters and where they are
// allowed, modes, faults, reasons, events, parameters and fields of the telemetry, so that clients
// need no tables of their own (docs/dds.md). Start-up, main thread.

#include <string>
#include <string_view>

#include "daemon/cycle/supervisor.h"
#include "daemon/cycle/text.h"

namespace lss {

// JSON. `telemetry_schema`: text of record::Schema of the telemetry.
std::string dictionary(const std::string& vehicle, const Logic& logic, const Vocabulary& vocabulary,
                       std::string_view telemetry_schema, std::string_view idl);

}  // namespace lss
