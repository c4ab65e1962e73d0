#pragma once

// A serial line as raw bytes: 8 data bits, non-blocking, exclusive, RS-485 direction by the kernel
// driver where the hardware has it. One thread at a time, any; the bus thread polls fd() and calls
// read and write, which neither block nor allocate. A port that is lost is closed by its owner and
// opened again by path, so a symbolic link is resolved again each time.

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/serial/line_byte.h"

namespace lss {

// Character format of the line; always 8 data bits.
struct SerialFormat {
  enum class Parity : std::uint8_t { none, even };
  int baud = 115'200;
  Parity parity = Parity::none;  // even: bytes with wrong parity are marked, see read()
  int stop_bits = 1;             // or 2
  bool half_duplex = false;

  // Bits of one character on the wire.
  constexpr int bits() const { return 9 + (parity == Parity::even ? 1 : 0) + stop_bits; }
  bool operator==(const SerialFormat&) const = default;
};

class SerialPort {
 public:
  enum class Status : std::uint8_t {
    ok,
    absent,          // no such file, or no hardware (any more) behind it
    not_a_terminal,  // a file, directory or other device
    in_use,          // locked by another process, or by another port of this one
    denied,          // by its permissions
    bad_baud,        // a rate that the kernel or the hardware does not have
    bad_format,      // the hardware has no parity or not two stop bits
    failed,          // anything else; see error()
  };

  struct Transfer {
    std::size_t bytes = 0;
    bool lost = false;  // hung up or unplugged: close, and try to open again later
  };

  SerialPort() = default;
  ~SerialPort() { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  // Closes an open port first. Both queues begin empty. Takes a few system calls: milliseconds on
  // some USB adapters.
  Status open(const char* path, const SerialFormat& format) noexcept;
  Status open(const char* path, int baud, bool half_duplex) noexcept {  // 8N1
    return open(path, {.baud = baud, .half_duplex = half_duplex});
  }
  void close() noexcept;  // discards what the line has not taken

  Transfer read(std::span<std::uint8_t> into) noexcept;  // 0 bytes: nothing there
  // The same with the marks of parity errors decoded: required for a line with parity. 0 is
  // possible when only a part of a mark was read. At most kMostRaw at once.
  Transfer read(std::span<LineByte> into) noexcept;
  static constexpr std::size_t kMostRaw = 512;
  Transfer write(
      std::span<const std::uint8_t> bytes) noexcept;  // fewer bytes than given: the queue is full

  int fd() const noexcept { return fd_; }  // -1: closed
  bool is_open() const noexcept { return fd_ >= 0; }
  int error() const noexcept { return error_; }                   // errno of the last failure
  bool rs485_granted() const noexcept { return rs485_granted_; }  // the driver switches direction

 private:
  Status prepare(const SerialFormat& format) noexcept;
  Status set_line(const SerialFormat& format) noexcept;
  void set_rs485(bool half_duplex) noexcept;
  void set_low_latency() noexcept;
  void set_no_closing_wait() noexcept;
  void give_up() noexcept;
  Transfer outcome(std::ptrdiff_t result, bool zero_is_lost) noexcept;

  int fd_ = -1;
  int error_ = 0;
  bool rs485_granted_ = false;
  bool marked_ = false;  // the terminal marks parity errors
  ParityMarks marks_;
};

// The error and its remedy, for messages.
const char* text(SerialPort::Status status) noexcept;

}  // namespace lss
