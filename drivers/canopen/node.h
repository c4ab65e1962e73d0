#pragma once

// A CANopen node for the master: its required device type, and its configuration before the start.
// Pure; nothing allocates.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/canopen/canopen.h"
#include "drivers/canopen/sdo.h"

namespace lss::canopen {

inline constexpr std::uint8_t kOnSync = 1, kDeviceEvent = 254, kEvent = 255;  // transmission types

struct Pdo {
  std::uint8_t number = 0;  // 1 to 4; 0: none
  std::uint8_t type = kOnSync;
  std::uint16_t inhibit_100us = 0;            // 0: not written. TPDO only
  std::uint16_t event_ms = 0;                 // 0: not written. TPDO only
  std::array<std::uint32_t, 4> objects = {};  // index << 16 | sub << 8 | bits; 0: end

  constexpr std::uint8_t bytes() const {
    std::uint32_t bits = 0;
    for (const std::uint32_t object : objects) bits += object & 0xFF;
    return static_cast<std::uint8_t>(bits / 8);
  }
};

struct NodeParameters {
  std::uint8_t node = 0;
  std::uint32_t device_type = 0;     // of object 0x1000
  std::array<Entry, 12> entries{};   // written before the PDOs; size 0: end
  std::array<Pdo, kMaxPdos> rpdo{};  // the node receives
  std::array<Pdo, kMaxPdos> tpdo{};  // the node sends

  const Pdo* tpdo_of(int number) const noexcept;  // nullptr: it has none of this number
};

// Heartbeat times, for all nodes.
struct HeartbeatParameters {
  std::uint8_t master = 0x7F;
  TimeNs period_ns = 100 * kMillisecond;   // of the master and of each node
  TimeNs timeout_ns = 300 * kMillisecond;  // after which either takes the other as lost
  TimeNs node_period_ns = 0;               // of the nodes, when different
  TimeNs node_timeout_ns = 0;              // after which a node is lost, when different

  constexpr TimeNs of_node_ns() const { return node_period_ns > 0 ? node_period_ns : period_ns; }
  constexpr TimeNs lost_after_ns() const {
    return node_timeout_ns > 0 ? node_timeout_ns : timeout_ns;
  }
};

// All entries written into a node, in the order required by CiA 301.
class Configuration {
 public:
  static constexpr std::size_t kMaxEntries = 64;

  Configuration() = default;
  Configuration(const NodeParameters& node, const HeartbeatParameters& heartbeat) noexcept;
  std::span<const Entry> entries() const noexcept { return std::span(entries_).first(count_); }
  bool complete() const noexcept { return complete_; }  // false: there was no room for all

 private:
  void add(std::uint16_t index, std::uint8_t sub, std::uint8_t size, std::uint32_t value,
           bool optional = false) noexcept;
  void add(const Pdo& pdo, std::uint8_t node, bool transmits) noexcept;

  std::array<Entry, kMaxEntries> entries_{};
  std::size_t count_ = 0;
  bool complete_ = true;
};

}  // namespace lss::canopen
