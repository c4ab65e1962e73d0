#include "drivers/canopen/node.h"

#include <algorithm>

namespace lss::canopen {
namespace {

constexpr std::uint8_t kCobId = 1, kType = 2, kInhibit = 3, kEventTimer = 5;  // sub-indices

std::uint32_t milliseconds(TimeNs time) {
  return static_cast<std::uint32_t>(std::clamp<TimeNs>(time / kMillisecond, 0, UINT16_MAX));
}

}  // namespace

const Pdo* NodeParameters::tpdo_of(int number) const noexcept {
  const auto found = std::ranges::find(tpdo, number, &Pdo::number);
  return found != tpdo.end() && number != 0 ? &*found : nullptr;
}

Configuration::Configuration(const NodeParameters& node,
                             const HeartbeatParameters& heartbeat) noexcept {
  add(kProducerHeartbeat, 0, 2, milliseconds(heartbeat.of_node_ns()));
  add(kConsumerHeartbeat, 1, 4,
      std::uint32_t{heartbeat.master} << 16 | milliseconds(heartbeat.timeout_ns));
  for (const Entry& entry : node.entries) {
    if (entry.size > 0) add(entry.index, entry.sub, entry.size, entry.value, entry.optional);
  }
  for (const Pdo& pdo : node.rpdo) {
    if (pdo.number > 0) add(pdo, node.node, false);
  }
  for (const Pdo& pdo : node.tpdo) {
    if (pdo.number > 0) add(pdo, node.node, true);
  }
}

void Configuration::add(std::uint16_t index, std::uint8_t sub, std::uint8_t size,
                        std::uint32_t value, bool optional) noexcept {
  if (count_ == kMaxEntries) {
    complete_ = false;
    return;
  }
  entries_[count_++] = {index, sub, size, value, optional};
}

// CiA 301 allows a mapping to be changed only while the PDO is invalid and maps nothing.
void Configuration::add(const Pdo& pdo, std::uint8_t node, bool transmits) noexcept {
  const auto n = static_cast<std::uint16_t>(pdo.number - 1);
  const auto parameters =
      static_cast<std::uint16_t>((transmits ? kTpdoParameters : kRpdoParameters) + n);
  const auto mapping = static_cast<std::uint16_t>((transmits ? kTpdoMapping : kRpdoMapping) + n);
  const std::uint32_t cob_id =
      ((transmits ? kTpdo1 : kRpdo1) + n * kPdoStep + node) | (transmits ? kNoRemoteRequest : 0u);
  add(parameters, kCobId, 4, cob_id | kPdoInvalid);
  add(mapping, 0, 1, 0);
  std::uint8_t objects = 0;
  for (const std::uint32_t object : pdo.objects) {
    if (object != 0) add(mapping, ++objects, 4, object);
  }
  add(mapping, 0, 1, objects);
  add(parameters, kType, 1, pdo.type);
  if (pdo.inhibit_100us > 0) add(parameters, kInhibit, 2, pdo.inhibit_100us);
  if (pdo.event_ms > 0) add(parameters, kEventTimer, 2, pdo.event_ms);
  add(parameters, kCobId, 4, cob_id);
}

}  // namespace lss::canopen
