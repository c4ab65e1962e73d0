#include "tools/lss-cli/vehicle.h"

#include <fmt/format.h>

namespace lss::cli {

const Vehicle* find_vehicle(std::string_view name) {
  for (const Vehicle* vehicle : vehicles()) {
    if (vehicle->name == name) return vehicle;
  }
  return nullptr;
}

std::string subject_name(const Vehicle& vehicle, std::uint16_t subject) {
  if (subject == 0) return "";
  if (subject <= vehicle.subjects.size()) return vehicle.subjects[subject - 1u];
  return fmt::format("module {}", subject);
}

}  // namespace lss::cli
