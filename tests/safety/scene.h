#pragma once

// Scenes of the safety suite: a world of the vehicle, brought somewhere, and what is expected of
// its command there. The traits T are described in safety_suite.h.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "cycle_world.h"
#include "daemon/record/frame_record.h"
#include "daemon/record/json.h"

namespace lss::safety {

// A state and mode, and how to come there from Idle.
template <class World>
struct Place {
  std::string name;
  State state;
  std::uint8_t mode;
  std::function<void(World&)> go;
};

// A loss or failure that must stop the vehicle: `cause` on a world in motion leads to the fault
// within the time. heal: afterwards error solving succeeds; none: it needs nothing.
template <class World>
struct Fault {
  std::string name;
  FaultId id;
  std::uint16_t subject;
  double within_s;
  std::function<void(World&)> cause;
  std::function<void(World&)> heal;
  bool everywhere = false;  // in every mode of Operational
};

// Faults, one after the other.
template <class World>
struct FaultList {
  std::vector<Fault<World>> all;

  void add(std::string name, FaultId id, std::size_t subject, double within_s,
           std::function<void(World&)> cause, std::function<void(World&)> heal = {},
           bool everywhere = false) {
    all.push_back({std::move(name), id, static_cast<std::uint16_t>(subject), within_s,
                   std::move(cause), std::move(heal), everywhere});
  }
};

// The command that makes the vehicle move when it is ready.
struct Motion {
  std::uint16_t kind;
  std::array<double, kMaxParameters> parameter;
};

// Numbers for random tests; the same for a seed.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : x_(seed * 2 + 1) {}
  std::uint32_t bits() {
    x_ = x_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::uint32_t>(x_ >> 32);
  }
  std::uint32_t below(std::size_t n) { return bits() % static_cast<std::uint32_t>(n); }
  double between(double low, double high) { return low + (high - low) * (bits() / 4294967295.0); }
  // In one frame of many: on average every so many seconds.
  bool every(double seconds, TimeNs period_ns) {
    return between(0, seconds) < static_cast<double>(period_ns) * 1e-9;
  }

 private:
  std::uint64_t x_;
};

// Visitor of record::fields: whether all numbers are finite.
class Finite {
 public:
  bool good() const { return good_; }
  template <class X>
  void operator()(const char*, const X& x) {
    look(x);
  }
  template <class X, std::size_t N>
  void list(const char*, const std::array<X, N>& x, const std::uint32_t& count) {
    for (std::uint32_t i = 0; i < count; ++i) look(x[i]);
  }

 private:
  template <class X>
  void look(const X& x) {
    if constexpr (std::is_floating_point_v<X>) {
      good_ = good_ && std::isfinite(x);
    } else if constexpr (!record::Number<X>) {
      record::visit(*this, x);
    }
  }
  template <record::Array X>
  void look(const X& x) {
    for (const auto& element : x) look(element);
  }
  template <class... X>
  void look(const std::variant<X...>& x) {
    std::visit([this](const auto& alternative) { look(alternative); }, x);
  }

  bool good_ = true;
};

template <class T>
using WorldOf = typename T::World;
template <class T>
using WorldPtr = std::unique_ptr<WorldOf<T>>;

template <class T>
std::string where(const WorldOf<T>& w) {
  const lc::ControllerState& c = w.supervisor_.controller();
  return std::string(kStateNames[static_cast<std::size_t>(c.state)]) + ", mode " +
         std::to_string(c.mode) + ", frame " + std::to_string(w.in_.frame);
}

template <class T>
testing::AssertionResult fails(const WorldOf<T>& w, const char* why) {
  return testing::AssertionFailure()
         << why << " (" << where<T>(w) << "): " << record::to_json(w.out_.command).dump();
}

template <class T>
testing::AssertionResult safe(const WorldOf<T>& w) {
  return T::safe(w) ? testing::AssertionSuccess() : fails<T>(w, "the command can move something");
}

