#pragma once

// Error solving of Lunar Zebro (Zebro thesis [Conf-3]): strategies, tried one after the other until
// every module in service answers, without a fault, for a while. The configuration names the
// strategies of each class of faults and their order. Frame thread; time is data.

#include <array>
#include <cstdint>
#include <span>

#include "daemon/cycle/strategies.h"
#include "drivers/zebro/leg_module.h"
#include "idl/zebro/commands.h"

namespace lss::zebro {

// Classes of faults by their strategies.
enum class FaultClass : std::uint8_t {
  contact,    // a module does not answer
  current,    // over-current, of the module or of our limit
  driver,     // motor driver
  obedience,  // a module that does not follow its orders, or a motion without an end
  report,     // a module reports what cannot be
  gear,       // a leg is not where its motor counts it
  supply,     // a module was reset
  system,     // not a module's: links, frames, emergency stops by command
};
inline constexpr std::size_t kFaultClasses = 8;
inline constexpr const char* kFaultClassNames[kFaultClasses] = {
    "contact", "current", "driver", "obedience", "report", "gear", "supply", "system"};
FaultClass class_of(FaultId fault) noexcept;
// Caused by the operator, not by the vehicle: emergency stop, missing heartbeat.
bool of_operator(FaultId fault) noexcept;

// A latched fault or a present one.
struct Symptom {
  FaultClass fault_class;
  std::uint16_t module;  // from 1 on; 0: none
  bool counts = true;    // towards the rounds after which a person is needed
  bool again = false;    // it was solved before, and came back
};

// Strategies, in order; none ends it.
using StrategyList = Strategies<StrategyKind>::List;

struct SolverParameters {
  std::array<StrategyList, kFaultClasses> order{{
      {StrategyKind::reconnect, StrategyKind::reset_module, StrategyKind::isolate},
      {StrategyKind::move_free, StrategyKind::cool_down, StrategyKind::isolate},
      {StrategyKind::reset_module, StrategyKind::isolate},
      {StrategyKind::reset_module, StrategyKind::move_free, StrategyKind::isolate},
      {StrategyKind::reset_module, StrategyKind::isolate},
      {StrategyKind::isolate},
      {StrategyKind::reconnect},
      {StrategyKind::reconnect, StrategyKind::reset_all},
  }};
  TimeNs budget_ns = 10 * kSecond;     // for one strategy, without the time that legs are moved
  TimeNs cool_down_ns = 60 * kSecond;  // for cool_down
  double cool_degC = 60;               // cool enough
  double current_limit_A = 1.2;        // of a leg that is moved free
  double free_rad = 0.35;              // how far it is moved, back and forth
  TimeNs free_move_ns = 2 * kSecond;   // in how long
  unsigned rounds = 10;                // for the same fault, then a person is needed
  TimeNs healthy_ns = 60 * kSecond;    // of operation, after which they count again from 0
};

// Sets of modules as bits: bit i is module i+1.
constexpr bool contains(std::uint8_t modules, std::size_t i) noexcept {
  return (static_cast<unsigned>(modules) >> i & 1u) != 0;
}

class Vehicle;

// One way to solve errors. `modules`: its modules, as bits.
class Strategy {
 public:
  virtual void begin(Vehicle& vehicle, std::uint8_t modules) noexcept = 0;
  virtual Treatment step(Vehicle& vehicle) noexcept = 0;

 protected:
  ~Strategy() = default;
};

// Only waits: contact and port are retried all the time.
class Reconnect final : public Strategy {
 public:
  void begin(Vehicle&, std::uint8_t) noexcept override {}
  Treatment step(Vehicle&) noexcept override { return Treatment::done; }
};

class ResetModules final : public Strategy {
 public:
  explicit ResetModules(bool all) noexcept : all_(all) {}
  void begin(Vehicle& vehicle, std::uint8_t modules) noexcept override;
  Treatment step(Vehicle&) noexcept override { return Treatment::done; }

 private:
  bool all_;
};

// Moves each leg that answers a little way back, then forth. A leg that draws too much current or
// does not move is blocked: the strategy goes on with the others, and has failed. A leg that was
// reset may pass its Hall sensor on the way: it still moves only so far.
class MoveFree final : public Strategy {
 public:
  explicit MoveFree(const SolverParameters& parameters) noexcept : parameters_(parameters) {}
  void begin(Vehicle& vehicle, std::uint8_t modules) noexcept override;
  Treatment step(Vehicle& vehicle) noexcept override;
  // Legs, as bits, that came back from their way.
  std::uint8_t moved() const noexcept { return moved_; }
  template <class V>
  void keep(V& v) {
    v(parameters_, phase_, leg_, left_, moved_, stuck_, from_rad_, seen_rad_, calibrated_, due_ns_);
  }
  void configure(const SolverParameters& parameters) noexcept { parameters_ = parameters; }

