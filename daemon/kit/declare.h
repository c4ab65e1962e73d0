#pragma once

// Makes the entry of a vehicle in the roster (daemon/app/roster.h) from the vehicle's parts.
// Start-up only.

#include <memory>

#include "daemon/app/roster.h"
#include "daemon/app/runtime.h"
#include "daemon/replay/replay.h"

namespace lss::kit {

// `complete` fills in parameters that are outside the vehicle's table of the configuration;
// nullptr: there are none.
template <class Vehicle, class Buses, class Parameters>
Port port(Parameters (*read)(config::Section&), const Tuning<Parameters>& tuning,
          const Logic& logic, const Vocabulary& vocabulary, record::VehicleRecords (*records)(),
          Parameters (*complete)(Parameters, const config::Config&) = nullptr) {
  return {.read = [=, &tuning, &logic, &vocabulary](config::Section& section) -> Maker {
    return [=, &tuning, &logic, &vocabulary,
            parameters = read(section)](const config::Config& config) -> std::unique_ptr<App> {
      own_codes = logic.codes;
      Parameters taken = complete != nullptr ? complete(parameters, config) : parameters;
      const ParameterStart start = start_parameters(tuning, config, taken);
      return std::make_unique<Runtime<Vehicle, Buses>>(config, taken, start, logic, vocabulary,
                                                       records());
    };
  }};
}

}  // namespace lss::kit