// The emergency stop.
template <class T>
testing::AssertionResult stopped(const WorldOf<T>& w) {
  if (!T::safe(w)) return fails<T>(w, "the command can move something");
  if constexpr (requires { T::stopped(w); }) {
    if (!T::stopped(w)) return fails<T>(w, "the command is not the emergency stop");
  }
  return testing::AssertionSuccess();
}

// True for the command of every frame, in any state and after any input.
template <class T>
testing::AssertionResult sound(const WorldOf<T>& w) {
  Finite finite;
  record::visit(finite, w.out_.command);
  if (!finite.good()) return fails<T>(w, "the command has a number that is not finite");
  if constexpr (requires { T::in_range(w); }) {
    if (!T::in_range(w)) return fails<T>(w, "the command is out of range");
  }
  return w.state() == State::operational ? testing::AssertionSuccess() : safe<T>(w);
}

template <class T>
bool airborne(const WorldOf<T>& w) {
  return w.supervisor_.airborne();
}

// Steps for so long, as long as the command is sound; also under a further condition.
template <class T>
testing::AssertionResult stays_sound(WorldOf<T>& w, double seconds) {
  testing::AssertionResult result = testing::AssertionSuccess();
  w.run_until([&] { return !(result = sound<T>(w)); }, seconds);
  return result;
}
template <class T>
testing::AssertionResult stays_stopped(WorldOf<T>& w, double seconds) {
  testing::AssertionResult result = testing::AssertionSuccess();
  w.run_until([&] { return !(result = stopped<T>(w)); }, seconds);
  if (result && w.state() != State::fatal_error) return fails<T>(w, "FatalError ended by itself");
  return result;
}

// In Idle; nothing has happened yet.
template <class T>
WorldPtr<T> fresh(const Supervisor::Parameters& links = {}) {
  auto w = std::make_unique<WorldOf<T>>(T::parameters(), links);
  w->use_port();
  return w;
}

// In Idle for a second.
template <class T>
WorldPtr<T> rested() {
  auto w = fresh<T>();
  w->run(1);
  return w;
}

template <class T>
void demand_motion(WorldOf<T>& w) {
  w.put({.source = source("test"),
         .kind = T::kMotion.kind,
         .lease_ms = 1000,
         .parameter = T::kMotion.parameter});
}

template <class T>
testing::AssertionResult comes_to_motion(WorldOf<T>& w) {
  if (!T::ready(w)) return fails<T>(w, "it does not come to where motion can be commanded");
  demand_motion<T>(w);
  if (!w.run_until([&] { return T::moves(w); }, 30)) return fails<T>(w, "it does not move");
  return testing::AssertionSuccess();
}

template <class T>
WorldPtr<T> moving(const Supervisor::Parameters& links = {}) {
  auto w = fresh<T>(links);
  const auto result = comes_to_motion<T>(*w);
  EXPECT_TRUE(result);
  return result ? std::move(w) : nullptr;
}

// Errors are solved; it is in Idle without a fatal fault, and nothing has moved.
template <class T>
testing::AssertionResult is_solved(WorldOf<T>& w) {
  w.send(CommandKind::solve);
  testing::AssertionResult result = testing::AssertionSuccess();
  w.run_until([&] { return !(result = sound<T>(w)) || w.state() == State::idle; }, 90);
  if (!result) return result;
  if (w.state() != State::idle) return fails<T>(w, "the errors are not solved");
  w.run(2);
  if (w.state() != State::idle) return fails<T>(w, "it left Idle by itself");
  for (const FaultRecord& fault : w.supervisor_.state().faults) {
    if (fault.id != FaultId::none && info(fault.id)->severity == 3)
      return fails<T>(w, info(fault.id)->name) << " is still latched";
  }
  return safe<T>(w);
}

template <class T>
std::vector<Fault<WorldOf<T>>> faults() {
  auto all = T::faults();
  all.push_back({"overruns", FaultId::frame_overrun, 0, 0.01,
                 [](auto& w) { w.in_.overrun_limit = true; },
                 [](auto& w) { w.in_.overrun_limit = false; }});
  return all;
}

