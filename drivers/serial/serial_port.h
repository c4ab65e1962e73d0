#pragma once

// A serial line as raw bytes: 8N1, non-blocking, exclusive, RS-485 direction by the kernel driver
// where the hardware has it. One thread at a time, any; the bus thread polls fd() and calls read
// and write, which neither block nor allocate. A port that is lost is closed by its owner and
// opened again by path, so a symbolic link is followed anew each time.

#include <cstddef>
#include <cstdint>
#include <span>

namespace lss {

class SerialPort {
 public:
  enum class Status : std::uint8_t {
    ok,
    absent,          // no such file, or no hardware (any more) behind it
    not_a_terminal,  // a file, directory or other device
    in_use,          // locked by another process, or by another port of this one
    denied,          // by its permissions
    bad_baud,        // a rate that the kernel or the hardware does not have
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

  // Closes what was open. Both queues begin empty. Takes a few system calls: milliseconds on some
  // USB adapters.
  Status open(const char* path, int baud, bool half_duplex) noexcept;
  void close() noexcept;

  Transfer read(std::span<std::uint8_t> into) noexcept;  // 0 bytes: nothing there
  Transfer write(
      std::span<const std::uint8_t> bytes) noexcept;  // fewer bytes than given: the queue is full

  int fd() const noexcept { return fd_; }  // -1: closed
  bool is_open() const noexcept { return fd_ >= 0; }
  int error() const noexcept { return error_; }                   // errno of the last failure
  bool rs485_granted() const noexcept { return rs485_granted_; }  // the driver switches direction
  bool low_latency_granted() const noexcept { return low_latency_granted_; }

 private:
  Status prepare(int baud, bool half_duplex) noexcept;
  Status set_line(int baud) noexcept;
  void set_rs485(bool half_duplex) noexcept;
  void set_low_latency() noexcept;
  Transfer outcome(std::ptrdiff_t result, bool zero_is_lost) noexcept;

  int fd_ = -1;
  int error_ = 0;
  bool rs485_granted_ = false;
  bool low_latency_granted_ = false;
};

// What is wrong and what to do, for messages.
const char* text(SerialPort::Status status) noexcept;

}  // namespace lss
