#pragma once

// A CAN bus by its path: the name of an interface (`can0`) or the address of a simulator
// (`udp://127.0.0.1:PORT`). One thread at a time, any; the bus thread polls fd() and calls receive,
// send and flush, which neither block nor allocate. A port that is lost is closed by its owner and
// opened again by path, so an interface that comes back under its name is found.
//
// The interface is set up outside: its rate, and `restart-ms` so that it comes back from bus-off by
// itself: `ip link set can0 up type can bitrate 500000 restart-ms 100`.

#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/can/can_queue.h"
#include "drivers/can/can_sender.h"
#include "drivers/can/can_udp.h"
#include "drivers/can/socket_can.h"
#include "drivers/can/transport.h"

namespace lss {

class CanPort {
 public:
  using Status = CanStatus;
  using Received = CanTransport::Received;

  CanPort() = default;
  CanPort(const CanPort&) = delete;
  CanPort& operator=(const CanPort&) = delete;

  // A second thread sends by it while the port is open. Before open().
  void attach(CanSender* sender) noexcept { sender_ = sender; }

  // Closes what was open. Frames that no filter passes are not handed up; no filter at all: every
  // frame is. `filters` must stay while the port is open; at most SocketCan::kMaxFilters.
  Status open(const char* path, std::span<const CanFilter> filters = {}) noexcept;
  void close() noexcept;

  // Frames that have come, oldest first. Call again while `more`.
  Received receive(std::span<CanFrame> into) noexcept;

  // Into the queue of what goes out (can_queue.h).
  void send(const CanFrame& frame, TimeNs now) noexcept;
  // Sends what the kernel takes. False: lost, close and open again later. While the kernel's queue
  // is full it is due again at next_wake().
  bool flush(TimeNs now) noexcept;
  TimeNs next_wake() const noexcept { return queue_.next_wake(); }

  int fd() const noexcept { return transport_ != nullptr ? transport_->fd() : -1; }  // -1: closed
  bool is_open() const noexcept { return fd() >= 0; }
  int error() const noexcept { return transport_ != nullptr ? transport_->error() : 0; }
  CanState state() const noexcept {
    return transport_ != nullptr ? transport_->state() : CanState::active;
  }
  // Since it was first opened. `restarts` grew: it came back from bus-off, and whoever is on the
  // bus may have missed anything.
  const CanCounters& counters() const noexcept { return counters_; }

 private:
  SocketCan socket_can_;
  CanUdp udp_;
  CanTransport* transport_ = nullptr;
  CanCounters counters_;
  CanQueue queue_;
  CanSender* sender_ = nullptr;
};

// What is wrong and what to do, for messages.
const char* text(CanStatus status) noexcept;
const char* text(CanState state) noexcept;

}  // namespace lss