 private:
  enum class Phase : std::uint8_t { next_leg, switching_on, back, forth };
  Treatment give_up_leg(Vehicle& vehicle) noexcept;
  void follow_calibration(Vehicle& vehicle) noexcept;
  void order(Vehicle& vehicle) noexcept;

  SolverParameters parameters_;
  Phase phase_ = Phase::next_leg;
  std::size_t leg_ = 0;
  std::uint8_t left_ = 0;  // legs to move
  std::uint8_t moved_ = 0, stuck_ = 0;
  double from_rad_ = 0;
  double seen_rad_ = 0;  // in the frame before
  bool calibrated_ = false;
  TimeNs due_ns_ = 0;
};

class CoolDown final : public Strategy {
 public:
  explicit CoolDown(const SolverParameters& parameters) noexcept : parameters_(parameters) {}
  void begin(Vehicle&, std::uint8_t modules) noexcept override { modules_ = modules; }
  Treatment step(Vehicle& vehicle) noexcept override;
  template <class V>
  void keep(V& v) {
    v(parameters_, modules_);
  }
  void configure(const SolverParameters& parameters) noexcept { parameters_ = parameters; }

 private:
  SolverParameters parameters_;
  std::uint8_t modules_ = 0;
};

// Takes the legs out of service, when the others can stand and walk.
class Isolate final : public Strategy {
 public:
  void begin(Vehicle& vehicle, std::uint8_t modules) noexcept override;
  Treatment step(Vehicle& vehicle) noexcept override;
  template <class V>
  void keep(V& v) {
    v(modules_, until_ns_);
  }

 private:
  std::uint8_t modules_ = 0;
  TimeNs until_ns_ = 0;  // until when their motors have to be off
};

class Solver {
 public:
  using Report = Strategies<StrategyKind>::Report;

  explicit Solver(const SolverParameters& parameters) noexcept;

  // Plans the strategies from the present faults. The first one begins with the next step. A leg
  // that does not obey or cannot be believed, and was solved before, is isolated first of all.
  void begin(std::span<const Symptom> symptoms) noexcept;
  void end() noexcept { running_ = false; }
  // Applies to the running strategy, too.
  void configure(const SolverParameters& parameters) noexcept {
    parameters_ = parameters;
    move_free_.configure(parameters);
    cool_down_.configure(parameters);
  }
  bool running() const noexcept { return running_; }
  StrategyKind kind() const noexcept { return plan_[at_]; }

  // Once per frame while running. `healthy`: no fault at all in this frame. next: the strategy did
  // not help; call again when the locomotion controller agreed to the next one.
  Report step(Vehicle& vehicle, bool healthy) noexcept;

  // For records (daemon/record/state.h).
  template <class V>
  void keep(V& v) {
    v(parameters_, move_free_, cool_down_, isolate_, plan_, at_, suspects_, relapsed_, blamed_,
      running_, begun_, phase_, until_ns_, healthy_since_ns_);
  }

 private:
  static constexpr TimeNs kProof = kSecond;

  Strategy& strategy() noexcept;
  TimeNs moves_ns(std::uint8_t legs) const noexcept;  // time for moving them free
  Report give_up(Vehicle& vehicle) noexcept;
  void clear_moved() noexcept;
  // After the treatment: no fault, stopped legs have moved, no fault for a while.
  enum class Phase : std::uint8_t { treating, waiting, moving, proving };

  SolverParameters parameters_;
  Reconnect reconnect_;                                 // no state
  ResetModules reset_module_{false}, reset_all_{true};  // no state: constant
  MoveFree move_free_;
  CoolDown cool_down_;
  Isolate isolate_;

  StrategyList plan_{};
  std::size_t at_ = 0;
  // Legs that were stopped under power: their flags mean little without it, so they have to move
  // once before they count as healthy.
  std::uint8_t suspects_ = 0;
  // Legs that did not obey or could not be believed, were solved, and came back.
  std::uint8_t relapsed_ = 0;
  // Legs that answered and were at fault when the strategy before was given up.
  std::uint8_t blamed_ = 0;
  bool running_ = false;
  bool begun_ = false;  // the strategy at at_
  Phase phase_ = Phase::treating;
  TimeNs until_ns_ = 0, healthy_since_ns_ = 0;
};

}  // namespace lss::zebro