// What was wrong is well again: a fatal error is solved, and it moves.
template <class T>
testing::AssertionResult recovers(WorldOf<T>& w) {
  if (w.state() == State::fatal_error) {
    if (const auto solved = is_solved<T>(w); !solved) return solved;
  }
  return comes_to_motion<T>(w);
}

// All states, and the modes that the vehicle names.
template <class T>
std::vector<Place<WorldOf<T>>> places() {
  using World = WorldOf<T>;
  const auto move = [](World& w) { EXPECT_TRUE(comes_to_motion<T>(w)); };
  const auto stop = [move](World& w) {
    move(w);
    w.send(CommandKind::emergency_stop);
    w.run(0.5);
  };
  const auto solve = [move](World& w) {
    move(w);
    faults<T>().front().cause(w);
    w.run_until(State::fatal_error, 30);
    w.send(CommandKind::solve);
  };
  std::vector<Place<World>> all = {{"Idle", State::idle, 0, [](World&) {}},
                                   {"FatalError", State::fatal_error, 0, stop},
                                   {"SolveErrors", State::solve_errors, 0, solve}};
  if constexpr (requires { T::places(); }) {
    for (Place<World>& place : T::places()) all.push_back(std::move(place));
  } else {
    const auto w = moving<T>();
    const std::uint8_t mode = w == nullptr ? std::uint8_t{0} : w->supervisor_.controller().mode;
    all.push_back({"Motion", State::operational, mode, move});
  }
  return all;
}

template <class T>
testing::AssertionResult go_to(WorldOf<T>& w, const Place<WorldOf<T>>& place) {
  w.run(1);
  place.go(w);
  const auto there = [&] {
    return w.state() == place.state && w.supervisor_.controller().mode == place.mode;
  };
  if (there() || w.run_until(there, 60)) return testing::AssertionSuccess();
  return fails<T>(w, "it does not come there");
}

// nullptr: it does not come there.
template <class T>
WorldPtr<T> at(const Place<WorldOf<T>>& place) {
  auto w = fresh<T>();
  const auto result = go_to<T>(*w, place);
  EXPECT_TRUE(result) << place.name;
  return result ? std::move(w) : nullptr;
}

// In each place: check(world, place).
template <class T, class Check>
void in_each_place(Check&& check) {
  for (const auto& place : places<T>()) {
    SCOPED_TRACE(place.name);
    const auto w = at<T>(place);
    ASSERT_NE(w, nullptr);
    check(*w, place);
  }
}

// Every command of the vehicle.
template <class T>
std::vector<CommandInfo> commands() {
  std::vector<CommandInfo> all;
  for (std::uint16_t kind = 1; kind < 1000; ++kind) {
    if (const CommandInfo* info = T::logic().command(kind)) all.push_back(*info);
  }
  return all;
}

// The command with parameters that it accepts.
inline Request request_of(const CommandInfo& info, const char* from = "test") {
  Request r{.source = source(from), .kind = info.kind, .lease_ms = 1000};
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    const ParameterInfo& p = info.parameters[i];
    r.parameter[i] = std::isnan(p.fallback) ? p.max : p.fallback;
  }
  return r;
}

// Sends and steps; its first answer. Phase::superseded with kind 0: there is none. A request to set
// a parameter that names none is for the vehicle's first one.
template <class T>
Ack answer_to(WorldOf<T>& w, Request request) {
  if (request.kind == static_cast<std::uint16_t>(CommandKind::set_parameter) &&
      request.name == ParameterName{} && !T::logic().tunables.empty())
    request.name = parameter_name(T::logic().tunables.front().name);
  w.acks.clear();
  const std::uint64_t sequence = w.put(request);
  w.step();
  for (const Ack& ack : w.acks) {
    if (ack.sequence == sequence && ack.kind == request.kind) return ack;
  }
  return {.phase = Phase::superseded};
}

}  // namespace lss::safety
