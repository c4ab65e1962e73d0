#pragma once

// CAN frames in UDP datagrams: the cannelloni format, version 2, both ways. Pure: bytes in, frames
// out and back; any thread; nothing allocates. Layout: docs/icd-ardito.md section 12, after
// doc/udp_format.md of cannelloni.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/can/frame.h"

namespace lss {

inline constexpr std::size_t kMaxDatagram = 1472;  // one Ethernet frame of UDP over IPv4

// Counts of received data. Of a broken datagram the frames before the error are used.
struct CannelloniCounters {
  std::uint64_t datagrams = 0;
  std::uint64_t frames = 0;
  std::uint64_t bad_header = 0;  // too short, another version or another operation
  std::uint64_t truncated = 0;   // ended inside a frame, or with fewer frames than announced
  std::uint64_t trailing = 0;    // went on after the last frame announced
  std::uint64_t bad_frame = 0;   // more data than a frame has, or no such identifier
  std::uint64_t can_fd = 0;      // frames skipped

  std::uint64_t broken() const { return bad_header + truncated + trailing + bad_frame; }
};

class CannelloniReader {
 public:
  // The bytes must stay until next() has returned false.
  void begin(std::span<const std::uint8_t> datagram) noexcept;
  // The next frame, with time_ns 0. False: there is none left.
  bool next(CanFrame& frame) noexcept;
  void clear() noexcept { left_ = 0; }  // drops the remaining frames of the datagram
  const CannelloniCounters& counters() const noexcept { return counters_; }

 private:
  bool end() noexcept;

  std::span<const std::uint8_t> rest_;
  std::uint16_t left_ = 0;  // frames announced and not yet read
  CannelloniCounters counters_;
};

class CannelloniWriter {
 public:
  bool add(const CanFrame& frame) noexcept;  // false: full; take() first
  bool empty() const noexcept { return count_ == 0; }
  // The datagram, valid until the next add(), which begins a new one.
  std::span<const std::uint8_t> take() noexcept { return take(sequence_++); }
  // The same, with a sequence number of the caller.
  std::span<const std::uint8_t> take(std::uint8_t sequence) noexcept;

 private:
  static constexpr std::size_t kHeader = 5;
  std::array<std::uint8_t, kMaxDatagram> bytes_{};
  std::size_t size_ = kHeader;
  std::uint16_t count_ = 0;
  std::uint8_t sequence_ = 0;
};

}  // namespace lss
