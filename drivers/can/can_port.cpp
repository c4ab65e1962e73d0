#include "drivers/can/can_port.h"

#include <string_view>

namespace lss {
CanStatus CanPort::open(const char* path, std::span<const CanFilter> filters) noexcept {
  close();
  if (std::string_view(path).starts_with(CanUdp::kScheme)) {
    transport_ = &udp_;
    udp_.number_by(sender_);
    if (sender_ != nullptr) sender_->count_on(&udp_.wire());
  } else {
    transport_ = &socket_can_;
  }
  const Status status = transport_->open(path, filters);
  if (status == Status::ok && sender_ != nullptr) {
    const bool datagrams = transport_ == &udp_;
    sender_->offer(fd(), datagrams ? udp_.peer_address() : 0, datagrams ? udp_.peer_port() : 0);
  }
  return status;
}

void CanPort::close() noexcept {
  if (sender_ != nullptr) sender_->withdraw();
  if (transport_ != nullptr) transport_->close();
  queue_.clear();
}

CanPort::Received CanPort::receive(std::span<CanFrame> into) noexcept {
  if (!is_open() || into.empty()) return {};
  const CanState before = transport_->state();
  const std::uint64_t restarts = counters_.restarts;
  const Received received = transport_->receive(into, counters_);
  if (sender_ != nullptr && counters_.restarts != restarts) sender_->renew();
  // Waiting frames were for the bus before bus-off.
  if (before != CanState::bus_off && transport_->state() == CanState::bus_off) {
    counters_.dropped_stale += queue_.size();
    queue_.clear();
  }
  return received;
}

void CanPort::send(const CanFrame& frame, TimeNs now) noexcept {
  if (is_open()) queue_.push(frame, now, counters_);
}

bool CanPort::flush(TimeNs now) noexcept {
  return !is_open() || queue_.flush(*transport_, now, counters_);
}

const char* text(CanStatus status) noexcept {
  constexpr const char* kTexts[] = {
      // in the order of CanStatus
      "open",
      "there is no such interface: plug it in, or name another in the config",
      "the interface is down: ip link set NAME up type can bitrate 500000 restart-ms 100",
      "it is no CAN interface: name another in the config",
      "this kernel has no CAN: load the modules can and can_raw, or use a kernel with them",
      "it is neither the name of an interface nor udp://ADDRESS:PORT, with ?local=PORT if "
      "need be: correct it in the config",
      "datagrams to other machines are not allowed: use an address of 127.0.0.0/8",
      "another program has the local port: stop that one first, or name another port",
      "no permission: the sandbox of the service must allow AF_CAN, ports below 1024 need "
      "root",
      "it could not be opened"};
  return kTexts[static_cast<std::size_t>(status)];
}

}  // namespace lss
