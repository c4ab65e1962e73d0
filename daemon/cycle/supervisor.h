#pragma once

// Supervision, the second stage of the cycle: runs the locomotion controller on requests and on the
// vehicle's reports, keeps authority, lease, link to the OBC and latched faults, and answers every
// command. Shared by all vehicles. Frame thread; time is data; bounded, no allocation. The state is
// one trivially copyable struct, so that the command thread can evaluate a command on a copy and
// answer at once.

#include <array>
#include <cstdint>

#include "daemon/cycle/controller.h"
#include "daemon/cycle/event_series.h"
#include "daemon/cycle/messages.h"
#include "daemon/cycle/tunables.h"

namespace lss {

inline constexpr std::size_t kMaxModules = 16;
inline constexpr std::size_t kMaxRequests = 32;  // per frame; the others wait

struct SupervisorState;

// The vehicle's part of supervision.
struct Logic {
  const lc::Table* table;
  lc::Event (*event_of)(const Request& request);
  unsigned (*subject_of)(const Request&) = [](const Request&) { return 0u; };  // 0: no module
  bool (*reached)(std::uint16_t kind, const SupervisorState& state);
  std::span<const CommandInfo> commands = {};  // its own
  // Guards on the vehicle's measurements (SupervisorState::sense).
  Verdict (*sense)(const SupervisorState&, const Request&) =
      [](const SupervisorState&, const Request&) -> Verdict { return {}; };
  // For vehicles that fly: they land before they stop for a fault. nullptr: never in the air.
  bool (*airborne)(const lc::ControllerState& controller) = nullptr;
  // Commands that the vehicle itself considers (Actor::consider): the frame thread answers them.
  // nullptr: none.
  bool (*considered)(std::uint16_t kind) = nullptr;
  // Parameters that can be changed while it runs (Actor::adjust).
  std::span<const TunableInfo> tunables = {};
  OwnCodes codes = {};  // of the vehicle itself
  // The command that takes a module out of service, given again after a restart of the daemon.
  // nullptr: a restart puts all modules into service.
  Request (*isolation_of)(unsigned module) = nullptr;

  // Its own command of this kind, or a common one; nullptr when there is none.
  const CommandInfo* command(std::uint16_t kind) const noexcept;
};

// Result of setting a parameter, and its value before.
struct Adjusted {
  Verdict verdict;
  double before = 0;
};

// As Actor::adjust. `changed()` follows when the value was really set.
template <class P, class Changed>
Adjusted adjust(const Tuning<P>& tuning, P& parameters, TunableValues& values, std::size_t index,
                double value, bool really, Changed&& changed) noexcept {
  const double before = values.value[index];
  if (!adjust(tuning, parameters, values, index, value, really))
    return {{.reason = Reason::parameter_together,
             .measured = value,
             .subject = static_cast<std::uint16_t>(index + 1)}};
  if (really) changed();
  return {{}, before};
}

// Carries out the actions of a row, at once and in order. `request` is their command, or nullptr.
class Actor {
 public:
  virtual void act(lc::ActionSet actions, const Request* request) noexcept = 0;
  // The vehicle's own check of a command that all other guards accept. Changes nothing.
  virtual Verdict consider(const Request&) noexcept { return {}; }
  // Sets parameter `index` of Logic::tunables to a value in range, or refuses it with the values of
  // others and changes nothing. `really` false: only checks.
  virtual Adjusted adjust(std::size_t index, double value, bool really) noexcept {
    static_cast<void>(index), static_cast<void>(value), static_cast<void>(really);
    return {{.reason = Reason::no_such_parameter}};
  }

 protected:
  ~Actor() = default;
};

struct SupervisorState {
  lc::ControllerState controller;

  Name authority{};  // empty: nobody
  TimeNs lease_ns = 0;
  TimeNs heartbeat_ns = 0;  // the one that renewed the lease last
  TimeNs contact_ns = 0;    // with anyone; 0: never

