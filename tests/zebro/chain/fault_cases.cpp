#include "tests/zebro/chain/fault_cases.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string_view>

#include "idl/zebro/codes.h"
#include "tests/zebro/chain/chain.h"
#include "tests/zebro/chain/wire_check.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr double kFrame_s = 0.020;
// A reply that was on its way, and the frame that finds it too old.
constexpr double kSilent_s = 0.500 + 0.005 + kFrame_s;
// A module's report is in the next bus cycle, and then in the next frame.
constexpr double kReported_s = 2 * kFrame_s + 0.003;
// A flag of a status, which a second one has to confirm; that may miss its frame.
constexpr double kFlagged_s = kReported_s + 2 * kFrame_s;
constexpr double kLostReply_s = kFrame_s;  // the next cycle asks again

// Between two movements, until the order for the next one has come.
constexpr double kRest_s = 3 * kFrame_s;
constexpr double kProtected_s = 0.030;  // the module's own filter and time

constexpr double kCycle_s = 6.6;  // of the tripod
// The rest of a stance and the double stance; then 0.4 s, two stretches of 6 deg, 0.15 s.
constexpr double kSleeps_s = 3.6 + 0.3 + 0.4 + 0.12 + 0.15 + kReported_s;
constexpr const char* kBySleep =
    "rest of a stance, 0.4 s, 12 deg of a swing, 0.15 s, a bus cycle, a frame";

constexpr const char* kBySilence = "`module_silent_ms`, and a frame";
constexpr const char* kByStop =
    "60 ms between two movements, 30 ms in the module, two bus cycles, two frames";
constexpr const char* kByLimit = "the same, and twice `current_time_ms` (restarts after a pause)";

constexpr FaultCase walks_on(const char* fault, double delays_s = 0) {
  return {fault, Reaction::walks_on, FaultId::none, 0, "", {}, Hides::nothing, delays_s};
}
constexpr FaultCase warns(const char* fault, FaultId id, double within_s, const char* because,
                          double delays_s = 0) {
  return {fault, Reaction::warns, id, within_s, because, {}, Hides::nothing, delays_s};
}
constexpr FaultCase stops(const char* fault, Lasting lasting, FaultId id, double within_s,
                          const char* because, std::array<FaultId, 3> also = {},
                          Hides hides = Hides::nothing, bool until_restored = false) {
  return {fault, Reaction::stops, id, within_s, because, also, hides, 0, lasting, until_restored};
}

