#pragma once

// Makes the dictionary of a vehicle from its parts. Start-up only.

#include <string>

#include "daemon/publish/dictionary.h"
#include "daemon/record/schema.h"

namespace lss {

template <class Telemetry>
std::string dictionary_of(const std::string& vehicle, const Logic& logic,
                          const Vocabulary& vocabulary) {
  record::Schema schema;
  const Telemetry telemetry{};
  fields(schema, telemetry);
  return dictionary(vehicle, logic, vocabulary, schema.text(), idl_of(telemetry));
}

}  // namespace lss
