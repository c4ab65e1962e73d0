// The nodes of docs/icd-talaris.md sections 5 and 6 for the CANopen master, and their PDOs.

#include <algorithm>

#include "drivers/canopen/drive_pdo.h"
#include "drivers/talaris/hopper_bus.h"

namespace lss::talaris {
namespace {

using canopen::Entry;
using canopen::i16;
using canopen::NodeParameters;
using canopen::Pdo;
using canopen::u16;
using Bytes = std::span<const std::uint8_t>;

constexpr std::uint32_t kValveDevice = 0x0006'0191, kFanDevice = 0x000C'0191;
constexpr std::uint32_t kLoadCellDevice = 0x0004'0191;
constexpr std::uint16_t kAnalogueErrorMode = 0x6443, kAnalogueErrorValue = 0x6444;
constexpr std::uint16_t kRenewal = 0x2201, kRamp = 0x2202;

constexpr Entry kInhibit = {canopen::kEmergencyInhibit, 0, 2, 100};  // 10 ms
constexpr Entry kFallBack = {canopen::kErrorBehaviour, 1, 1, 0};     // to pre-operational

constexpr Pdo kValveRpdo1 = {1, canopen::kEvent, 0, 0, {0x6200'0108, 0x2200'0008}};
constexpr Pdo kValveTpdo2 = {
    2, canopen::kEvent, 0, 200, {0x6401'0110, 0x6401'0210, 0x6401'0310, 0x6401'0410}};
constexpr Pdo kFanRpdo1 = {
    1, canopen::kEvent, 0, 0, {0x6411'0110, 0x6411'0210, 0x6411'0310, 0x6411'0410}};
constexpr Pdo kFanTpdo1 = {
    1, canopen::kEvent, 0, 20, {0x6401'0110, 0x6401'0210, 0x6401'0310, 0x6401'0410}};
constexpr Pdo kLoadTpdo1 = {1, canopen::kEvent, 0, 2, {0x6401'0110, 0x6401'0210, 0x6401'0310}};
constexpr Pdo kLoadTpdo2 = {2, canopen::kEvent, 0, 2, {0x6401'0410, 0x6401'0510, 0x6401'0610}};

std::uint32_t whole_ms(TimeNs time) {
  return static_cast<std::uint32_t>(std::clamp<TimeNs>(time / kMillisecond, 0, 0xFFFF));
}
Entry renewal(const HopperBusParameters& p) { return {kRenewal, 0, 2, whole_ms(p.renewal_ns)}; }

NodeParameters valves(const HopperBusParameters& p) {
  return {p.node[kValveNode],
          kValveDevice,
          {{kInhibit,
            kFallBack,
            {canopen::kOutputErrorMode, 1, 1, 0xFF},
            {canopen::kOutputErrorValue, 1, 1, 0x00},
            renewal(p)}},
          {kValveRpdo1},
          {kValveTpdo2}};
}

NodeParameters fans(const HopperBusParameters& p) {
  NodeParameters node = {
      p.node[kFanNode], kFanDevice, {{kInhibit, kFallBack}}, {kFanRpdo1}, {kFanTpdo1}};
  std::size_t next = 2;
  for (std::uint8_t sub = 1; sub <= kHopperFans; ++sub) {
    node.entries[next++] = {kAnalogueErrorMode, sub, 1, 1};
  }
  for (std::uint8_t sub = 1; sub <= kHopperFans; ++sub) {
    node.entries[next++] = {kAnalogueErrorValue, sub, 4, kFanOff_us};
  }
  node.entries[next++] = renewal(p);
  node.entries[next] = {kRamp, 0, 2, whole_ms(p.fan_ramp_ns)};
  return node;
}

NodeParameters load_cell(const HopperBusParameters& p) {
  return {p.node[kLoadCellNode],
          kLoadCellDevice,
          {{kInhibit, kFallBack}},
          {},
          {kLoadTpdo1, kLoadTpdo2}};
}

// nullptr: there is none.
const Pdo* tpdo_of(std::size_t node, int number) {
  if (node == kValveNode && number == 2) return &kValveTpdo2;
  if (node == kFanNode && number == 1) return &kFanTpdo1;
  if (node == kLoadCellNode && number == 1) return &kLoadTpdo1;
  return node == kLoadCellNode && number == 2 ? &kLoadTpdo2 : nullptr;
}

}  // namespace

TimeNs event_timer(std::size_t node, int number) noexcept {
  const Pdo* const pdo = tpdo_of(node, number);
  return pdo != nullptr ? pdo->event_ms * kMillisecond : 0;
}

canopen::MasterParameters master_parameters(const HopperBusParameters& p) noexcept {
  canopen::MasterParameters master;
  master.heartbeat = {p.master_node, p.heartbeat_period_ns, p.heartbeat_timeout_ns,
                      p.node_period_ns, p.node_timeout_ns};
  master.sync_period_ns = 0;
  master.babble_frames = 250;  // the load cell alone sends 100 in 100 ms
  master.nodes[kValveNode] = valves(p);
  master.nodes[kFanNode] = fans(p);
  if (p.load_cell) master.nodes[kLoadCellNode] = load_cell(p);
  return master;
}

bool decode(std::size_t node, int number, Bytes data, Reading& reading) noexcept {
  constexpr double kKilopascal = 1000, kVolt = 0.01, kCelsius = 0.1, kNewton = 0.1;
  constexpr double kNewtonMetre = 0.01;
  if (node == kValveNode && number == 2 && data.size() == 8) {
    reading = GasState{u16(data, 0) * kKilopascal, u16(data, 2) * kKilopascal, u16(data, 4) * kVolt,
                       i16(data, 6) * kCelsius};
    return true;
  }
  if (node == kFanNode && number == 1 && data.size() == 8) {
    FanSpeeds speeds;
    for (std::size_t i = 0; i < kHopperFans; ++i) speeds.rpm[i] = u16(data, 2 * i);
    reading = speeds;
    return true;
  }
  if (node == kLoadCellNode && (number == 1 || number == 2) && data.size() == 6) {
    Load load;
    for (std::size_t i = 0; i < 3; ++i) {
      if (number == 1) load.force_N[i] = i16(data, 2 * i) * kNewton;
      if (number == 2) load.moment_Nm[i] = i16(data, 2 * i) * kNewtonMetre;
    }
    reading = load;
    return true;
  }
  return false;
}

}  // namespace lss::talaris
