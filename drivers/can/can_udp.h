#pragma once

// CAN frames in datagrams to and from one peer on this machine, a simulator: cannelloni.h.

#include <array>

#include "drivers/can/can_sender.h"
#include "drivers/can/transport.h"
#include "drivers/lockstep/wire.h"

namespace lss {

class CanUdp final : public CanTransport {
 public:
  static constexpr const char* kScheme = "udp://";

  ~CanUdp() override { close_fd(); }

  // udp://127.0.0.1:PORT, with ?local=PORT2 for a fixed port of our own. Loopback only: the
  // datagrams carry no proof of their sender.
  CanStatus open(const char* address, std::span<const CanFilter> filters) noexcept override;
  void close() noexcept override {
    wire_.close();
    close_fd();
  }
  Received receive(std::span<CanFrame> into, CanCounters& counters) noexcept override;
  Sent send(std::span<const CanFrame> frames, CanCounters& counters) noexcept override;

  std::uint32_t peer_address() const noexcept { return peer_address_; }  // network order
  std::uint16_t peer_port() const noexcept { return peer_port_; }
  // Numbers datagrams together with those of a second thread. nullptr: alone.
  void number_by(CanSender* sender) noexcept { sender_ = sender; }
  bool coming() noexcept { return wire_.coming(); }
  lockstep::Wire& wire() noexcept { return wire_; }

 private:
  enum class Datagram : std::uint8_t { none, read, skipped, lost };
  Datagram next_datagram(CanCounters& counters) noexcept;
  bool passes(const CanFrame& frame) const noexcept;

  std::uint32_t peer_address_ = 0;  // network order
  std::uint16_t peer_port_ = 0;     // network order
  std::span<const CanFilter> filters_;
  std::array<std::uint8_t, kMaxDatagram + 1> bytes_{};  // one more shows truncation
  TimeNs time_ns_ = 0;                                  // of the datagram that is being read
  CannelloniReader reader_;
  CannelloniWriter writer_;
  CanSender* sender_ = nullptr;
  lockstep::Wire wire_{lockstep::Wire::Side::daemon};  // counts datagrams
};

}  // namespace lss
