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
#include "daemon/cycle/tunables.h"
#include "drivers/time.h"

namespace lss::config {

inline TimeNs milliseconds(Section& s, std::string_view key, TimeNs fallback, double min,
                           double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-6, min, max) * 1e6);
}
inline TimeNs seconds(Section& s, std::string_view key, TimeNs fallback, double min, double max) {
  return static_cast<TimeNs>(s.number(key, static_cast<double>(fallback) * 1e-9, min, max) * 1e9);
}

// Reads the parameters of `section` (a path below the vehicle's table, "" for the table itself)
// that can change while the daemon runs, each with its range. A default stays bit-identical.
template <class P>
void read_tunables(Section& s, std::string_view section, std::span<const Tunable<P>> tunables,
                   P& parameters) {
  for (const Tunable<P>& t : tunables) {
    const std::string_view name = t.info.name;
    const std::size_t dot = name.rfind('.');
    if (name.substr(0, dot) != section) continue;
    const std::string_view key = name.substr(dot + 1);
    const double was = get_tunable(t, parameters);
    const double is = t.info.whole
                          ? static_cast<double>(s.integer(key, static_cast<std::int64_t>(was),
                                                          static_cast<std::int64_t>(t.info.min),
                                                          static_cast<std::int64_t>(t.info.max)))
                          : s.number(key, was, t.info.min, t.info.max);
    if (is != was) set_tunable(t, parameters, is);
  }
}

// The error-solving strategies of a fault class, in order. names[0] is none, which ends the list.
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