constexpr FaultCase kCases[] = {
    stops("module-dead:#", Lasting::isolated, FaultId::module_silent, kSilent_s, kBySilence, {},
          Hides::module),
    stops("module-reset:#", Lasting::idle, FaultId::module_reset, 0.300 + kFlagged_s,
          "restart (at most 300 ms), two bus cycles, two frames", {}, Hides::module),
    stops("leg-stuck:#", Lasting::isolated, FaultId::module_over_current,
          kRest_s + kProtected_s + kFlagged_s, kByStop, {faults::current_limit}),
    stops("over-current:#", Lasting::isolated, FaultId::module_over_current,
          kRest_s + kProtected_s + kFlagged_s, kByStop, {faults::current_limit}),
    stops("over-current:#:0.75", Lasting::isolated, faults::current_limit,
          kRest_s + 2 * 0.100 + kProtected_s + kFlagged_s, kByLimit,
          {FaultId::module_over_current}),
    walks_on("over-current:#:0.2"),
    stops("driver-fault:#", Lasting::idle, faults::module_driver_fault, 0.002 + kFlagged_s,
          "two bus cycles, two frames"),
    walks_on("hall-lost:#"),
    warns("temperature:#:95", FaultId::temperature_warning, 14 * kFrame_s + kReported_s,
          "health of one module in each second bus cycle at least, a frame"),
    warns("noise:0.003", FaultId::bus_noise, 8 + kFrame_s,
          "20 broken frames in one of eight windows of 1 s, 24 are usual; a frame",
          6 * kLostReply_s),
    stops("noise:0.2", Lasting::remains, FaultId::module_silent, kSilent_s, kBySilence,
          {FaultId::module_disobeys}, Hides::line),
    walks_on("drop:0.02", 4 * kLostReply_s),
    stops("drop:0.9", Lasting::remains, FaultId::module_silent, kSilent_s, kBySilence,
          {FaultId::module_disobeys}, Hides::line),
    walks_on("duplicate:0.05", 2 * kLostReply_s),
    walks_on("late:10", 0.010 + kFrame_s),
    stops("late:1000", Lasting::idle, FaultId::module_silent, kSilent_s, kBySilence,
          {FaultId::module_disobeys}, Hides::line),
    stops("bus-cut", Lasting::remains, FaultId::module_silent, kSilent_s, kBySilence, {},
          Hides::line),
    stops("unplug:1", Lasting::idle, FaultId::port_lost, kFrame_s + 0.001, "a frame",
          {FaultId::module_silent}, Hides::line),
    stops("encoder-random:#", Lasting::isolated, faults::position_jumps, 0.3,
          "three statuses between which no module can have turned",
          {faults::gear_slips, faults::leg_still}),
    stops("encoder-frozen:#", Lasting::isolated, faults::leg_still, kSleeps_s, kBySleep,
          {faults::gear_slips, faults::position_jumps, FaultId::module_over_current},
          Hides::nothing, true),
    stops("encoder-jumps:#", Lasting::isolated, faults::report_impossible,
          1 + 3 * kFrame_s + kReported_s,
          "the first jump, whose speed is reported, and three statuses",
          {faults::position_jumps, faults::gear_slips, faults::leg_still}),
    stops("encoder-drifts:#", Lasting::isolated, faults::gear_slips, 3 * kCycle_s,
          "more than 10 deg at the sensor, once a cycle", {faults::leg_still}, Hides::nothing,
          true),
    stops("gear-slips:#", Lasting::isolated, faults::gear_slips, 2 * kCycle_s,
          "more than 10 deg at the sensor, once a cycle", {faults::leg_still}, Hides::nothing,
          true),
    stops("leg-limp:#", Lasting::isolated, faults::leg_still, kSleeps_s, kBySleep,
          {faults::motion_timeout}),
};

constexpr double kWatched_s = 10;  // while it walks on
constexpr std::size_t kPaired = 18;
constexpr double kStopped_s = 3;   // before any fault is cleared
constexpr double kRepaired_s = 2;  // before it is solved
constexpr double kStill_rad = 0.02;

bool is_line(const FaultCase& fault) { return !fault.of_module(); }
bool is_unplug(const FaultCase& fault) { return fault.id == FaultId::port_lost; }

bool is_fatal(const EventRecord& event) {
  return event.id >= kFaultEventBase && event.severity == Severity::fatal;
}

// Whether this injected fault may cause the fault of an event.
bool explains(const Injection& injection, const EventRecord& event) {
  const auto id = static_cast<FaultId>(event.id - kFaultEventBase);
  const FaultCase& fault = *injection.fault;
  if (fault.reaction != Reaction::stops ||
      (id != fault.id && std::ranges::find(fault.also, id) == fault.also.end()))
    return false;
  return is_line(fault) || event.subject == injection.module;
}

// Whether `other` hides `fault` from the daemon. Times of silence add up.
bool hidden(const Injection& fault, const Injection& other) {
  if (fault.fault->id == FaultId::module_silent) return false;
  if (other.fault->hides == Hides::line) return true;
  return other.fault->hides == Hides::module && other.module == fault.module &&
         !is_line(*fault.fault);
}

// By when FatalError must be there; none: it must not.
std::optional<double> due_s(std::span<const Injection> injections) {
  std::optional<double> due;
  for (const Injection& injection : injections) {
    if (injection.fault->reaction != Reaction::stops) continue;
    double own = injection.at_s + injection.fault->within_s;
    bool counts = true;
    for (const Injection& other : injections) {
      if (&other == &injection) continue;
      own += other.fault->delays_s;
      // A fault hidden before its time limit no longer counts; the other one does.
      if (hidden(injection, other) && other.at_s < own) counts = false;
    }
    if (counts) due = std::min(due.value_or(own), own);
  }
  if (due) return due;
  // Each hides the other: the later one is seen at least.
  for (const Injection& injection : injections) {
    if (injection.fault->reaction == Reaction::stops)
      due = std::max(due.value_or(0), injection.at_s + injection.fault->within_s);
  }
  return due;
}

