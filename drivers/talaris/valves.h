#pragma once

// Timing of the valves. The actuate thread asks when the next edge is, sleeps until then and writes
// the frame itself (TALARIS thesis 4.4.6: a valve is open while it is enabled and the time is
// between mDelay = release + delay and mOn = mDelay + on). Pure: orders and time in, frames out;
// nothing allocates, locks or logs. One thread.
//
//   release(orders, now) at every release; then, and whenever next_wake() has come:
//     while (due(now, frame)) sent(sender.send(frame) == sent, now);
//
// - Edges of new orders replace all earlier ones: an open valve is shut at the release unless the
//   new pulse begins with it.
// - Orders that are released again, the frame being late, pulse again, but not a third time.
// - Edges of one instant are one frame; each frame has the state of all eight valves.
// - While a valve is open the frame is sent again every `renew_ns`, since the node shuts what is
//   not renewed; at each release it is always sent.
// - Orders older than `stale_after_ns`, a port that was opened again, an all-stop: everything is
//   shut at once; an all-stop also turns the fans off. The caller decides what may be released
//   after an all-stop, and when.

#include <array>
#include <cstdint>

#include "drivers/can/frame.h"
#include "drivers/talaris/orders.h"

namespace lss::talaris {

struct ValveParameters {
  std::uint8_t node = 0x20;
  std::uint8_t fan_node = 0x21;  // at an all-stop
  TimeNs frame_ns = 200 * kMillisecond;
  TimeNs renew_ns = 50 * kMillisecond;
  TimeNs retry_ns = kMillisecond;  // of a frame that could not be sent
  TimeNs stale_after_ns = 450 * kMillisecond;
  // A pulse to the end of the frame stays open for so long when the next release is late: a valve
  // that is open throughout does not flicker.
  TimeNs carry_ns = 10 * kMillisecond;
};

// Command to the valve node. Sequence 0 shuts everything and is out of the count 1..255.
CanFrame valve_frame(std::uint8_t node, std::uint8_t bits, std::uint8_t sequence) noexcept;
// Command to the fan node; widths are clipped to 1000..2000 us.
CanFrame fan_frame(std::uint8_t node,
                   const std::array<std::uint16_t, kHopperFans>& fan_us) noexcept;

struct ValveCounters {
  std::uint64_t frames = 0;  // sent
  std::uint64_t edges = 0;   // of single valves
  std::uint64_t failed = 0;  // could not be sent; tried again
  std::uint64_t stale = 0;   // everything was shut, orders being old
  std::uint64_t all_stops = 0;
  std::uint64_t restarts = 0;
  TimeNs worst_late_ns = 0;                           // a frame with an edge, behind its time
  std::array<std::uint64_t, kHopperValves> pulses{};  // times opened
  std::array<TimeNs, kHopperValves> open_ns{};        // in all, as sent
};

class ValveSequencer {
 public:
  static constexpr TimeNs kNever = INT64_MAX;

  explicit ValveSequencer(const ValveParameters& parameters = {}) noexcept;

  // The port was opened (again) or came back from bus-off: shut first; earlier orders are void.
  void reopened(TimeNs now) noexcept;
  // Nothing in the memory of this object can be trusted: the same, with counters and open valves as
  // they were reported last.
  void begin_again(const ValveParameters& parameters, const ValveCounters& counters,
                   std::uint8_t open, TimeNs now) noexcept;
  // Orders of a frame, at its release.
  void release(const TalarisOrders& orders, TimeNs now) noexcept;
  // At once, before the frame knows.
  void all_stop(TimeNs now) noexcept;

  // When to call due() again.
  TimeNs next_wake() const noexcept { return next_ns_; }
  // True: `frame` is to be sent now; then call sent().
  bool due(TimeNs now, CanFrame& frame) noexcept;
  void sent(bool ok, TimeNs now) noexcept;

  std::uint8_t bits_at(TimeNs time) const noexcept;     // by the orders in force
  std::uint8_t open() const noexcept { return sent_; }  // as last sent
  const ValveCounters& counters() const noexcept { return counters_; }

 private:
  struct Window {
    TimeNs from_ns = 0, to_ns = 0;
  };

  void force(TimeNs now) noexcept;
  bool stale(TimeNs time) const noexcept;
  TimeNs edge_after(TimeNs time) const noexcept;
  void plan() noexcept;
  std::uint8_t next_sequence() const noexcept;
  void count(std::uint8_t bits, TimeNs now) noexcept;

  ValveParameters parameters_;
  TalarisOrders orders_{};
  std::array<Window, kHopperValves> window_{};  // of the pulses
  bool told_stale_ = true;
  bool forced_ = false;          // to be sent, even if unchanged
  bool fans_due_ = false;        // off, after an all-stop
  TimeNs forced_ns_ = 0;         // since when
  TimeNs checked_ns_ = 0;        // all edges up to here have been sent
  TimeNs retry_ns_ = INT64_MIN;  // not before
  TimeNs last_ns_ = 0;           // when the last frame was sent
  TimeNs next_ns_ = kNever;
  std::uint8_t sent_ = 0;  // bits, as last sent
  std::uint8_t sequence_ = 0;
  bool begins_ = false;        // the node's count is not known: the next frame has sequence 0
  bool fans_pending_ = false;  // what due() returned
  std::uint8_t pending_ = 0;
  ValveCounters counters_{};
};

}  // namespace lss::talaris
