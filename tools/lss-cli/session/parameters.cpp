#include "tools/lss-cli/session/parameters.h"

#include <algorithm>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::cli {
namespace {

nlohmann::json to_json(const Vehicle& vehicle, const lss_Parameter& p) {
  return {{"name", text(p.name)},
          {"value", p.value},
          {"unit", text(p.unit)},
          {"min", p.min},
          {"max", p.max},
          {"whole", p.whole},
          {"configured", p.configured},
          {"saved", is_saved(p) ? nlohmann::json(p.saved) : nlohmann::json()},
          {"as_configured", is_configured(p)},
          {"as_saved", is_kept(p)},
          {"change", p.change == lss_CHANGE_ALWAYS ? "always" : "at_rest"},
          {"help", help_of(vehicle, text(p.name))}};
}

}  // namespace

std::span<const lss_Parameter> items(const lss_Parameters& sample) {
  return {sample.item, std::min<std::size_t>(sample.count, kMaxTunables)};
}

std::string help_of(const Vehicle& vehicle, std::string_view name) {
  const std::span<const TunableInfo> infos = vehicle.tunables;
  const int index = find_tunable(infos, name);
  return index < 0 ? "" : infos[static_cast<std::size_t>(index)].help;
}

nlohmann::json parameters_json(const Vehicle& vehicle, const lss_Parameters& sample,
                               std::span<const lss_Parameter> shown) {
  nlohmann::json list = nlohmann::json::array();
  for (const lss_Parameter& p : shown) list.push_back(to_json(vehicle, p));
  return {{"vehicle_id", text(sample.vehicle_id)},
          {"save", sample.save},
          {"saved_parameters", saved_name(sample.saved)},
          {"parameters", std::move(list)}};
}

}  // namespace lss::cli
