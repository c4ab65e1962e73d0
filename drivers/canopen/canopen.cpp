#include "drivers/canopen/canopen.h"

namespace lss::canopen {

const char* text(NmtState state) noexcept {
  switch (state) {
    case NmtState::boot_up:
      return "boot-up";
    case NmtState::stopped:
      return "stopped";
    case NmtState::operational:
      return "operational";
    case NmtState::pre_operational:
      return "pre-operational";
    case NmtState::unknown:
      break;
  }
  return "unknown";
}

const char* text(DriveState state) noexcept {
  switch (state) {
    case DriveState::not_ready:
      return "not ready to switch on";
    case DriveState::switch_on_disabled:
      return "switch on disabled";
    case DriveState::ready_to_switch_on:
      return "ready to switch on";
    case DriveState::switched_on:
      return "switched on";
    case DriveState::operation_enabled:
      return "operation enabled";
    case DriveState::quick_stop_active:
      return "quick stop active";
    case DriveState::fault_reaction:
      return "fault reaction active";
    case DriveState::fault:
      return "fault";
    case DriveState::unknown:
      break;
  }
  return "unknown";
}

const char* abort_text(std::uint32_t code) noexcept {
  switch (code) {
    case 0x0503'0000:
      return "toggle bit not alternated";
    case 0x0504'0000:
      return "no answer in time";
    case 0x0504'0001:
      return "unknown command";
    case 0x0601'0000:
      return "access not supported";
    case 0x0601'0001:
      return "write-only object read";
    case 0x0601'0002:
      return "read-only object written";
    case 0x0602'0000:
      return "no such object";
    case 0x0604'0041:
      return "object cannot be mapped";
    case 0x0604'0042:
      return "mapped objects too long for a PDO";
    case 0x0607'0010:
      return "length does not match";
    case 0x0609'0011:
      return "no such sub-index";
    case 0x0609'0030:
      return "value out of range";
    case 0x0800'0000:
      return "general error";
    case 0x0800'0020:
      return "cannot be stored";
    case 0x0800'0022:
      return "not in this state of the device";
    default:
      return "another abort code";
  }
}

// The codes of docs/icd-ardito.md, else the class of CiA 301.
const char* emergency_text(std::uint16_t code) noexcept {
  switch (code) {
    case 0x0000:
      return "no error";
    case 0x2310:
      return "current above the limit";
    case 0x3210:
      return "link voltage too high";
    case 0x3220:
      return "link voltage too low";
    case 0x4210:
      return "device too hot";
    case 0x4310:
      return "drive too hot";
    case 0x7121:
      return "motor blocked";
    case 0x7305:
      return "motor encoder without signal";
    case 0x7306:
      return "reduction encoder without signal";
    case 0x8110:
      return "CAN overrun";
    case 0x8120:
      return "CAN error passive";
    case 0x8130:
      return "heartbeat of the master lost";
    case 0x8140:
      return "back from bus-off";
    case 0x8210:
      return "PDO of wrong length";
    case 0x8611:
      return "following error";
    default:
      break;
  }
  switch (code >> 12) {
    case 0x2:
      return "current";
    case 0x3:
      return "voltage";
    case 0x4:
      return "temperature";
    case 0x5:
      return "hardware of the device";
    case 0x6:
      return "software of the device";
    case 0x7:
      return "additional modules";
    case 0x8:
      return "monitoring";
    case 0x9:
      return "external error";
    case 0xF:
      return "device specific";
    default:
      return "generic error";
  }
}

}  // namespace lss::canopen
