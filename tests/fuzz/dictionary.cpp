// Dictionaries of daemons: JSON, and in it the IDL of the telemetry. Each describes a vehicle or is
// refused with a sentence.

#include "tests/fuzz/fuzz.h"
#include "tools/lss-cli/session/described_vehicle.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {

std::span<const Overlay* const> overlays() { return {}; }
std::vector<std::string> built_dictionaries() { return {}; }

namespace {

using Json = nlohmann::json;

void read(const std::string& text) {
  const DescribedVehicle described(text);
  const Vehicle& vehicle = described.vehicle();
  fuzz::must(!vehicle.name.empty(), "a vehicle has a name");
  lss_Status status{};
  for (const CommandInfo& info : vehicle.commands) {
    fuzz::must(info.name != nullptr && *info.name != '\0', "a command has a name");
    Invocation wanted{.info = &info};
    fuzz::must(info.parameters.size() <= wanted.parameter.size(), "a command has few parameters");
    for (std::size_t i = 0; i < info.parameters.size(); ++i)
      wanted.parameter[i] = info.parameters[i].min;
    if (vehicle.allowed) (void)vehicle.allowed(info);
    for (const lss_State state : {lss_STATE_IDLE, lss_STATE_OPERATIONAL}) {
      status.state = state;
      if (vehicle.prepare) (void)vehicle.prepare(status, wanted);
    }
    if (vehicle.ends) (void)vehicle.ends(wanted);
    if (vehicle.takes_s) (void)vehicle.takes_s(wanted);
  }
  alignas(8) static std::array<std::byte, 1'000'000> sample{};
  if (vehicle.telemetry == nullptr) return;
  fuzz::must(vehicle.telemetry->m_size <= sample.size(), "a sample has a bounded size");
  if (vehicle.json)
    (void)vehicle.json(sample.data()).dump(-1, ' ', false, Json::error_handler_t::replace);
  if (vehicle.screen) (void)vehicle.screen(sample.data(), Style{});
  if (vehicle.details) (void)vehicle.details(sample.data(), Style{});
  if (vehicle.progress) (void)vehicle.progress(sample.data());
  if (vehicle.distance_m) (void)vehicle.distance_m(sample.data());
  if (vehicle.problems) (void)vehicle.problems(status, sample.data());
}

}  // namespace
}  // namespace lss::cli

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    lss::cli::read(lss::fuzz::text_of({data, size}));
  } catch (const lss::cli::Failure& failure) {
    lss::fuzz::must(*failure.what() != '\0', "a refusal says why");
  }
  return 0;
}
