#pragma once

// The telemetry of any vehicle for people, by what its dictionary says of its fields: units in
// which people think, words for numbers, and a table for each array of structs, with a row for each
// element while that fits. Pure functions.

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/show/output.h"

namespace lss::cli {

// Presentation of a dictionary, as far as it is about fields. "modules.link" is a member of each
// element of modules.
struct Shown {
  struct Words {
    std::vector<std::string> words;
    bool shown_only = false;
  };
  struct Parts {
    unsigned first = 0;
    std::optional<std::string> unheard;
    std::uint32_t lesser = 0, optional = 0;
  };
  std::map<std::string, Words, std::less<>> words;
  std::map<std::string, Parts, std::less<>> parts;
  std::set<std::string, std::less<>> details;  // not on the screen
  std::span<const char* const> subjects;

  // Of an element of an array of parts; 0: none.
  template <class Json>
  std::uint16_t subject_of(std::string_view field, const Json& element) const {
    const auto part = parts.find(field);
    const auto id = element.find("id");
    if (part == parts.end() || id == element.end() || !id->is_number_unsigned()) return 0;
    return static_cast<std::uint16_t>(part->second.first + id->template get<unsigned>());
  }
  static bool is_in(std::uint32_t set, unsigned subject) {
    return subject >= 1 && subject <= 32 && (set >> (subject - 1) & 1u) != 0;
  }
  // "RM" of an element; empty: it has no name.
  std::string name_of(std::string_view field, const nlohmann::ordered_json& element) const;
};

// Words for numbers, names of elements, and null for the age of what was never heard.
nlohmann::ordered_json with_words(nlohmann::ordered_json telemetry, const Shown& shown);

// `telemetry` has words already. Lines, each ended: all but the details, or the details alone.
std::string telemetry_screen(const nlohmann::ordered_json& telemetry, const Shown& shown,
                             const Style& style);
std::string telemetry_details(const nlohmann::ordered_json& telemetry, const Shown& shown,
                              const Style& style);

}  // namespace lss::cli