  struct Active {  // the command that is being executed
    Name source{};
    std::uint64_t sequence = 0;
    std::uint16_t kind = 0;  // 0: none
  } active;

  std::array<FaultRecord, kMaxFaults> faults{};
  std::uint32_t fault_count = 0;  // kMaxFaults + 1: more than fit

  std::uint16_t resetting = 0;  // modules that a command resets, until they answer again
  std::uint16_t unfit = 0;      // those that answer but are not as configured

  std::array<std::int64_t, kMaxModules> age_ms{};  // since each module's last reply
  std::int64_t silent_limit_ms = 0;
  std::array<double, kMaxModules>
      sense{};                       // values for the vehicle's own guards; layout of the vehicle
  std::uint64_t commands_taken = 0;  // of clients, without emergency stops
  TimeNs ended_ns = 0;               // arrival of the newest command that ended motion
  TimeNs another_daemon_ns = 0;      // last seen, with our name; 0: none, or long ago
  std::uint64_t commands_refused = 0;
  std::uint64_t safe_commands = 0;  // substituted by the gate
  std::uint64_t late_commands = 0;
  TimeNs time_ns = 0;
};

// Nothing runs that a restart of the daemon would break off, as a panel that moves.
inline bool at_rest(const SupervisorState& s) noexcept {
  return s.controller.state == State::idle && s.active.kind == 0 && s.resetting == 0;
}

class Supervisor {
 public:
  struct Parameters {
    TimeNs obc_timeout_ns = 30 * kSecond;
  };

  Supervisor(const Logic& logic, const Parameters& parameters) noexcept
      : logic_(logic), parameters_(parameters) {
    state_.controller = lc::begin(*logic.table);
  }

  // Whether the request would be accepted in this state, else the rejecting guard. Any thread, on a
  // copy.
  static Verdict evaluate(const Logic& logic, const SupervisorState& state,
                          const Request& request) noexcept;

  // One frame: begin, then requests and reports in any order, then check_links.
  void begin(TimeNs now, Actor& actor) noexcept;
  void request(const Request& request) noexcept;
  // Any event but a command, through the locomotion controller; reason none: it was taken.
  Verdict happen(lc::Event event, unsigned subject = 0) noexcept;
  // Latches a fault. `measured`, `limit`: of what it was detected by, for the report.
  void latch(FaultId id, std::uint16_t subject = 0, double measured = 0, double limit = 0) noexcept;
  // Latches a fault; a fatal one is an emergency, in the air only after the landing.
  void raise(FaultId id, std::uint16_t subject = 0, double measured = 0, double limit = 0) noexcept;
  void clear(FaultId id, std::uint16_t subject = 0) noexcept;
  void note(EventId id, std::uint16_t subject = 0, double a = 0, double b = 0, double c = 0,
            double d = 0) noexcept;
  // The command being executed cannot go on.
  void abandon(Reason reason) noexcept;
  // The daemon stops; called in every frame until then: at once the safe command, or in the air as
  // without a lease.
  void shut_down() noexcept;
  void check_links() noexcept;
  // Another daemon of our name that was silent for so long is gone.
  static constexpr TimeNs kGoneAfter = 10 * kSecond;
  // Count of late commands so far (of the actuate thread).
  void count_late(std::uint64_t late) noexcept;
  // In every frame: whether an emergency stop that the bus obeyed ahead of the cycle is
  // unconfirmed. The cycle has to follow.
  void check_stop(bool pending) noexcept;
  // In every frame: what the comparison of memory before it found (daemon/cycle/twins.h).
  void check_memory(MemoryCheck memory) noexcept;
  // The gate replaced a command by the safe one: counted, reported, and an emergency.
  void gate_closed(double check) noexcept;

