#pragma once

// A carrier of CAN frames: a CAN interface of the kernel (socket_can.h) or datagrams (can_udp.h).
// CanPort chooses by the path. One thread at a time; nothing blocks or, once opened, allocates.

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/can/cannelloni.h"
#include "drivers/can/frame.h"

struct sockaddr_in;

namespace lss {

enum class CanStatus : std::uint8_t {
  ok,
  absent,       // no such interface, or no hardware (any more) behind it
  down,         // the interface is not up
  not_can,      // the interface is another type of network
  no_can,       // the kernel has no CAN
  bad_address,  // not udp://ADDRESS:PORT, nor the name of an interface
  not_local,    // an address of another machine
  in_use,       // another program has the local port
  denied,       // by permissions
  failed,       // anything else; see error()
};

enum class CanState : std::uint8_t {
  active,   // as last reported by the controller
  passive,  // too many errors: it goes on, the next may be bus-off
  bus_off,  // neither sends nor receives until it is restarted
};

struct CanCounters {
  std::uint64_t received = 0;   // frames handed up
  std::uint64_t filtered = 0;   // frames no filter passes, where the kernel does not filter
  std::uint64_t overflows = 0;  // lost in the kernel: not taken in time
  std::uint64_t sent = 0;
  std::uint64_t retries = 0;        // times that the kernel's queue was full
  std::uint64_t dropped_full = 0;   // frames to send: our queue was full
  std::uint64_t dropped_stale = 0;  // PDOs to send that waited for too long
  std::uint64_t send_errors = 0;    // frames that the kernel refused for another reason
  std::uint64_t error_frames = 0;
  std::uint64_t error_passive = 0;  // times
  std::uint64_t bus_offs = 0;       // times
  std::uint64_t restarts = 0;       // back from bus-off
  std::uint64_t foreign = 0;        // datagrams of another sender than the peer
  CannelloniCounters cannelloni{};  // of the peer's
};

class CanTransport {
 public:
  struct Received {
    std::size_t frames = 0;
    bool more = false;  // call again: poll may not report the remaining frames
    bool lost = false;  // down or unplugged: close, and try to open again later
  };
  struct Sent {
    std::size_t frames = 0;  // sent frames, from the first: fewer when the queue is full
    bool lost = false;
  };

  virtual ~CanTransport() = default;

  virtual CanStatus open(const char* path, std::span<const CanFilter> filters) noexcept = 0;
  virtual void close() noexcept = 0;
  virtual Received receive(std::span<CanFrame> into, CanCounters& counters) noexcept = 0;
  virtual Sent send(std::span<const CanFrame> frames, CanCounters& counters) noexcept = 0;

  int fd() const noexcept { return fd_; }        // -1: closed
  int error() const noexcept { return error_; }  // errno of the last failure
  CanState state() const noexcept { return state_; }

 protected:
  CanStatus failed() noexcept;  // what errno means
  void close_fd() noexcept;
  // One message of the socket: its size, or -1 with error(). `time_ns`: when the kernel had it.
  // `from`: its sender, where that is asked for.
  ssize_t take(std::span<std::uint8_t> into, TimeNs& time_ns, CanCounters& counters,
               sockaddr_in* from = nullptr) noexcept;

  int fd_ = -1;
  int error_ = 0;
  CanState state_ = CanState::active;
  std::uint32_t dropped_ = 0;  // by the kernel since the socket was opened
};

// CLOCK_MONOTONIC and CLOCK_REALTIME at the same moment, to convert the kernel's stamps.
struct CanClocks {
  TimeNs monotonic_ns = 0;
  TimeNs real_ns = 0;
};
CanClocks read_clocks() noexcept;

// Lets the kernel stamp arriving frames and report dropped ones. Stamping begins some milliseconds
// after the first socket of the machine asked; until then its stamps are of reading.
void ask_for_stamps(int fd) noexcept;

}  // namespace lss
