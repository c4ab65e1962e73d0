#pragma once

// A serial line as time: each character takes its bits (10 unless told otherwise) in each
// direction, both directions at once, and the devices on it answer one turn-around after the
// character that they answer to, or speak unasked. Knows no file descriptor and no clock: one
// thread passes both in. Also the faults that a line can have.

#include <cstdint>
#include <deque>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "drivers/time.h"
#include "tools/lss-sim/faults.h"

namespace lss::sim {

// What hangs on the line. Called from the line's thread.
class LineDevice {
 public:
  virtual ~LineDevice() = default;
  // A character of the master, received whole. Returns the frame that answers it, empty for none;
  // the span is valid until the next call.
  virtual std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) = 0;
  // The next frame that it says unasked, empty for none; valid until the next call.
  virtual std::span<const std::uint8_t> send(TimeNs) { return {}; }
  virtual bool wants_to_send() const { return false; }  // from any thread
};

// Kinds: noise, drop, duplicate, late, bus-cut.
std::span<const FaultKind> line_fault_kinds();
// The same of a vehicle that has a CAN bus besides, by the number of the line: line-noise,
// line-drop, line-duplicate, line-late, line-cut, line-unplug.
std::span<const FaultKind> numbered_line_fault_kinds();

struct LineFaults {
  double noise = 0;      // probability that a character loses a bit
  double drop = 0;       // ... that a frame is lost whole, either direction
  double duplicate = 0;  // ... that a reply comes twice
  TimeNs late_ns = 0;    // replies come so much later
  bool cut = false;      // nothing passes, either direction

  // Of either sort of kinds. False when the fault is not one of the line.
  bool set(const Fault& fault, bool attach);
};

class Uart {
 public:
  struct Parameters {
    int baud = 115'200;
    int bits = 10;      // of a character, with start, parity and stop
    bool paced = true;  // false: every character arrives at once
    std::uint8_t frame_begin = ':';
    std::uint8_t frame_end = '\n';
    unsigned seed = 1;
  };

  Uart(const Parameters& parameters, LineDevice& device);

  // Characters that the master has written.
  void from_master(std::span<const std::uint8_t> characters, TimeNs now);
  // Gives the device what has arrived by now, and queues its replies and what it says unasked.
  void advance(TimeNs now);
  // The characters of replies whose last bit has left by now; in pieces of up to kPiece as the FIFO
  // of a UART hands them over, a frame's end at its own instant.
  std::span<const std::uint8_t> take(TimeNs now);
  // When advance or take have something to do; the far future when nothing is under way.
  TimeNs next_wake() const;
  void forget();  // the line was unplugged

  LineFaults faults;

 private:
  static constexpr std::size_t kPiece = 8;
  struct Timed {
    TimeNs at_ns;
    std::uint8_t character;
  };

  void say(std::span<const std::uint8_t> frame, TimeNs now);
  void queue(std::span<const std::uint8_t> frame, TimeNs now);
  std::uint8_t through_noise(std::uint8_t character);
  bool chance(double probability);

  Parameters parameters_;
  LineDevice& device_;
  TimeNs character_ns_;
  std::mt19937 random_;
  std::deque<Timed> arriving_, leaving_;
  TimeNs master_free_ns_ = 0, reply_free_ns_ = 0;
  bool dropping_ = false;  // the frame of the master that is under way
  std::vector<std::uint8_t> taken_;
};

}  // namespace lss::sim
