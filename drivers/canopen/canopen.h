#pragma once

// Constants of CANopen: CiA 301 (services), CiA 402 (drives), CiA 401 (I/O), as far as used here.
// docs/icd-ardito.md says how the buses use them.

#include <cstdint>

#include "drivers/can/frame.h"

namespace lss::canopen {

inline constexpr int kMaxNode = 127;

// Function codes: a COB-ID is one of these plus the node.
inline constexpr std::uint32_t kNmt = 0x000, kSync = 0x080, kEmergency = 0x080;
inline constexpr std::uint32_t kTpdo1 = 0x180, kRpdo1 = 0x200;  // PDO n: + (n - 1) * 0x100
inline constexpr std::uint32_t kPdoStep = 0x100;
inline constexpr std::uint32_t kSdoAnswer = 0x580, kSdoRequest = 0x600, kHeartbeat = 0x700;
inline constexpr int kMaxPdos = 4;  // of the predefined connection set, each way

enum class Nmt : std::uint8_t {
  start = 0x01,
  stop = 0x02,
  pre_operational = 0x80,
  reset_node = 0x81,
  reset_communication = 0x82,
};

// The byte of a heartbeat.
enum class NmtState : std::uint8_t {
  boot_up = 0x00,
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
  unknown = 0xFF,  // ours: no heartbeat yet
};

// Objects, CiA 301.
inline constexpr std::uint16_t kDeviceType = 0x1000, kEmergencyInhibit = 0x1015;
inline constexpr std::uint16_t kConsumerHeartbeat = 0x1016, kProducerHeartbeat = 0x1017;
inline constexpr std::uint16_t kErrorBehaviour = 0x1029;
inline constexpr std::uint16_t kRpdoParameters = 0x1400, kRpdoMapping = 0x1600;
inline constexpr std::uint16_t kTpdoParameters = 0x1800, kTpdoMapping = 0x1A00;
inline constexpr std::uint32_t kPdoInvalid = 0x8000'0000;       // in a PDO's COB-ID
inline constexpr std::uint32_t kNoRemoteRequest = 0x4000'0000;  // the same, TPDO

// Objects, CiA 402.
inline constexpr std::uint16_t kAbortConnection = 0x6007, kQuickStopOption = 0x605A;
inline constexpr std::uint16_t kModeOfOperation = 0x6060;
inline constexpr std::uint16_t kAcceleration = 0x6083, kDeceleration = 0x6084;
inline constexpr std::uint16_t kQuickStopDeceleration = 0x6085;

// Objects, CiA 401.
inline constexpr std::uint16_t kOutputErrorMode = 0x6206, kOutputErrorValue = 0x6207;

// States of a drive, CiA 402.
enum class DriveState : std::uint8_t {
  unknown,  // ours: no statusword yet
  not_ready,
  switch_on_disabled,
  ready_to_switch_on,
  switched_on,
  operation_enabled,
  quick_stop_active,
  fault_reaction,
  fault,
};

constexpr DriveState drive_state(std::uint16_t statusword) {
  switch (statusword & 0x4F) {
    case 0x00: return DriveState::not_ready;
    case 0x40: return DriveState::switch_on_disabled;
    case 0x0F: return DriveState::fault_reaction;
    case 0x08: return DriveState::fault;
    default: break;
  }
  switch (statusword & 0x6F) {
    case 0x21: return DriveState::ready_to_switch_on;
    case 0x23: return DriveState::switched_on;
    case 0x27: return DriveState::operation_enabled;
    case 0x07: return DriveState::quick_stop_active;
    default: return DriveState::unknown;
  }
}

// The power stage is on: the motor follows, brakes or holds.
constexpr bool powered(DriveState state) {
  return state == DriveState::operation_enabled || state == DriveState::quick_stop_active ||
         state == DriveState::fault_reaction;
}

// Statusword.
inline constexpr std::uint16_t kSetPointAcknowledged = 1u << 12;  // profile position
inline constexpr std::uint16_t kFollowingError = 1u << 13;        // profile position

// Controlword.
inline constexpr std::uint16_t kDisableVoltage = 0x0000, kQuickStop = 0x0002, kShutdown = 0x0006;
inline constexpr std::uint16_t kSwitchOn = 0x0007, kEnableOperation = 0x000F, kFaultReset = 0x0080;
inline constexpr std::uint16_t kNewSetPoint = 1u << 4, kChangeImmediately = 1u << 5;

// The controlword for the next step towards operation enabled. It does not leave a fault.
constexpr std::uint16_t towards_enabled(DriveState state) {
  switch (state) {
    case DriveState::switch_on_disabled: return kShutdown;
    case DriveState::ready_to_switch_on: return kSwitchOn;
    case DriveState::switched_on:
    case DriveState::operation_enabled: return kEnableOperation;
    default: return kDisableVoltage;
  }
}

}  // namespace lss::canopen
