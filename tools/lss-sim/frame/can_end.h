#pragma once

// The master's end of a CAN bus: a UDP socket with frames in cannelloni datagrams
// ("udp://127.0.0.1:20000"), which answers the last sender, or a SocketCAN interface ("vcan0").
// Either takes frames of every program on the machine: a daemon that starts again has another port.
// Used by one thread at a time.

#include <netinet/in.h>

#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/can/cannelloni.h"
#include "drivers/file.h"
#include "drivers/lockstep/wire.h"

namespace lss::sim {

class CanEnd {
 public:
  explicit CanEnd(std::string address) : address_(std::move(address)) {}

  // The error names the failure and the remedy.
  tl::expected<void, std::string> open();
  void close();
  bool is_open() const { return static_cast<bool>(file_); }

  // Frames from the master; empty when none wait. Valid until the next call.
  std::span<const CanFrame> read();
  // Unread frames are lost, as on a wire.
  void write(std::span<const CanFrame> frames);

  int fd() const { return file_.get(); }
  // As given; a port of 0 is replaced by the one that the kernel chose.
  const std::string& address() const { return address_; }

 private:
  tl::expected<void, std::string> open_udp();
  tl::expected<void, std::string> open_interface();
  void read_udp();
  void read_interface();
  void send_datagram();

  std::string address_;
  File file_;
  bool udp_ = false;
  lockstep::Wire wire_{lockstep::Wire::Side::simulator};  // counts datagrams
  std::uint32_t heard_ = 0;            // openings of the other end, at its last message
  std::optional<sockaddr_in> master_;  // the last sender
  CannelloniReader reader_;
  CannelloniWriter writer_;
  std::vector<CanFrame> frames_;
};

}  // namespace lss::sim
