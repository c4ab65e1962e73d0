// D.I.A.N.A. Ardito's wiring: one CAN bus.

#include "daemon/app/roster.h"
#include "daemon/app/runtime.h"
#include "daemon/vehicles/ardito/record.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "daemon/vehicles/ardito/vehicle.h"

namespace lss::ardito {
namespace {

const Vocabulary kVocabulary{.modes = kModeNames,
                             .modules = kNodeNames,
                             .strategies = kStrategyNames,
                             .commands = kCommands,
                             .tunables = tuning().infos,
                             .command = logic().command};

const config::Port& rover_port(const config::Config& config) {
  for (const config::Port& port : config.ports) {
    if (port.name == "rover") return port;
  }
  return config.ports.front();
}

constexpr auto kPeriod = static_cast<TimeNs>(gnc::ardito::kFrame_s * kSecond);

}  // namespace

Buses::Buses(const config::Config& config, const Parameters& parameters)
    : name_("bus/" + rover_port(config).name),
      path_(rover_port(config).path),
      period_ns_(config.period_ns),
      rover_(parameters.bus, path_, canopen::filters()) {}

tl::expected<void, std::string> Buses::probe() {
  if (period_ns_ != kPeriod)
    return tl::unexpected(
        fmt::format("[frame] period_ms is {}: the mobility controller is made for frames of 100 ms",
                    static_cast<double>(period_ns_) * 1e-6));
  return check_can(path_, rover_.probe());
}

std::vector<std::pair<std::string, std::function<void()>>> Buses::bodies() {
  return {{name_, [this] { rover_.run(); }}};
}

void Buses::collect(lss::Inputs<Vehicle>& in) noexcept {
  in.sample_count = 0;
  while (in.sample_count < in.samples.size() && rover_.pop(in.samples[in.sample_count], in.time_ns))
    ++in.sample_count;
  in.bus = rover_.report();
}

}  // namespace lss::ardito

namespace lss {

record::VehicleRecords ardito_records();

Port ardito_port() {
  return {.read = [](config::Section& section) -> Maker {
    const ardito::Parameters parameters = ardito::read_parameters(section);
    return [parameters](const config::Config& config) -> std::unique_ptr<App> {
      ardito::Parameters taken = parameters;
      const ParameterStart start = start_parameters(ardito::tuning(), config, taken);
      return std::make_unique<Runtime<ardito::Vehicle, ardito::Buses>>(
          config, taken, start, ardito::logic(), ardito::kVocabulary, ardito_records());
    };
  }};
}

}  // namespace lss
