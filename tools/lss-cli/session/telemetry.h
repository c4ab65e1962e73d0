#pragma once

// A sample of telemetry as JSON: all members that its IDL names, but the key. A vehicle adds names
// of what is numbered. Pure.

#include <nlohmann/json.hpp>

#include "daemon/record/json.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

// null for the age of what was never heard.
nlohmann::json with_null_for_never(nlohmann::json json);

template <class Sample>
nlohmann::json json_of(const Sample& sample) {
  return with_null_for_never(record::to_json(sample));
}

// Gives each part its name as a subject: that of `first` + its id.
void name_subjects(const Vehicle& vehicle, nlohmann::json& parts, std::uint16_t first = 0);

}  // namespace lss::cli
