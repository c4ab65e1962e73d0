#pragma once

// A sample of telemetry as JSON: all members that its IDL names, but the key. Pure.

#include <nlohmann/json.hpp>
#include <utility>

#include "daemon/record/json.h"
#include "idl/commands.h"

namespace lss::cli {

// null for the age of what was never heard.
template <class Json = nlohmann::json>
Json with_null_for_never(Json json) {
  if (json.is_object() && json.contains("age_ms") && json["age_ms"] == kNeverHeard_ms)
    json["age_ms"] = nullptr;
  for (Json& part : json) {
    if (part.is_structured()) part = with_null_for_never(std::move(part));
  }
  return json;
}

template <class Sample>
nlohmann::json json_of(const Sample& sample) {
  return with_null_for_never(record::to_json(sample));
}

}  // namespace lss::cli
