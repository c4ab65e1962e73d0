#pragma once

// The numbered lists of reject reasons, faults and events that vehicles share (codes.inc). The
// daemon, the command line and the documents use them; on the wire only the number travels. Pure
// data, callable from every thread.

#include <cstdint>
#include <span>

namespace lss {

enum class Reason : std::uint16_t {
#define LSS_REASON(number, name, ...) name = number,
#include "idl/codes.inc"
};
enum class FaultId : std::uint16_t {
  none = 0,
#define LSS_FAULT(number, name, ...) name = number,
#include "idl/codes.inc"
};
enum class EventId : std::uint16_t {
  none = 0,
#define LSS_EVENT(number, name, ...) name = number,
#include "idl/codes.inc"
};

inline constexpr std::uint16_t kFaultEventBase = 1000;

struct CodeInfo {
  std::uint16_t number;
  const char* name;
  std::uint8_t severity;
  const char* text;
  const char* advice;
};

// As in lss.idl.
namespace severity_level {
inline constexpr std::uint8_t info = 0, warning = 1, error = 2, fatal = 3;
}

#define LSS_REASON_INFO(number, name, text, advice) {number, #name, 1, text, advice},
#define LSS_FAULT_INFO(number, name, severity, text, advice) \
  {number, #name, severity_level::severity, text, advice},
#define LSS_EVENT_INFO(number, name, severity, text) \
  {number, #name, severity_level::severity, text, ""},
inline constexpr CodeInfo kReasons[] = {
#define LSS_REASON LSS_REASON_INFO
#include "idl/codes.inc"
};
inline constexpr CodeInfo kFaults[] = {
#define LSS_FAULT LSS_FAULT_INFO
#include "idl/codes.inc"
};
inline constexpr CodeInfo kEvents[] = {
#define LSS_EVENT LSS_EVENT_INFO
#include "idl/codes.inc"
};

// Codes of a vehicle itself. Those of a vehicle from outside have the numbers from kFirstOwnCode to
// 999: below, this file may take new ones.
inline constexpr std::uint16_t kFirstOwnCode = 500;
struct OwnCodes {
  std::span<const CodeInfo> faults{}, reasons{}, events{};
};
// Those of this process: set once at start-up, before there are other threads.
inline OwnCodes own_codes;

constexpr const CodeInfo* find_code(std::span<const CodeInfo> table, std::uint16_t number) {
  for (const CodeInfo& info : table) {
    if (info.number == number) return &info;
  }
  return nullptr;
}
constexpr const CodeInfo* find_code(std::span<const CodeInfo> own, std::span<const CodeInfo> shared,
                                    std::uint16_t number) {
  const CodeInfo* code = find_code(own, number);
  return code != nullptr ? code : find_code(shared, number);
}

// nullptr for a number that is not in the lists.
constexpr const CodeInfo* info(Reason r, const OwnCodes& own = own_codes) {
  return find_code(own.reasons, kReasons, static_cast<std::uint16_t>(r));
}
constexpr const CodeInfo* info(FaultId f, const OwnCodes& own = own_codes) {
  return find_code(own.faults, kFaults, static_cast<std::uint16_t>(f));
}
constexpr const CodeInfo* info(EventId e, const OwnCodes& own = own_codes) {
  return find_code(own.events, kEvents, static_cast<std::uint16_t>(e));
}

// Of an event, or of the fault that it is.
constexpr const CodeInfo* event_info(std::uint16_t id, const OwnCodes& own = own_codes) {
  return id < kFaultEventBase ? info(static_cast<EventId>(id), own)
                              : info(static_cast<FaultId>(id - kFaultEventBase), own);
}

}  // namespace lss
