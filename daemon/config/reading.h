#pragma once

// Values that several vehicles read from their tables. Start-up only.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/config/section.h"
#include "drivers/time.h"

namespace lss::config {

inline TimeNs milliseconds(Section& s, std::string_view key, TimeNs fallback, double min,
                           double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-6, min, max) * 1e6);
}
inline TimeNs seconds(Section& s, std::string_view key, TimeNs fallback, double min, double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-9, min, max) * 1e9);
}

// The error-solving strategies of a fault class, in their order. names[0] is none, which ends the
// list.
template <class Kind, std::size_t N>
void read_strategies(Section& s, std::string_view key, std::span<const char* const> names,
                     std::array<Kind, N>& order) {
  const std::vector<std::string> known(names.begin() + 1, names.end());
  std::vector<std::string> fallback;
  for (const Kind kind : order) {
    if (kind != Kind{}) fallback.emplace_back(names[static_cast<std::size_t>(kind)]);
  }
  const std::vector<std::string> chosen = s.texts(key, fallback);
  if (chosen.empty() || chosen.size() > N) {
    s.error(key, fmt::format("{} strategies: name between one and {}", chosen.size(), N));
    return;
  }
  order.fill(Kind{});
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    const auto found = std::find(known.begin(), known.end(), chosen[i]);
    if (found == known.end()) {
      s.error(key, fmt::format("\"{}\" is no strategy: use {}", chosen[i], join(known)));
      continue;
    }
    order[i] = static_cast<Kind>(found - known.begin() + 1);
  }
}

}  // namespace lss::config
