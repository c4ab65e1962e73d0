#include "tools/lss-cli/session/vehicle.h"

#include <fmt/format.h>

#include <algorithm>

#include "idl/idl_text.h"
#include "tools/lss-cli/session/telemetry.h"

namespace lss::cli {

const Vehicle* find_vehicle(std::string_view name) {
  for (const Vehicle* vehicle : vehicles()) {
    if (vehicle->name == name) return vehicle;
  }
  return nullptr;
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

void name_subjects(const Vehicle& vehicle, nlohmann::json& parts, std::uint16_t first) {
  for (nlohmann::json& part : parts) {
    const int subject = first + part["id"].get<int>();
    part["name"] = subject_name(vehicle, static_cast<std::uint16_t>(subject));
  }
}

}  // namespace lss::cli
