// The SDO server of a simulated CANopen node, and the rules of CiA 301 for writes.

#include "tools/lss-sim/canopen/node.h"
#include "tools/lss-sim/canopen/wire.h"

namespace lss::sim::nodes {

void Node::serve_sdo(const CanFrame& request) {
  const std::uint8_t command = request.data[0];
  if (command == 0x80) return;  // the master gives up
  const auto index = static_cast<std::uint16_t>(request.data[1] | request.data[2] << 8);
  const std::uint8_t sub = request.data[3];
  std::array<std::uint8_t, 8> answer{0, request.data[1], request.data[2], sub, 0, 0, 0, 0};
  Abort result = kDone;
  if (faults.sdo_abort != 0) {
    result = static_cast<Abort>(faults.sdo_abort);
  } else if (faults.no_object != 0 && faults.no_object == index) {
    result = kNoObject;
  } else if (command == 0x40) {
    measure();
    const Object* object = objects_.find(index, sub);
    if (object == nullptr) {
      result = objects_.has_index(index) ? kNoSubIndex : kNoObject;
    } else {
      answer[0] = static_cast<std::uint8_t>(0x43 | (4 - object->bytes) << 2);
      to_little_endian(objects_.get(index, sub), std::span(answer).subspan(4, object->bytes));
    }
  } else if ((command & 0xE3) == 0x23 && (command & 0x10) == 0) {
    const std::size_t bytes = 4u - (command >> 2 & 3u);
    result = write(index, sub, bytes, little_endian(std::span(request.data).subspan(4, bytes)));
    answer[0] = 0x60;
  } else {
    result = kUnknownCommand;
  }
  if (result != kDone) {
    answer[0] = 0x80;
    to_little_endian(result, std::span(answer).subspan(4));
  }
  put(0x580u + id_, answer);
}

Abort Node::write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) {
  Abort result = objects_.check(index, sub, bytes, value);
  if (result == kDone && index == 0x1003 && value != 0) result = kOutOfRange;
  for (const bool transmit : {false, true}) {
    for (const Pdo& pdo : transmit ? tpdos_ : rpdos_) {
      if (result == kDone) result = check_pdo(pdo, transmit, index, sub, value);
    }
  }
  if (result != kDone) return result;
  objects_.set(index, sub, value);
  if (index == 0x1016) watching_ = false;  // begins with the next one received
  if (index == 0x1017) heartbeat_ms_ = 0;
  written(index, sub);
  return kDone;
}

// Writes that CiA 301 forbids while a PDO exists or its mapping is active.
Abort Node::check_pdo(const Pdo& pdo, bool transmit, std::uint16_t index, std::uint8_t sub,
                      std::uint32_t value) const {
  if (index == pdo.parameters) {
    const std::uint32_t old = objects_.get(index, 1);
    if (sub == 1) {
      const bool moves = valid(pdo) && (value & kInvalid) == 0 && ((value ^ old) & kIdBits) != 0;
      return moves || (value & kExtended) != 0 ? kOutOfRange : kDone;
    }
    const bool known = value == 254 || value == 255 || (transmit && value >= 1 && value <= 240);
    if (sub == 2 && !known) return kOutOfRange;
    return sub == 3 && valid(pdo) ? kNoAccess : kDone;
  }
  if (index != pdo.mapping) return kDone;
  if (valid(pdo)) return kNoAccess;
  if (sub == 0) {
    if (value > kMostMapped) return kOutOfRange;
    std::size_t bits = 0;
    for (std::uint8_t i = 1; i <= value; ++i) bits += unpack(objects_.get(index, i)).bits;
    return bits > 64 ? kPdoTooLong : kDone;
  }
  if (objects_.get(index, 0) != 0) return kNoAccess;
  const Mapped mapped = unpack(value);
  const Object* object = objects_.find(mapped.index, mapped.sub);
  if (object == nullptr) return kNoObject;
  const bool direction = transmit || object->access == Access::read_write;
  if (!object->mappable || !direction || mapped.bits != object->bytes * 8) return kNotMappable;
  return kDone;
}

}  // namespace lss::sim::nodes
