#pragma once

// A vehicle declared: the entries of the rosters (daemon/app/roster.h, daemon/replay/records.h) out
// of what the vehicle is made of. Start-up only.

#include <memory>

#include "daemon/app/roster.h"
#include "daemon/app/runtime.h"
#include "daemon/replay/replay.h"

namespace lss::kit {

// `complete`: fills parameters that come from the rest of the configuration; nullptr: none.
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
