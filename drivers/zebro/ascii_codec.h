#pragma once

// The MODBUS-ASCII variant of Lunar Zebro's leg bus as bytes: frame, checks, and the receiver's
// rules (Zebro thesis 5.2.1; docs/icd-zebro.md sections 2 and 3). Does not interpret the codes.
// Callable from any thread, one Receiver per thread; nothing allocates, locks or throws.

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "drivers/time.h"

namespace lss::zebro {

enum class Check : std::uint8_t { lrc, crc8 };
enum class Stop : std::uint8_t { lf, crlf };

inline constexpr std::size_t kFrameData = 8;
inline constexpr std::size_t kFrameBytes = 2 + kFrameData + 1;  // address, code, data, check
inline constexpr std::size_t kMaxFrameCharacters = 1 + 2 * kFrameBytes + 2;

constexpr std::size_t frame_characters(Stop stop) {
  return 1 + 2 * kFrameBytes + (stop == Stop::lf ? 1 : 2);
}

struct Frame {
  std::uint8_t address = 0;
  std::uint8_t code = 0;
  std::array<std::uint8_t, kFrameData> data{};

  bool operator==(const Frame&) const = default;
};

// Over binary bytes. lrc: MODBUS, two's complement of the sum. crc8: 0x2F, init 0xFF, xorout 0xFF.
std::uint8_t check_value(Check check, std::span<const std::uint8_t> bytes) noexcept;

// Writes frame_characters(stop) characters into `out` and returns that part of it.
std::span<const std::uint8_t> encode(const Frame& frame, Check check, Stop stop,
                                     std::span<std::uint8_t, kMaxFrameCharacters> out) noexcept;

struct Received {
  Frame frame;
  TimeNs time_ns = 0;  // of the call that brought the frame's first character
};

struct ReceiverCounters {
  std::uint64_t bad_start = 0;      // runs of characters outside a frame
  std::uint64_t bad_length = 0;     // stop or start too early, or no stop where it must be
  std::uint64_t bad_character = 0;  // neither upper-case hexadecimal nor start nor stop
  std::uint64_t bad_check = 0;
  std::uint64_t overflows = 0;  // frames dropped, the oldest, because they were not taken
};

// Frames from a stream of bytes, split anywhere. A good frame is received after any bytes before
// it. Wrong ones are dropped silently and counted. At most kCapacity frames wait to be taken.
class Receiver {
 public:
  static constexpr std::size_t kCapacity = 16;

  Receiver(Check check, Stop stop) noexcept : check_(check), stop_(stop) {}

  void receive(std::span<const std::uint8_t> bytes, TimeNs now) noexcept;
  std::optional<Received> take() noexcept;  // the oldest
  void clear() noexcept;                    // discard partial and waiting frames; counters stay

  const ReceiverCounters& counters() const noexcept { return counters_; }

 private:
  enum class Place : std::uint8_t { outside, inside, skipping };

  void character(std::uint8_t c, TimeNs now) noexcept;
  std::size_t digits(std::span<const std::uint8_t> bytes) noexcept;
  void inside(std::uint8_t c, TimeNs now) noexcept;
  void begin(TimeNs now) noexcept;
  void finish() noexcept;
  void drop(std::uint64_t& cause, std::uint8_t last) noexcept;

  Check check_;
  Stop stop_;
  Place place_ = Place::outside;
  std::size_t characters_ = 0;  // of the frame begun, start included
  TimeNs begun_ns_ = 0;
  std::array<std::uint8_t, kFrameBytes> bytes_{};
  std::array<Received, kCapacity> received_{};  // ring
  std::size_t first_ = 0, waiting_ = 0;
  ReceiverCounters counters_;
};

}  // namespace lss::zebro
