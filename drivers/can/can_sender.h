#pragma once

// Lets one second thread send on a CAN bus that its bus thread owns, without waiting for it: the
// frame goes to the kernel in the call. CanPort::attach() connects it; from then on the bus
// thread's open() and close() offer and withdraw a duplicate of the port's descriptor.
//
// The handle is one atomic word that both sides exchange: the side that takes the descriptor out
// closes it. So a descriptor in use is never closed during the call, and the number of a closed
// one, which may be another file by then, is never written to. Both sides are wait-free. Datagrams
// of both threads count in one sequence; two at the same moment may arrive in either order.

#include <atomic>
#include <cstdint>

#include "drivers/can/cannelloni.h"
#include "drivers/can/frame.h"
#include "drivers/lockstep/wire.h"

namespace lss {

class CanSender {
 public:
  enum class Result : std::uint8_t {
    sent,
    closed,  // the bus is not open, or its generation() changed
    full,    // the kernel's queue is: try again
    failed,  // the interface is down, or the kernel refused the frame
  };
  struct Counters {
    std::uint64_t sent = 0;
    std::uint64_t closed = 0;
    std::uint64_t full = 0;
    std::uint64_t failed = 0;
  };

  CanSender() noexcept = default;
  ~CanSender() { withdraw(); }
  CanSender(const CanSender&) = delete;
  CanSender& operator=(const CanSender&) = delete;

  // The second thread. One at a time.
  Result send(const CanFrame& frame) noexcept;
  // Grows when the bus was opened (again) and when it came back from bus-off: any node may have
  // missed messages. Until it was called, send() does not write to the new one.
  std::uint32_t generation() noexcept {
    return seen_ = generation_.load(std::memory_order_acquire);
  }
  // Any thread.
  Counters counters() const noexcept;

  // The bus thread, by CanPort. `peer_address` and `peer_port` in network order, port 0: a CAN
  // interface.
  void offer(int fd, std::uint32_t peer_address, std::uint16_t peer_port) noexcept;
  void withdraw() noexcept;
  void renew() noexcept { generation_.fetch_add(1, std::memory_order_release); }
  // For the next datagram, of either thread.
  std::uint8_t next_sequence() noexcept {
    return sequence_.fetch_add(1, std::memory_order_relaxed);
  }
  void count_on(lockstep::Wire* wire) noexcept { wire_.store(wire); }  // of simulated time
  void restart_sequence() noexcept { sequence_.store(0, std::memory_order_relaxed); }

 private:
  Result put(std::uint64_t handle, const CanFrame& frame) noexcept;

  // Descriptor, address and port in one word; descriptors above 16 bits are not handed over.
  static constexpr std::uint64_t kNone = ~std::uint64_t{0};
  static constexpr std::uint64_t kTaken = kNone - 1;  // by the second thread, for one call
  static_assert(std::atomic<std::uint64_t>::is_always_lock_free);

  std::atomic<std::uint64_t> handle_{kNone};
  std::atomic<std::uint32_t> generation_{0};
  std::atomic<std::uint8_t> sequence_{0};
  CannelloniWriter writer_;  // these two of the second thread
  std::uint32_t seen_ = 0;
  std::atomic<lockstep::Wire*> wire_{nullptr};
  std::atomic<std::uint64_t> sent_{0}, closed_{0}, full_{0}, failed_{0};
};

}  // namespace lss
