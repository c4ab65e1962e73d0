#pragma once

// The daemon's report on its parameters (lss/parameters), for people and programs. Pure functions.

#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>

#include "daemon/cycle/tunables.h"
#include "lss.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

inline bool is_saved(const lss_Parameter& p) { return !std::isnan(p.saved); }
// The value of the next start.
inline double kept(const lss_Parameter& p) { return is_saved(p) ? p.saved : p.configured; }
inline bool is_configured(const lss_Parameter& p) { return same_value(p.value, p.configured); }
inline bool is_kept(const lss_Parameter& p) { return same_value(p.value, kept(p)); }

std::span<const lss_Parameter> items(const lss_Parameters& sample);

// Its purpose: from the table that this program was built with.
std::string help_of(const Vehicle& vehicle, std::string_view name);

// `shown`: some of the sample.
nlohmann::json parameters_json(const Vehicle& vehicle, const lss_Parameters& sample,
                               std::span<const lss_Parameter> shown);

}  // namespace lss::cli
