#include "tests/campaign/script.h"

#include <fmt/format.h>

#include <charconv>

namespace lss::campaign {
namespace {

// A choice has two bytes.
constexpr std::size_t even(std::size_t size) { return size & ~std::size_t{1}; }

}  // namespace

std::string to_hex(std::span<const std::uint8_t> script) {
  return fmt::format("{:02x}", fmt::join(script, ""));
}

std::optional<Script> from_hex(std::string_view text) {
  Script script(text.size() / 2);
  for (std::size_t i = 0; i < script.size(); ++i) {
    const char* const digits = text.data() + 2 * i;
    if (std::from_chars(digits, digits + 2, script[i], 16).ptr != digits + 2) return {};
  }
  if (text.size() % 2 != 0) return {};
  return script;
}

Script shrink(Script script, const std::function<bool(const Script&)>& fails, unsigned plays) {
  const auto better = [&](const Script& shorter) {
    if (plays == 0 || shorter == script) return false;
    --plays;
    if (!fails(shorter)) return false;
    script = shorter;
    return true;
  };
  for (bool changed = true; changed && plays > 0;) {
    changed = false;
    // Without a part of it: halves, quarters, ... single choices; the end first.
    for (std::size_t part = even(script.size() / 2); part >= 2; part = even(part / 2)) {
      for (std::size_t end = script.size(); end >= part;) {
        Script shorter = script;
        const auto first = shorter.begin() + static_cast<std::ptrdiff_t>(end - part);
        shorter.erase(first, first + static_cast<std::ptrdiff_t>(part));
        changed = better(shorter) || changed;
        end = std::min(end - part, script.size());
      }
    }
    // Zeros at the end are there by themselves.
    Script shorter = script;
    while (!shorter.empty() && shorter.back() == 0) shorter.pop_back();
    changed = better(shorter) || changed;
    for (std::size_t i = 0; i < script.size(); ++i) {
      for (const int value : {0, script[i] / 2, script[i] - 1}) {
        if (value < 0 || value >= script[i]) continue;
        Script smaller = script;
        smaller[i] = static_cast<std::uint8_t>(value);
        if (!better(smaller)) continue;
        changed = true;
        break;
      }
    }
  }
  return script;
}

}  // namespace lss::campaign
