#pragma once

// Master of the RS-485 bus of Lunar Zebro: sends orders, receives replies, and checks whether the
// modules follow their orders. Knows only bytes and time, no file descriptor and no thread: the bus
// thread passes both in, so tests drive it without either. Nothing here allocates, locks or logs.
// Schedule of messages: docs/icd-zebro.md sections 8 to 10.
//
// The orders are a desired state per module, not a queue: a newer order replaces an older one; an
// order contradicted by the module's own report is sent again, up to the re-send limit. (Zebro
// thesis 5.2.1: "the LC must periodically monitor if the desired commands are actually executed".)
//
// Stop first: when the bus begins, when the port came back and when orders are stale it sends the
// emergency stop to all by itself. An order that was given before an emergency stop is never sent
// after it: motion needs a new serial.

#include <array>
#include <cstdint>
#include <span>

#include "drivers/time.h"
#include "drivers/zebro/ascii_codec.h"
#include "drivers/zebro/leg_module.h"

namespace lss::zebro {

struct LegBusParameters {
  int baud = 115'200;
  bool half_duplex = false;
  Check check = Check::lrc;
  Stop stop = Stop::lf;
  TimeNs period_ns = 20 * kMillisecond;  // of the bus cycle; what does not fit waits for the next
  // From the end of the request on the wire; half duplex waits for it.
  TimeNs reply_timeout_ns = 5 * kMillisecond;
  int resend_limit = 5;
  // Orders older than this: the bus stops everything by itself.
  TimeNs stale_after_ns = 100 * kMillisecond;
  std::array<std::uint8_t, kBusModules> address = {1, 2, 3, 4, 5, 6, 7};
};

struct ModuleOrder {
  enum class Kind : std::uint8_t {
    none,            // nothing was ever ordered: poll only
    motion_off,      // stop motion control
    motion_on,       // start motion control, hold
    rotate_forward,  // to position, arriving at arrive_ns; motion control stays as it is
    rotate_backward,
    emergency_stop,  // motion control off, at once
    reset,           // reset the driver
  };
  Kind kind = Kind::none;
  std::uint16_t position_cdeg = 0;  // 0.01 deg, below kTurn_cdeg
  TimeNs arrive_ns = 0;             // the delta time is computed when the frame goes on the wire
  std::uint32_t serial = 0;         // a new number is a new order; begins at 1

  bool operator==(const ModuleOrder&) const = default;
  bool rotates() const { return kind == Kind::rotate_forward || kind == Kind::rotate_backward; }
};

struct BusOrders {
  TimeNs issued_ns = 0;  // when the frame computed them, to check freshness
  // A new number: emergency stop to all first, then only new orders.
  std::uint32_t emergency_serial = 0;
  std::array<ModuleOrder, kBusModules> module{};
  bool operator==(const BusOrders&) const = default;
};

// These orders neither move nor hold any module.
bool stops_all(const BusOrders& orders) noexcept;

// A reply of a module, stamped with the arrival of the first byte of the frame.
struct ModuleReply {
  TimeNs time_ns = 0;
  std::uint8_t module = 0;  // index 0..6, not the address
  std::uint8_t code = 0;    // of leg_module.h: status, health or identity
  std::array<std::uint8_t, 8> data{};
};

// State of a module besides its replies.
struct ModuleLink {
  std::uint64_t requests = 0;
  std::uint64_t replies = 0;
  std::uint64_t resends = 0;
  std::uint64_t resets = 0;  // ordered and confirmed
  bool disobeys = false;     // the re-send limit is used up; cleared by a new order
};

struct BusCounters {
  std::uint64_t cycles = 0;  // begun
  std::uint64_t frames_sent = 0;
  std::uint64_t frames_received = 0;  // replies that were asked for
  std::uint64_t frames_dropped = 0;   // all of those below
  std::uint64_t bad_start = 0;
  std::uint64_t bad_length = 0;
  std::uint64_t bad_character = 0;
  std::uint64_t bad_check = 0;
  std::uint64_t unexpected = 0;     // well formed, but not requested
  std::uint64_t overflows = 0;      // replies that were not taken
  std::uint64_t safe_commands = 0;  // stops of all by itself, orders being stale
  TimeNs cycle_ns = 0;  // last time from release to the last of the seven status replies
  std::array<ModuleLink, kBusModules> module{};
};

class LegBus {
 public:
  explicit LegBus(const LegBusParameters& parameters) noexcept;

  // The port was opened (again): discards partial messages and stops all modules, since they may
  // still follow earlier orders. Earlier motion is not resumed.
  void restart(TimeNs now) noexcept;

  // New orders, or the same with a new time. Begins a bus cycle: due commands first, then status of
  // all seven, then other pages in turn, those that the last cycle did not reach first. An
  // emergency overtakes everything not yet written. Without a release for two periods the cycle
  // begins by itself.
  void release(const BusOrders& orders, TimeNs now) noexcept;

  // Emergency stop to all, before anything else is sent; earlier orders are void.
  void all_stop(TimeNs now) noexcept { stop_all(now, true); }

  // Received bytes, split anywhere.
  void receive(std::span<const std::uint8_t> bytes, TimeNs now) noexcept;

