#pragma once

// Where commands enter: the armour, an answer at once when the newest state allows one, and the
// queue to the frame thread. Called by the DDS listener, one call at a time, on an ordinary thread.
// An emergency stop that passed the armour is told to `stop_now` besides, before anything else is
// done with it: a vehicle with long frames cannot wait for the next.

#include <atomic>
#include <functional>
#include <utility>

#include "daemon/core/armour.h"
#include "daemon/core/latest.h"
#include "daemon/core/ring.h"
#include "daemon/core/supervisor.h"

namespace lss {

class CommandPort {
 public:
  using Answer = std::function<void(const Ack&)>;

  CommandPort(const Logic& logic, std::uint32_t lease_min_ms, std::uint32_t lease_max_ms,
              std::function<void()> stop_now = {})
      : logic_(logic),
        armour_(logic.command, lease_min_ms, lease_max_ms),
        stop_now_(std::move(stop_now)) {}

  // Listener.
  void receive(Request request, const Answer& answer);

  // Frame thread: requests for this frame, and the state the next answers are given from.
  bool pop(Request& request) noexcept { return queue_.pop(request); }
  void show(const SupervisorState& state) noexcept { state_.put(state); }

  // Any thread.
  std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  Logic logic_;
  Armour armour_;
  std::function<void()> stop_now_;  // empty: the frame is soon enough
  Latest<SupervisorState> state_;
  Ring<Request, 64> queue_;
  std::uint64_t pushed_ = 0;  // commands, not heartbeats
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace lss