class FaultWalk {
 public:
  FaultWalk(unsigned seed, std::span<const Injection> injections)
      : injections_(injections), chain_({.seed = seed, .plant = sim::zebro::PlantKind::kinematic}) {
    std::mt19937 random(seed);
    expect(chain_.stand() && chain_.walk(), "it does not come to walking");
    chain_.run(std::uniform_real_distribution(0.5, 4.0)(random));
    expect(chain_.mode() == Mode::walking, "it does not walk");
    chain_.forget();
    begin_ns_ = chain_.now();
  }

  void break_it() {
    for (const Injection& injection : injections_) {
      chain_.run(injection.at_s - since_begin_s());
      chain_.inject(injection.fault->text(injection.module));
    }
    const bool stops = due_s(injections_).has_value();
    if (!stops || chain_.state() != State::fatal_error)
      chain_.run_until(State::fatal_error, std::max(kWatched_s, due_s(injections_).value_or(0)));
    read_events();
  }

  // Conditions after an emergency.
  void check_stop() {
    const double due = *due_s(injections_);
    if (!observed.stopped_s) return expect(false, "it does not stop");
    expect(*observed.stopped_s <= due + 1e-9,
           fmt::format("it stops after {:.3f} s, due are {:.3f} s", *observed.stopped_s, due));
    chain_.run(0.3);
    const auto shafts = chain_.world().robot().shafts();
    chain_.run(kStopped_s - 0.3);
    expect(chain_.state() == State::fatal_error, "it does not stay in FatalError");
    check_wire();
    const bool heard = std::ranges::none_of(
        injections_, [](const Injection& i) { return i.fault->hides == Hides::line; });
    for (std::size_t i = 0; i < shafts.size() && heard; ++i) {
      const double moved_rad = chain_.world().robot().shafts()[i].angle_rad - shafts[i].angle_rad;
      expect(std::abs(moved_rad) < kStill_rad, fmt::format("leg {} moves", i + 1));
    }
    read_events();
  }

  void repair_and_solve() {
    chain_.inject("clear");
    chain_.run(kRepaired_s);
    const TimeNs begin_ns = chain_.now();
    if (!chain_.solve()) return expect(false, "solve does not lead to Idle: " + faults());
    expect(!chain_.has_fatal(), "Idle with " + faults());
    for (const Injection& injection : injections_) {
      if (injection.fault->until_restored) chain_.send(lss::CommandKind::restore, {});
    }
    chain_.run(0.1);
    expect(chain_.supervisor().controller.isolated == 0, "a leg was isolated");
    expect(chain_.now() > begin_ns, "solved in no time");
    expect(chain_.stand(), "it does not stand again: " + faults());
  }

  void check_walks_on() {
    expect(!observed.stopped_s, "it stops: " + faults());
    expect(chain_.mode() == Mode::walking, "it does not walk any more");
    for (const WireFrame& frame : chain_.wire()) {
      if (frame.code() == Code::emergency_stop) return expect(false, "an emergency stop was sent");
    }
    for (const Injection& injection : injections_) {
      if (injection.fault->reaction != Reaction::warns) continue;
      double due = injection.at_s + injection.fault->within_s;
      for (const Injection& other : injections_) due += other.fault->delays_s;
      const auto warned = warning(injection);
      expect(warned && *warned <= due, "it does not warn in time");
    }
    chain_.inject("clear");
    chain_.send(lss::CommandKind::stop, {1});
    expect(chain_.run_until(State::idle, 60), "it does not come to a safe stop: " + faults());
  }

  Lasting solve_broken() {
    break_it();
    if (!observed.stopped_s) return Lasting::not_stopped;
    chain_.run(kStopped_s);
    if (!chain_.solve(300)) return Lasting::remains;
    return chain_.supervisor().controller.isolated == 0 ? Lasting::idle : Lasting::isolated;
  }

  Observed observed;

 private:
  void expect(bool good, const std::string& else_wrong) {
    if (!good) observed.wrong.push_back(else_wrong);
  }
  double since_begin_s() const { return static_cast<double>(chain_.now() - begin_ns_) * 1e-9; }
  double since_begin_s(TimeNs time) const { return static_cast<double>(time - begin_ns_) * 1e-9; }

