#include "tools/lss-cli/session/vehicle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "tools/lss-cli/session/described_vehicle.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::cli {

std::span<const Vehicle* const> vehicles() {
  static const std::vector<std::unique_ptr<const DescribedVehicle>> all = [] {
    std::vector<std::unique_ptr<const DescribedVehicle>> described;
    for (const std::string& dictionary : built_dictionaries())
      described.push_back(std::make_unique<const DescribedVehicle>(dictionary));
    return described;
  }();
  static const std::vector<const Vehicle*> list = [] {
    std::vector<const Vehicle*> pointers;
    for (const auto& one : all) pointers.push_back(&one->vehicle());
    return pointers;
  }();
  return list;
}

const Vehicle* find_vehicle(std::string_view name) {
  for (const Vehicle* vehicle : vehicles()) {
    if (vehicle->name == name) return vehicle;
  }
  return nullptr;
}

OwnCodes codes_of(std::string_view vehicle) {
  const Vehicle* known = find_vehicle(vehicle);
  return known != nullptr ? known->codes : OwnCodes{};
}

bool is_endless(const Vehicle& vehicle, const Invocation& command) {
  return command.info->endless && !vehicle.ends(command);
}

bool is_composed(const Vehicle& vehicle, std::string_view command) {
  return vehicle.overlay != nullptr &&
         std::ranges::find(vehicle.overlay->composed, command) != vehicle.overlay->composed.end();
}

std::string subject_name(const Vehicle& vehicle, std::uint16_t subject) {
  if (subject == 0) return "";
  if (subject <= vehicle.subjects.size()) return vehicle.subjects[subject - 1u];
  return fmt::format("module {}", subject);
}

std::string progress(const Vehicle& vehicle, const lss_Status& status, const void* telemetry) {
  std::string words(status.state == lss_STATE_OPERATIONAL ? text(status.mode_name)
                                                          : vehicle.at_rest);
  return telemetry != nullptr && vehicle.progress ? words + vehicle.progress(telemetry) : words;
}

std::string screen(const Vehicle& vehicle, const void* telemetry, const Style& style) {
  return telemetry != nullptr ? vehicle.screen(telemetry, style) : style.dim("no telemetry") + "\n";
}

std::string fixed(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : "-";
}

bool latched(const lss_Status& status, FaultId id, std::uint16_t subject) {
  return std::ranges::any_of(status.faults, [&](const lss_Fault& fault) {
    return fault.id == static_cast<std::uint16_t>(id) && (subject == 0 || fault.subject == subject);
  });
}

}  // namespace lss::cli
