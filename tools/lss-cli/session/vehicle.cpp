#include "tools/lss-cli/session/vehicle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "idl/idl_text.h"
#include "tools/lss-cli/session/telemetry.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {

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
  return command.info->endless && !(vehicle.ends != nullptr && vehicle.ends(command));
}

std::string_view idl_of(const Vehicle& vehicle) {
  return vehicle.idl.empty() ? idl_text(vehicle.name) : vehicle.idl;
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

std::vector<Problem> closed_port(const lss_Status& status, const char* what,
                                 std::uint16_t subject) {
  if (latched(status, FaultId::port_lost, subject) ||
      latched(status, FaultId::port_absent, subject))
    return {};
  return {{true, fmt::format("{} is not open", what), "check the port named in the config"}};
}

std::string unheard(const Vehicle& vehicle, std::uint16_t subject, std::uint64_t age_ms,
                    const std::string& how) {
  const std::string name = subject_name(vehicle, subject);
  if (age_ms == kNeverHeard_ms) return name + " has never answered";
  return fmt::format("{} {} {} ago", name, how,
                     format_duration(static_cast<double>(age_ms) / 1000));
}

void name_subjects(const Vehicle& vehicle, nlohmann::json& parts, std::uint16_t first) {
  for (nlohmann::json& part : parts) {
    const int subject = first + part["id"].get<int>();
    part["name"] = subject_name(vehicle, static_cast<std::uint16_t>(subject));
  }
}

}  // namespace lss::cli
