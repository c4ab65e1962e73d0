#pragma once

// Scenarios as bytes: each choice of a scenario is two of them (dice.h), so that a search can
// change them. Pure functions.

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lss::campaign {

using Script = std::vector<std::uint8_t>;

std::string to_hex(std::span<const std::uint8_t> script);
// Nothing: not an even number of hexadecimal digits.
std::optional<Script> from_hex(std::string_view text);

// The shortest script, with the smallest bytes, that is found to fail still; `script` fails. Plays
// at most `plays` scripts.
Script shrink(Script script, const std::function<bool(const Script&)>& fails, unsigned plays);

}  // namespace lss::campaign
