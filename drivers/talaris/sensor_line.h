#pragma once

// A sensor on a serial line for its bus thread: bytes and time in, samples and bytes to write out.
// Knows no file descriptor and no thread. Nothing here allocates, locks or logs.
//
// Stamps. Bytes are read some time after they arrived, several at once: the arrival of a byte is
// the time of the read less one character time for each byte behind it, and its start bit one
// character before that. What remains is the wake-up delay, which only makes a stamp late;
// LandMark30 removes it with the sensor's own rhythm (landmark30.h).

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/sample_ring.h"
#include "drivers/serial/line_byte.h"
#include "drivers/serial/serial_port.h"
#include "drivers/talaris/samples.h"

namespace lss::talaris {

struct LineCounters {
  std::uint64_t bytes = 0;
  std::uint64_t packets = 0;      // good ones, or lines; with those that report an error
  std::uint64_t lost = 0;         // missing by the sensor's counter, or polled and not answered
  std::uint64_t repeated = 0;     // rejected: the counter did not change
  std::uint64_t parity = 0;       // rejected: a byte was marked
  std::uint64_t bad_check = 0;    // rejected: sum, or no number
  std::uint64_t skipped = 0;      // bytes between packets
  std::uint64_t said_errors = 0;  // altimeter: lines with an error
  std::uint64_t out_of_range = 0;
  std::uint64_t commands = 0;   // written to the sensor
  std::uint64_t restarts = 0;   // restarts, the sensor being silent
  std::uint64_t overflows = 0;  // samples that were not taken

  std::uint64_t errors() const { return parity + bad_check + repeated + out_of_range; }
};

struct LineStatus {
  LineCounters counters{};
  TimeNs heard_ns = 0;         // stamp of the last good packet; 0: never
  double rate_unit_rad_s = 0;  // IMU: factors in force
  double force_unit_m_s2 = 0;
};

// A frame begins: its first packet by the sensor's own count arrived, or the first one after that.
struct FrameTick {
  std::uint64_t index = 0;  // counts frames from 1, with gaps where all packets of one were lost
  TimeNs time_ns = 0;       // of the first byte of the packet that begins it, received or not
};

class SensorLine {
 public:
  static constexpr std::size_t kMaxSamples = 64;

  explicit SensorLine(const SerialFormat& format) noexcept;
  virtual ~SensorLine() = default;
  SensorLine(const SensorLine&) = delete;
  SensorLine& operator=(const SensorLine&) = delete;

  const SerialFormat& format() const noexcept { return format_; }
  // The port was opened (again): discards partial data, sends the first commands.
  virtual void restart(TimeNs now) noexcept = 0;
  // Bytes that were read at `now`, split anywhere.
  virtual void receive(std::span<const LineByte> bytes, TimeNs now) noexcept = 0;
  // Bytes to write now, valid until the next call; empty: nothing is due. Call until it is empty.
  virtual std::span<const std::uint8_t> transmit(TimeNs now) noexcept = 0;
  virtual TimeNs next_wake() const noexcept = 0;  // INT64_MAX: never

  // Samples since the last call; at most kMaxSamples are kept, the oldest dropped.
  std::size_t take(std::span<TalarisSample> out) noexcept { return samples_.take(out); }
  // IMUs: the newest frame that began since the last call.
  bool take_tick(FrameTick& tick) noexcept;
  const LineStatus& status() const noexcept { return status_; }

 protected:
  // A byte that is no packet yet.
  struct Held {
    LineByte byte{};
    TimeNs time_ns = 0;  // it began on the line
  };
  // Takes away so many bytes at the front of `size`.
  template <std::size_t N>
  static void drop(std::array<Held, N>& held, std::size_t& size, std::size_t bytes) noexcept {
    std::copy(held.data() + bytes, held.data() + size, held.data());
    size -= bytes;
  }

  void keep(const TalarisSample& sample) noexcept;
  // A packet of the IMU, by the sensor's own count.
  void tick(std::uint64_t count, TimeNs time_ns, int packets_per_frame, TimeNs period_ns) noexcept;
  void clear() noexcept;  // samples, and where the frame was
  // When byte `i` of `count` that were read at `now` began on the line.
  TimeNs arrival_ns(TimeNs now, std::size_t i, std::size_t count) const noexcept {
    return now - static_cast<TimeNs>(count - i) * byte_ns_;
  }

  LineStatus status_{};

 private:
  SerialFormat format_;
  TimeNs byte_ns_;  // of one character
  SampleRing<TalarisSample, kMaxSamples> samples_;
  FrameTick tick_{};
  bool ticked_ = false;
};

// Of one character.
constexpr TimeNs byte_time_ns(const SerialFormat& format) {
  return format.bits() * kSecond / format.baud;
}

}  // namespace lss::talaris
