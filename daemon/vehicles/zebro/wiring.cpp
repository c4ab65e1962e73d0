// The wiring of Lunar Zebro: the port "legs" has a bus of seven leg modules; the frame thread takes
// its replies and the actuate thread releases orders to it.

#include <fmt/format.h>

#include <filesystem>
#include <memory>

#include "daemon/app/roster.h"
#include "daemon/app/runtime.h"
#include "daemon/vehicles/zebro/record.h"
#include "daemon/vehicles/zebro/tunables.h"

namespace lss::zebro {
namespace {

const Vocabulary kVocabulary{.modes = kModeNames,
                             .modules = kModuleNames,
                             .strategies = kStrategyNames,
                             .commands = kCommands,
                             .tunables = tuning().infos,
                             .command = logic().command};

const config::Port& legs_port(const config::Config& config) {
  for (const config::Port& port : config.ports) {
    if (port.name == "legs") return port;
  }
  return config.ports.front();
}

// Parameters that the bus inherits from the port and the frame.
LegBusParameters bus_parameters(const config::Config& config, LegBusParameters bus) {
  const config::Port& port = legs_port(config);
  bus.baud = static_cast<int>(port.baud);
  bus.half_duplex = port.half_duplex;
  bus.period_ns = config.period_ns;
  return bus;
}

SerialSettings settings(const config::Config& config) {
  const config::Port& port = legs_port(config);
  return {.path = port.path, .baud = static_cast<int>(port.baud), .half_duplex = port.half_duplex};
}

}  // namespace

Buses::Buses(const config::Config& config, const Parameters& parameters)
    : name_("bus/" + legs_port(config).name),
      settings_(settings(config)),
      legs_(bus_parameters(config, parameters.bus), settings_) {}

tl::expected<void, std::string> Buses::probe() { return check_port(settings_, legs_.probe()); }

std::vector<std::pair<std::string, std::function<void()>>> Buses::bodies() {
  return {{name_, [this] { legs_.run(); }}};
}

void Buses::collect(Inputs<Vehicle>& in) noexcept {
  in.sample_count = 0;
  while (in.sample_count < in.samples.size() && legs_.pop(in.samples[in.sample_count], in.time_ns))
    ++in.sample_count;
  in.bus = legs_.report();
}

}  // namespace lss::zebro

namespace lss {

record::VehicleRecords zebro_records();

Port zebro_port() {
  return {.read = [](config::Section& section) -> Maker {
    const zebro::Parameters parameters = zebro::read_parameters(section);
    return [parameters](const config::Config& config) -> std::unique_ptr<App> {
      zebro::Parameters taken = parameters;
      const ParameterStart start = start_parameters(zebro::tuning(), config, taken);
      return std::make_unique<Runtime<zebro::Vehicle, zebro::Buses>>(
          config, taken, start, zebro::logic(), zebro::kVocabulary, zebro_records());
    };
  }};
}

}  // namespace lss
