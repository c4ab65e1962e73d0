#pragma once

// A CAN interface of the kernel (SocketCAN), for example can0 or vcan0.

#include <array>

#include "drivers/can/transport.h"

struct can_frame;

namespace lss {

can_frame to_kernel(const CanFrame& frame) noexcept;

class SocketCan final : public CanTransport {
 public:
  ~SocketCan() override { close_fd(); }

  CanStatus open(const char* interface, std::span<const CanFilter> filters) noexcept override;
  void close() noexcept override { close_fd(); }
  Received receive(std::span<CanFrame> into, CanCounters& counters) noexcept override;
  Sent send(std::span<const CanFrame> frames, CanCounters& counters) noexcept override;

  static constexpr std::size_t kMaxFilters = 16;

 private:
  CanStatus prepare(const char* interface, std::span<const CanFilter> filters) noexcept;
  void told(const CanFrame& error, CanCounters& counters) noexcept;
};

}  // namespace lss
