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

  // Lets a second thread send while the port is open. Before open().
  void attach(CanSender* sender) noexcept { sender_ = sender; }

  // Closes an open port first. Only frames that pass a filter are returned; without filters every
  // frame. `filters` must stay while the port is open; at most SocketCan::kMaxFilters.
  Status open(const char* path, std::span<const CanFilter> filters = {}) noexcept;
  void close() noexcept;

  // Received frames, oldest first. Call again while `more`.
  Received receive(std::span<CanFrame> into) noexcept;

  // Into the send queue (can_queue.h).
  void send(const CanFrame& frame, TimeNs now) noexcept;
  // Sends what the kernel takes. False: lost, close and open again later. While the kernel's queue
  // is full it is due again at next_wake().
  bool flush(TimeNs now) noexcept;
  TimeNs next_wake() const noexcept { return queue_.next_wake(); }

  int fd() const noexcept { return transport_ != nullptr ? transport_->fd() : -1; }  // -1: closed
  bool is_open() const noexcept { return fd() >= 0; }
  bool coming() noexcept { return udp_.coming(); }  // simulated time: what poll would report
  int error() const noexcept { return transport_ != nullptr ? transport_->error() : 0; }
  CanState state() const noexcept {
    return transport_ != nullptr ? transport_->state() : CanState::active;
  }
  // Since it was first opened. `restarts` grew: it came back from bus-off, and any node may have
  // missed messages.
  const CanCounters& counters() const noexcept { return counters_; }

 private:
  SocketCan socket_can_;
  CanUdp udp_;
  CanTransport* transport_ = nullptr;
  CanCounters counters_;
  CanQueue queue_;
  CanSender* sender_ = nullptr;
};

// The error and its remedy, for messages.
const char* text(CanStatus status) noexcept;

}  // namespace lss