  // Bytes to write now: empty when nothing is due. At most one frame ahead of the wire, so that an
  // emergency never waits behind polls. Call until it returns an empty span; the span is valid
  // until the next call.
  std::span<const std::uint8_t> transmit(TimeNs now) noexcept;

  // When transmit or a time-out needs the clock again; never later than the stale deadline.
  TimeNs next_wake() const noexcept;

  // Replies received since the last call; at most kMaxReplies are kept, the oldest dropped.
  static constexpr std::size_t kMaxReplies = 32;
  std::size_t take(std::span<ModuleReply> out) noexcept;

  const BusCounters& counters() const noexcept { return counters_; }

 private:
  static constexpr TimeNs kNever = INT64_MAX;
  static constexpr TimeNs kRepeat_ns = kSecond;  // of an unconfirmed stop
  static constexpr std::size_t kMaxAsked = 32;

  // A request whose reply may still come. `commands`: how many the module had been sent, since only
  // a reply to a later request is about the last of them.
  struct Asked {
    std::uint8_t module = 0;
    Page page = Page::status;
    std::uint32_t commands = 0;
    std::uint64_t cycle = 0;
    TimeNs deadline_ns = 0;
  };

  struct Module {
    ModuleOrder order{};               // the desired state
    std::uint32_t serial = 0;          // last seen, also when it was replaced by an emergency stop
    TimeNs due_ns = kNever;            // when the command goes out (again)
    bool unconfirmed = false;          // sent, or due, and not yet reported as executed
    bool sent = false;                 // at least once: earlier replies do not concern it
    int contradictions = 0;            // of the order, by the module's own report
    int silences = 0;                  // since the order
    std::uint32_t commands = 0;        // sent to it
    TimeNs sent_ns = 0;                // end of the last one on the wire
    TimeNs told_arrival_ns = 0;        // in the last rotate command
    bool answers = false;              // its last status request was answered
    bool motor_on = false;             // as it reported last
    std::uint64_t verified_cycle = 0;  // in which a page was asked for to verify
    std::uint64_t identity_cycle = 0;  // from which on its identity is due
  };

  struct Poll {
    std::uint8_t module = 0;
    Page page = Page::status;
    bool verifies = false;  // an order, out of turn
  };

  void begin_cycle(TimeNs now) noexcept;
  void stop_all(TimeNs now, bool again) noexcept;
  void accept(Module& module, ModuleLink& link, const ModuleOrder& order, bool fresh,
              TimeNs now) noexcept;
  void stop_if_stale(TimeNs now) noexcept;

  TimeNs may_write_ns() const noexcept;
  int due_command(TimeNs now) const noexcept;
  bool next_poll(Poll& poll) const noexcept;
  bool next_page(Poll& poll) const noexcept;
  bool fits(TimeNs start_ns) const noexcept;
  Frame command_frame(Module& module, std::uint8_t address, TimeNs end_ns) noexcept;
  std::span<const std::uint8_t> write(const Frame& frame, TimeNs now) noexcept;
  void ask(const Poll& poll) noexcept;

  void expire(TimeNs now) noexcept;
  void missed(const Asked& asked, TimeNs now) noexcept;
  void status_over(const Asked& asked, TimeNs now) noexcept;
  void heard(const Received& received, TimeNs now) noexcept;
  void keep(const ModuleReply& reply) noexcept;
  static bool lost(const Module& module, const ModuleLink& link, const ModuleReply& reply) noexcept;
  void verify(Module& module, ModuleLink& link, const ModuleReply& reply, TimeNs now) noexcept;
  void again(Module& module, ModuleLink& link, bool contradicted, TimeNs now) noexcept;
  const Asked& asked(std::size_t i) const noexcept {
    return asked_[(first_asked_ + i) % kMaxAsked];
  }
  void forget_first() noexcept;

  LegBusParameters parameters_;
  TimeNs frame_ns_;
  Receiver receiver_;
  BusCounters counters_;

  std::array<Module, kBusModules> module_{};
  std::uint32_t emergency_serial_ = 0;
  bool broadcast_due_ = false;
  bool released_ = false, stale_ = false;
  TimeNs issued_ns_ = 0, safe_sent_ns_ = 0;

  TimeNs cycle_start_ns_ = 0;
  TimeNs next_cycle_ns_ = 0;               // when it begins by itself
  bool cycle_full_ = false;                // nothing more fits into this period
  int status_left_ = 0, status_next_ = 0;  // to ask for in this cycle, beginning with
  int status_open_ = 0;                    // of this cycle, without an outcome yet
  bool health_left_ = false, identity_left_ = false;
  bool page_first_ = false;  // the last cycle reached no page at all
  std::size_t health_turn_ = 0, identity_turn_ = 0;

  TimeNs wire_free_ns_ = 0;  // when everything written is on the wire
  std::array<std::uint8_t, kMaxFrameCharacters> tx_{};
  std::array<Asked, kMaxAsked> asked_{};  // ring, in the order of the requests
  std::size_t first_asked_ = 0, asked_count_ = 0;
  std::array<ModuleReply, kMaxReplies> reply_{};  // ring
  std::size_t first_reply_ = 0, reply_count_ = 0;
};

// Time of one frame on the wire.
constexpr TimeNs frame_time_ns(int baud, Stop stop) {
  return (static_cast<TimeNs>(frame_characters(stop)) * 10 * kSecond + baud - 1) / baud;
}

}  // namespace lss::zebro
