#pragma once

// The timing of a serial line: each character takes the time of its bits (10 by default), in both
// directions at once. Devices answer one turn-around time after the character that completes a
// request, or send by themselves. Uses no file descriptor and no clock: one thread passes both in.
// Also simulates the faults of a line.

#include <cstdint>
#include <deque>
#include <random>
#include <span>
#include <vector>

#include "drivers/time.h"
#include "tools/lss-sim/frame/faults.h"

namespace lss::sim {

// The devices on the line. Called from the line's thread.
class LineDevice {
 public:
  virtual ~LineDevice() = default;
  // A complete character from the master. Returns the frame that answers it, empty for none; the
  // span is valid until the next call.
  virtual std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) = 0;
  // The next unrequested frame, empty for none; valid until the next call.
  virtual std::span<const std::uint8_t> send(TimeNs) { return {}; }
  virtual bool wants_to_send() const { return false; }  // from any thread
};

// Types: noise, drop, duplicate, late, bus-cut.
std::span<const FaultKind> line_fault_kinds();
// The same for a vehicle that also has a CAN bus, by the number of the line: line-noise, line-drop,
// line-duplicate, line-late, line-cut, line-unplug.
std::span<const FaultKind> numbered_line_fault_kinds();

class Uart {
 public:
  struct Parameters {
    int baud = 115'200;
    int bits = 10;         // of a character, with start, parity and stop
    bool paced = true;     // false: every character arrives at once
    std::size_t fifo = 8;  // of the master's UART: it passes on so many characters at once
    std::uint8_t frame_begin = ':';
    std::uint8_t frame_end = '\n';
    unsigned seed = 1;
  };

  Uart(const Parameters& parameters, LineDevice& device);

  // Characters that the master has written.
  void from_master(std::span<const std::uint8_t> characters, TimeNs now);
  // Passes the received characters to the device, and queues its replies and unrequested frames.
  void advance(TimeNs now);
  // The characters of replies whose last bit has been sent by now, in pieces of up to `fifo`, but
  // the end of a frame at its own time.
  std::span<const std::uint8_t> take(TimeNs now);
  // The time of the next work for advance or take; the far future when there is none.
  TimeNs next_wake() const;
  void forget();  // the line was unplugged

  WireFaults faults;

 private:
  struct Timed {
    TimeNs at_ns;
    std::uint8_t character;
  };

  void say(std::span<const std::uint8_t> frame, TimeNs now);
  void queue(std::span<const std::uint8_t> frame, TimeNs now);
  std::uint8_t through_noise(std::uint8_t character);

  Parameters parameters_;
  LineDevice& device_;
  TimeNs character_ns_;
  std::mt19937 random_;
  std::deque<Timed> arriving_, leaving_;
  TimeNs master_free_ns_ = 0, reply_free_ns_ = 0;
  bool dropping_ = false;  // the current frame of the master
  std::vector<std::uint8_t> taken_;
};

}  // namespace lss::sim
