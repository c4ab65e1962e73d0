#pragma once

// Times on the wire by formula. Pure.

#include <cstdint>
#include <span>
#include <string>

namespace lss::cli::certify {

// A CAN 2.0A data frame with that many bytes and its interframe space, with the most stuff bits
// (R. Davis et al., "Controller Area Network (CAN) schedulability analysis: Refuted, revisited and
// revised", Real-Time Systems 35, 2007).
constexpr std::int64_t can_bits(std::int64_t bytes) {
  return 8 * bytes + 47 + (34 + 8 * bytes - 1) / 4;
}
constexpr double bits_us(std::int64_t bits, std::int64_t bit_s) {
  return static_cast<double>(bits) * 1e6 / static_cast<double>(bit_s);
}

// What the overlay of a vehicle knows (tools/lss-cli/session/vehicle.h).
struct Wire {
  double packet_us = 0;   // of the sensor that begins a frame, from T_k on; 0: the clock does
  double orders_us = 0;   // all orders of a frame
  std::string formula{};  // of the orders
};

// A frame that a node sends already, all of ours, and those of `theirs` that go first, once; sizes
// in bytes.
Wire of_can(std::span<const std::int64_t> ours, std::span<const std::int64_t> theirs,
            std::int64_t bit_s);

}  // namespace lss::cli::certify
