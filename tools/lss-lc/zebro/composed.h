#pragma once

// Lunar Zebro's cycle that ships, over abstract modules and with an operator, as a system for
// tools/lss-lc/composition.h. What is explored, what a key leaves out and what that costs:
// docs/verification.md.

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/vehicles/zebro/vehicle.h"
#include "tools/lss-lc/composition.h"
#include "tools/lss-lc/zebro/abstract_module.h"

namespace lss::zebro {

// Of a module, as Ill, or of the rest.
enum class Failure : std::uint8_t {
  silent,
  deaf,
  jammed,
  frozen,
  late,
  module_reset,    // once, by itself
  unplugged,       // the port is gone
  bus_stands,      // the bus thread does not run
  client_lost,     // no heartbeat of who commands
  obc_lost,        // no heartbeat of anyone
  emergency_stop,  // commanded by another source
  reset_lc,        // the same
  restart,         // of the daemon, the modules go on
  overrun,         // too many late frames
  orders_stale,    // the bus stops all by itself
};
inline constexpr std::size_t kFailures = 15;
inline constexpr const char* kFailureNames[kFailures] = {
    "silent",         "deaf",      "jammed",          "frozen",         "late",
    "reset",          "unplugged", "bus stands",      "client lost",    "OBC lost",
    "emergency stop", "reset lc",  "daemon restarts", "frames overrun", "orders stale"};

class Composed {
 public:
  // The shortest time-out that decides is 100 ms (docs/verification.md).
  static constexpr TimeNs kStep = 100 * kMillisecond;

  static constexpr std::uint32_t kLease_ms = 2000;  // of the operator's commands

  struct Options {
    // Of the vehicle that is explored; the bounds are always those of the configuration that ships.
    Parameters parameters{};
    Supervisor::Parameters links{};
    const Logic* logic = nullptr;  // nullptr: zebro::logic()
    std::uint32_t lease_ms = kLease_ms;
  };
  Composed() : Composed(Options{}) {}
  explicit Composed(const Options& options);

  const Options& options() const { return options_; }

  // ---- for the search
  struct Snapshot;
  void begin();
  void step();
  bool over() const { return env_.over; }
  const char* broken() const { return broken_; }
  std::uint64_t key();
  std::span<const lc::Choice> choices(bool more, bool every);
  void apply(lc::Choice choice);
  void save(Snapshot& snapshot);
  void restore(const Snapshot& snapshot);

  // ---- for people
  std::string text() const;
  std::string line(const std::string& text) const;
  static std::string name(lc::Choice choice);
  double seconds() const { return static_cast<double>(env_.now_ns - kBegin) * 1e-9; }

  // Every failure of every module, in the order of the search.
  static std::vector<lc::Choice> failures();

 private:
  static constexpr TimeNs kBegin = 1'000'000 * kSecond;
  static constexpr std::size_t kPanel = kModules - 1;
  static constexpr std::size_t kMost = 2;  // failures

  enum class Want : std::uint8_t { walk, stop };
  struct Active {
    Failure failure = Failure::silent;
    std::uint8_t module = 0;  // from 1 on
    bool lasts = false;
    TimeNs exposed_ns = 0;  // how long it could have been seen
  };
  // All but the cycle. Trivially copyable.
  struct Env {
    TimeNs now_ns = kBegin;
    std::uint64_t frame = 0;
    std::array<AbstractModule, kModules> module{};
    bool plugged = true, runs = true, client = true, obc = true;
    bool begins = false;     // the bus of a new daemon, which has sent nothing yet
    TimeNs reported_ns = 0;  // by the bus thread
    std::uint64_t safe_commands = 0;
    // once, in the next frame
    bool emergency_stop = false, reset_lc = false, overrun = false;

    std::array<Active, kMost> active{};
    std::size_t failed = 0;
    bool changed = true;  // something, in the last frame

    Want want = Want::walk;
    TimeNs since_ns = kBegin;  // in this state and mode
    TimeNs asked_ns = 0;       // of the last command; 0: none is waited for
    std::uint64_t sequence = 0;
    std::uint8_t tries = 0;  // of solving, and of what a refusal asks for
    std::uint8_t resets = 0;
    bool over = false;

    TimeNs strategy_ns = 0, strategy_limit_ns = 0;
    unsigned seen = 0;      // modules that tripped or disobeyed when the frame began, as bits
    bool solves = false;    // a strategy has begun
    unsigned suspects = 0;  // modules that error solving may have to move, as bits
    TimeNs motor_ns = 0;    // since when a motor is on that should be off; 0: none
    TimeNs unheld_ns = 0;
  };

  void begin_bus();
  void sense();
  void operate();
  void ask(std::uint16_t kind, std::initializer_list<double> parameters = {});
  void obey();
  void check(const lc::ControllerState& before);
  const char* check_orders() const;
  const char* check_losses();
  const char* check_strategies();
  const char* check_solved() const;
  void finish();
  bool can_recover() const;
  bool exposed(const Active& active) const;
  TimeNs limit(Failure failure) const;
  bool ill(std::size_t module) const;
  const lc::ControllerState& controller() const { return supervisor_.controller(); }
  Request request(const char* from, std::uint16_t kind) const;

  Options options_;
  Parameters limits_{};  // of the configuration that ships
  Env env_{};
  const char* broken_ = nullptr;
  Vehicle vehicle_;
  Supervisor supervisor_;
  std::vector<std::uint8_t> at_boot_;  // the state of a daemon that has not run
  std::unique_ptr<Inputs<Vehicle>> in_;
  std::unique_ptr<Outputs<Vehicle>> out_;
  std::vector<ModuleReply> replies_;
  std::vector<lc::Choice> choices_;
  Verdict refused_{};
  std::vector<std::uint8_t> scratch_;
};

struct Composed::Snapshot {
  Env env;
  std::vector<std::uint8_t> cycle;
};

// The exploration of all failures; --only in Depth: of one kind.
lc::Composition compose(const lc::Depth& depth, const Composed::Options& options = {});

}  // namespace lss::zebro