  std::string faults() const {
    std::string all = "faults";
    for (const FaultRecord& fault : chain_.supervisor().faults) {
      if (fault.id != FaultId::none)
        all += fmt::format(" {}:{}", info(fault.id)->name, fault.subject);
    }
    return all;
  }

  std::optional<double> warning(const Injection& injection) const {
    const auto id = static_cast<std::uint16_t>(static_cast<std::uint16_t>(injection.fault->id) +
                                               kFaultEventBase);
    for (const EventRecord& event : chain_.events) {
      if (event.id == id && (is_line(*injection.fault) || event.subject == injection.module))
        return since_begin_s(event.time_ns);
    }
    return {};
  }

  void read_events() {
    for (; read_ < chain_.events.size(); ++read_) {
      const EventRecord& event = chain_.events[read_];
      if (event.id == static_cast<std::uint16_t>(EventId::state_changed) &&
          event.argument[1] == static_cast<double>(State::fatal_error) && !observed.stopped_s) {
        observed.stopped_s = since_begin_s(event.time_ns);
        stopped_ns_ = event.time_ns;
      }
      if (!is_fatal(event)) continue;
      const auto found =
          std::ranges::find_if(injections_, [&](const Injection& i) { return explains(i, event); });
      expect(found != injections_.end(),
             fmt::format("{}:{} has no cause here", kFaultName(event), event.subject));
    }
    for (const Injection& injection : injections_) {
      if (injection.fault->reaction == Reaction::warns && !observed.warned_s)
        observed.warned_s = warning(injection);
    }
  }
  static const char* kFaultName(const EventRecord& event) {
    return info(static_cast<FaultId>(event.id - kFaultEventBase))->name;
  }

  // The emergency stops go out at once; when there is no port, as soon as there is one.
  void check_wire() {
    const LegBusParameters& bus = chain_.parameters().bus;
    TimeNs order_ns = stopped_ns_ + chain_.config().offset_ns;
    for (const Injection& injection : injections_) {
      if (!is_unplug(*injection.fault)) continue;
      const TimeNs gone_ns = begin_ns_ + std::llround(injection.at_s * 1e9);
      if (order_ns + 10 * frame_time_ns(bus.baud, bus.stop) < gone_ns) {
        expect(emergency_on_wire(chain_.wire(), bus, order_ns, gone_ns).empty(),
               "before the port was gone: " +
                   emergency_on_wire(chain_.wire(), bus, order_ns, gone_ns));
      }
      const auto first =
          std::ranges::lower_bound(chain_.wire(), gone_ns + kSecond / 2, {}, &WireFrame::begin_ns);
      if (first == chain_.wire().end()) return expect(false, "nothing on the wire after unplug");
      expect(first->begin_ns <= gone_ns + kSecond + 100 * kMillisecond, "it opens the port late");
      order_ns = first->begin_ns;
    }
    const std::string wrong = emergency_on_wire(chain_.wire(), bus, order_ns, chain_.now());
    expect(wrong.empty(), wrong);
  }

  std::span<const Injection> injections_;
  Chain chain_;
  TimeNs begin_ns_ = 0, stopped_ns_ = 0;
  std::size_t read_ = 0;
};

}  // namespace

bool FaultCase::of_module() const {
  return std::string_view(fault).find('#') != std::string_view::npos;
}

std::string FaultCase::text(unsigned module) const {
  std::string text = fault;
  if (const auto at = text.find('#'); at != std::string::npos)
    text.replace(at, 1, std::to_string(module));
  return text;
}

std::span<const FaultCase> fault_cases() { return kCases; }
std::span<const FaultCase> paired_cases() { return std::span(kCases).first(kPaired); }

Observed break_walk(unsigned seed, std::span<const Injection> injections) {
  FaultWalk walk(seed, injections);
  walk.break_it();
  if (due_s(injections)) {
    walk.check_stop();
    if (walk.observed.stopped_s) walk.repair_and_solve();
  } else {
    walk.check_walks_on();
  }
  return walk.observed;
}

Lasting solve_while_it_lasts(unsigned seed, const Injection& injection) {
  return FaultWalk(seed, {&injection, 1}).solve_broken();
}

}  // namespace lss::zebro
