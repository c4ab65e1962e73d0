#include "drivers/canopen/sdo.h"

#include <algorithm>

#include "drivers/canopen/canopen.h"

namespace lss::canopen {
namespace {

constexpr std::uint8_t kWritten = 0x60, kRead = 0x40, kAbort = 0x80;

void put(CanFrame& frame, const Entry& entry, std::uint32_t value) {
  frame.data[1] = static_cast<std::uint8_t>(entry.index);
  frame.data[2] = static_cast<std::uint8_t>(entry.index >> 8);
  frame.data[3] = entry.sub;
  for (std::size_t i = 0; i < 4; ++i) {
    frame.data[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
  }
}

std::uint32_t value_of(const CanFrame& frame, std::size_t bytes) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{frame.data[4 + i]} << (8 * i);
  return value;
}

// Expedited, with the number of bytes that are not used.
std::uint8_t write_command(std::uint8_t size) {
  return static_cast<std::uint8_t>(0x23 | (4 - size) << 2);
}

}  // namespace

void SdoClient::ask(const Entry& entry, bool writes) noexcept {
  entry_ = entry;
  if (writes) entry_.size = std::clamp<std::uint8_t>(entry.size, 1, 4);
  writes_ = writes;
  result_ = Result::pending;
  sent_ = 0;
  abort_code_ = 0;
  tell_ = false;
}

void SdoClient::abort(std::uint32_t code) noexcept {
  result_ = Result::aborted;
  abort_code_ = code;
  ++counters_.aborts;
}

void SdoClient::receive(const CanFrame& frame) noexcept {
  const bool ours = frame.size == 8 && frame.data[1] == (entry_.index & 0xFF) &&
                    frame.data[2] == entry_.index >> 8 && frame.data[3] == entry_.sub;
  if (result_ != Result::pending || sent_ == 0 || !ours) {
    ++counters_.unexpected;
    return;
  }
  const std::uint8_t command = frame.data[0];
  if (command == kAbort) return abort(value_of(frame, 4));
  if (writes_ && command == kWritten) {
    result_ = Result::done;
    return;
  }
  const bool expedited = (command & 0x02) != 0, counted = (command & 0x01) != 0;
  if (!writes_ && (command & 0xE0) == kRead && expedited) {
    entry_.size = static_cast<std::uint8_t>(counted ? 4 - (command >> 2 & 0x03) : 4);
    entry_.value = value_of(frame, entry_.size);
    result_ = Result::done;
    return;
  }
  abort(kAbortBadCommand);  // segmented, for example: not supported
  tell_ = true;
}

bool SdoClient::transmit(TimeNs now, CanFrame& frame) noexcept {
  if (result_ == Result::pending && sent_ >= attempts_ && now >= deadline_ns_) {
    abort(kAbortTimeout);
    tell_ = true;
  }
  const bool asks = result_ == Result::pending && (sent_ == 0 || now >= deadline_ns_);
  if (!asks && !tell_) return false;
  frame = {};
  frame.time_ns = now;
  frame.id = kSdoRequest + node_;
  frame.size = 8;
  if (tell_) {
    tell_ = false;
    frame.data[0] = kAbort;
    put(frame, entry_, abort_code_);
    return true;
  }
  frame.data[0] = writes_ ? write_command(entry_.size) : kRead;
  put(frame, entry_, writes_ ? entry_.value : 0);
  ++counters_.requests;
  if (sent_ > 0) ++counters_.repeats;
  ++sent_;
  deadline_ns_ = now + timeout_ns_;
  return true;
}

TimeNs SdoClient::next_wake() const noexcept {
  if (tell_ || (result_ == Result::pending && sent_ == 0)) return INT64_MIN;
  return result_ == Result::pending ? deadline_ns_ : kNever;
}

}  // namespace lss::canopen
