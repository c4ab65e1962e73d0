#pragma once

// Entry of commands: the armour, an immediate answer when the newest state allows one, and the
// queue to the frame thread. Called by the DDS listener, one call at a time, on an ordinary thread.
//
// What stops a vehicle never waits behind anything else (decision 15):
//   emergency stops  to `stop_now` before anything else is done with them, answered at once; the
//                    newest goes to the frame by a slot of its own, ahead of all commands, those
//                    that it replaced there follow by a queue
//   stop, land       (CommandInfo::ends_motion) by a queue of their own, half of which only the
//                    holder of authority can fill
//   heartbeats       are state, not queue entries: the newest of anyone and of the holder
//   all others       by a queue, a quarter of which only the holder of authority can fill

#include <array>
#include <atomic>
#include <functional>
#include <span>
#include <utility>

#include "daemon/cycle/armour.h"
#include "daemon/cycle/supervisor.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/ring.h"

namespace lss {

class CommandPort {
 public:
  using Answer = std::function<void(const Ack&)>;

  static constexpr std::size_t kQueue = 64, kEnding = 16, kStops = 8;

  CommandPort(const Logic& logic, std::uint32_t lease_min_ms, std::uint32_t lease_max_ms,
              std::function<void()> stop_now = {})
      : logic_(logic),
        armour_(logic.commands, logic.tunables, lease_min_ms, lease_max_ms),
        stop_now_(std::move(stop_now)) {}

  // Listener. `writer`: the DDS writer that it came from.
  void receive(Request request, std::uint64_t writer, const Answer& answer);

  // Frame thread: the requests of this frame, in the order in which they are judged; how many.
  // Those that find no room wait for the next frame.
  std::uint32_t take(std::span<Request> out) noexcept;
  // Frame thread: the state from which the next answers are given.
  void show(const SupervisorState& state) noexcept { state_.put(state); }

  // Any thread.
  std::uint64_t refused() const noexcept { return refused_.load(std::memory_order_relaxed); }

 private:
  struct Beat {
    Name source{};
    TimeNs arrival_ns = 0;
    std::uint64_t count = 0;
  };
  struct Beats {
    Beat anyone, holder, another_daemon;  // anyone else than the holder
  };

  void heartbeat(const Request& request) noexcept;
  void emergency_stop(Request request, const Answer& answer);
  bool put(const Request& request) noexcept;
  bool is_newest() const noexcept;

  Logic logic_;
  Armour armour_;
  std::function<void()> stop_now_;  // empty: the frame is soon enough
  Latest<SupervisorState> state_;
  Beats beats_{};                               // listener
  std::array<std::uint64_t, 3> beats_taken_{};  // frame thread
  Latest<Beats> newest_beats_;
  Latest<Request> newest_stop_;
  Request last_stop_{};          // listener: the newest there
  Ring<Request, kStops> stops_;  // those that a newer one replaced in the same frame
  Ring<Request, kEnding> ending_;
  Ring<Request, kQueue> queue_;
  std::uint64_t commands_ = 0;  // given to the frame
  TimeNs stop_ns_ = 0;          // the newest emergency stop
  std::atomic<std::uint64_t> refused_{0};
};

}  // namespace lss
