#pragma once

// Frames that wait for the kernel's queue, bounded: the bus thread never waits for the bus. Nothing
// allocates.

#include <array>
#include <cstddef>

#include "drivers/can/transport.h"

namespace lss {

class CanQueue {
 public:
  static constexpr std::size_t kLength = 128;
  // PDOs that could not be sent for so long are dropped: newer ones follow.
  static constexpr TimeNs kStale = 50 * kMillisecond;
  static constexpr TimeNs kRetry = kMillisecond;  // of a full queue of the kernel
  static constexpr TimeNs kNever = INT64_MAX;

  // When the queue is full, drops and counts the oldest PDO, or without one the oldest frame.
  void push(const CanFrame& frame, TimeNs now, CanCounters& counters) noexcept;
  // Passes on what the transport takes, in the order of push(). False: it is lost.
  bool flush(CanTransport& transport, TimeNs now, CanCounters& counters) noexcept;
  void clear() noexcept;

  TimeNs next_wake() const noexcept { return retry_ns_; }  // of flush(); kNever: nothing waits
  std::size_t size() const noexcept { return count_; }

 private:
  struct Waiting {
    CanFrame frame;
    TimeNs since_ns = 0;
  };
  Waiting& at(std::size_t i) noexcept { return ring_[(first_ + i) % kLength]; }
  template <class Drops>
  void drop_if(Drops drops) noexcept;

  std::array<Waiting, kLength> ring_{};
  std::size_t first_ = 0, count_ = 0;
  TimeNs retry_ns_ = kNever;
};

}  // namespace lss
