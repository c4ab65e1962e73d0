#include "tools/lss-cli/certify/wire.h"

#include <fmt/format.h>

namespace lss::cli::certify {

Wire of_can(std::span<const std::int64_t> ours, std::span<const std::int64_t> theirs,
            std::int64_t bit_s) {
  constexpr std::int64_t kMostBytes = 8;
  std::int64_t bits = can_bits(kMostBytes);
  for (const auto& frames : {ours, theirs}) {
    for (const std::int64_t bytes : frames) bits += can_bits(bytes);
  }
  return {.orders_us = bits_us(bits, bit_s),
          .formula = fmt::format("{} frames and {} of nodes, {} bits at {} bit/s", ours.size(),
                                 theirs.size() + 1, bits, bit_s)};
}

}  // namespace lss::cli::certify