  // Ages of the modules' replies, for guards.
  void set_ages(const std::array<std::int64_t, kMaxModules>& age_ms,
                std::int64_t limit_ms) noexcept;
  // Modules that answer but are others than configured, or refuse their configuration.
  void set_unfit(std::uint16_t modules) noexcept { state_.unfit = modules; }
  void set_sense(const std::array<double, kMaxModules>& sense) noexcept { state_.sense = sense; }
  // Modules in reset that are not back yet (daemon/cycle/resets.h), in every frame: a `reset` is
  // completed when none of its own is left, or fails with the first that stays silent.
  void set_resetting(std::uint16_t modules) noexcept { state_.resetting = modules; }
  void reset_failed(Reason reason, std::uint16_t module) noexcept;

  // The accepted save-parameters command of this frame; nullptr: none. Another thread saves and
  // answers.
  const SupervisorState::Active* save_asked() const noexcept {
    return save_.kind != 0 ? &save_ : nullptr;
  }

  const SupervisorState& state() const noexcept { return state_; }
  bool airborne() const noexcept {
    return logic_.airborne != nullptr && logic_.airborne(state_.controller);
  }
  const lc::ControllerState& controller() const noexcept { return state_.controller; }

  // Output of this frame. There is room for every answer to every request (accepted, executing and
  // how it ended) and to earlier commands: no client can crowd out the answers to another. Excess
  // events are dropped and counted.
  static constexpr std::size_t kMaxAcks = 3 * kMaxRequests + 4, kMaxEvents = 64;
  struct Outbox {
    std::array<Ack, kMaxAcks> acks{};
    std::array<EventRecord, kMaxEvents> events{};
    std::uint32_t ack_count = 0, event_count = 0, dropped = 0;
    Name holder{};  // source whose command went on, or with authority, when the frame began
  };
  const Outbox& outbox() const noexcept { return outbox_; }

  // For records (daemon/record/state.h): all other members are reset in each frame.
  template <class V>
  void keep(V& v) {
    v(state_);
    v(series_);
    v(unfollowed_frames_);
    v(reset_);
    v(reset_modules_);
  }

 private:
  using Active = SupervisorState::Active;

  void command(const Request& request) noexcept;
  void heartbeat(const Request& request) noexcept;
  void another_daemon() noexcept;
  void stop_safely(Reason reason) noexcept;
  bool fatal(FaultId id) const noexcept;
  Verdict judge(const Request& request) noexcept;
  Adjusted adjust(const Request& request, bool really) noexcept;
  bool handle_parameters(const Request& request, const Active& command) noexcept;
  Verdict apply(lc::Event event, const Request* request, unsigned subject) noexcept;
  void follow(const lc::ControllerState& before) noexcept;
  void check_obc() noexcept;
  void check_name() noexcept;
  void stop_after_landing() noexcept;
  void take_authority(const Request& request) noexcept;
  void finish(Phase phase, Reason reason = Reason::none) noexcept;
  void begin_reset(const Request& request, const Active& command) noexcept;
  void end_reset(Phase phase, const Verdict& verdict = {}) noexcept;
  void acknowledge(const Active& command, Phase phase, const Verdict& verdict = {}) noexcept;
  void report(Severity severity, std::uint16_t id, std::uint16_t subject,
              const std::array<double, 4>& argument) noexcept;
  void put(const EventRecord& event) noexcept;
  FaultRecord* find(FaultId id, std::uint16_t subject) noexcept;
  FaultRecord* place_of(FaultId id) noexcept;

  Logic logic_;            // no state: constant
  Parameters parameters_;  // no state: constant
  SupervisorState state_;
  Active save_;        // no state: of this frame
  bool fell_ = false;  // no state: of this frame
  Active reset_;       // waits for its modules; beside the active command
  std::uint16_t reset_modules_ = 0;
  Actor* actor_ = nullptr;
  EventSeries series_;
  int unfollowed_frames_ = 0;
  Outbox outbox_;  // no state: of one frame; the last member, for twins.h
};

}  // namespace lss
