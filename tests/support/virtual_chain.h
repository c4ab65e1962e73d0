#pragma once

// The common part of the vehicles' chains in virtual time (tests/NAME/chain/chain.h): clock,
// operator, faults, and the frame thread's turn. A chain adds the world, the bus, and the order of
// their events. One thread.

#include <fmt/format.h>
#include <linux/can/error.h>

#include <algorithm>
#include <array>
#include <boost/core/demangle.hpp>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <typeinfo>
#include <utility>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/cycle/cycle.h"
#include "daemon/cycle/ending.h"
#include "daemon/cycle/twins.h"
#include "daemon/record/state.h"
#include "daemon/runtime/bus_thread.h"
#include "daemon/runtime/command_port.h"
#include "daemon/runtime/sample_queue.h"
#include "daemon/runtime/stop_latch.h"
#include "tests/support/daemon_work.h"
#include "tools/lss-sim/frame/can_bus.h"
#include "tools/lss-sim/frame/faults.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss::testing_support {

inline TimeNs to_ns(double seconds) { return std::llround(seconds * 1e9); }

inline Name name_of(const char* text) {
  Name name{};
  std::string_view(text).copy(name.data(), name.size() - 1);
  return name;
}

// One turn of the bus thread of daemon/runtime/can_bus.h. True when its report is due. Passes the
// master's frames to send(frame).
template <class Master, class Report, class Sample, class Send>
bool turn_can(sim::CanBus& line, Master& master, Report& report, SampleQueue<Sample>& samples,
              TimeNs now, Send&& send) {
  constexpr TimeNs kReportEvery = 5 * kMillisecond;
  line.advance(now);
  for (CanFrame heard : line.take(now)) {
    bus_work([&] {
      heard.time_ns = now;
      if (heard.error) {  // as drivers/can/socket_can.cpp
        if ((heard.id & CAN_ERR_BUSOFF) != 0) ++report.port.bus_offs;
        if ((heard.id & CAN_ERR_RESTARTED) == 0) return;
        ++report.port.restarts;
        came_back(master, now);
        return;
      }
      ++report.port.received;
      master.receive({&heard, 1});
    });
  }
  CanFrame sent;
  for (; bus_work([&] { return master.transmit(now, sent); }); ++report.port.sent) send(sent);
  line.advance(now);
  return bus_work([&] {
    std::array<Sample, Master::kMaxSamples> taken;
    const std::size_t count = master.take(taken);
    for (std::size_t i = 0; i < count; ++i) samples.push(taken[i]);
    if (now - report.time_ns < kReportEvery) return false;
    report.status = master.status();
    report.time_ns = now;
    return true;
  });
}

// A visitor of daemon/record/state.h: the members around a byte, each by its number in keep(v) and
// its type.
struct MemberFinder {
  const std::uint8_t* byte;
  std::string path{};

  template <class... T>
  void operator()(T&... members) {
    int number = 0;
    (look(++number, members), ...);
  }
  template <class T>
  void look(int number, T& member) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(&member);
    if (byte < begin || byte >= begin + sizeof member) return;
    path += " " + std::to_string(number) + " " + boost::core::demangle(typeid(T).name());
    if constexpr (record::Keeps<T, MemberFinder>) {
      member.keep(*this);
    } else {
      path += " +" + std::to_string((byte - begin) / 8 * 8);
    }
  }
};

// Keeper of record.h: where the supervisor counts events that repeat.
struct SeriesFinder {
  std::span<std::uint8_t> series{};

  template <class... T>
  void operator()(T&... members) {
    (look(members), ...);
  }
  void look(EventSeries& member) { series = bytes_of(member); }
  template <class T>
  void look(T&) {}
};

template <class Vehicle, class Mode, class Parameters>
class VirtualChain {
 public:
  VirtualChain(const VirtualChain&) = delete;
  VirtualChain& operator=(const VirtualChain&) = delete;

  // ---- Time. A run may end between frames.
  TimeNs now() const { return now_ns_; }
  double seconds() const { return static_cast<double>(now_ns_ - kBegin) * 1e-9; }
  TimeNs frame_ns() const { return in_.time_ns; }     // of the last frame
  std::uint64_t frames() const { return in_.frame; }  // by number: a vehicle's clock may skip some
  std::uint64_t cycles() const { return cycles_; }
  void run(double seconds) { pass(now_ns_ + to_ns(seconds)); }
  // Looks after every frame. False: not within the limit.
  virtual bool run_until(const std::function<bool()>& condition, double limit_s) {
    const TimeNs end = now_ns_ + to_ns(limit_s);
    while (next_frame_ns_ <= end) {
      pass(next_frame_ns_);
      if (condition()) return true;
    }
    return false;
  }
  bool run_until(State state, double limit_s) {
    return run_until([&] { return this->state() == state; }, limit_s);
  }
  bool run_until(Mode mode, double limit_s) {
    return run_until([&] { return this->mode() == mode; }, limit_s);
  }

  // Given every CAN frame of the master, when it is set.
  std::function<void(const CanFrame&, TimeNs)> on_master{};
  // Given every frame, when it is set: a flight recording (tape.h).
  std::function<void(const Inputs<Vehicle>&, const Outputs<Vehicle>&, Supervisor&, Vehicle&)>
      tape{};

  // ---- Actions of an operator. Each command is from `from`.
  template <class Kind>
  std::uint64_t send(Kind kind, std::initializer_list<double> parameters = {},
                     const char* from = "test") {
    return send(static_cast<std::uint16_t>(kind), std::span(parameters.begin(), parameters.size()),
                from);
  }
  std::uint64_t send(std::uint16_t kind, std::span<const double> parameters,
                     const char* from = "test") {
    Request request{
        .source = name_of(from), .sequence = ++sequence_, .kind = kind, .lease_ms = lease_ms};
    std::ranges::copy(parameters, request.parameter.begin());
    post(request);
    return sequence_;
  }
  std::uint32_t lease_ms = 0;                   // of commands
  void heartbeat(bool on) { heartbeat_ = on; }  // of "test", five times a second; on at first

  // The daemon gets the order to end, as Runtime::stop() in daemon/app/runtime.h: until the frame
  // after which it does.
  void shut_down() {
    in_.shut_down = true;
    Ending ending(cycles_, now_ns_);
    const auto over = [&] {
      return ending.over(cycles_, now_ns_, may_be_left(vehicle_, supervisor_.controller()));
    };
    run_until(over, 20);
  }

  // ---- Faults, written as for lss-sim: "module-dead:3", "noise:0.01", "clear:noise", "clear".
  void inject(const std::string& text) {
    const auto fault = sim::parse_fault(text, fault_kinds_);
    if (!fault) throw std::runtime_error(fault.error());
    board_.inject(*fault);
  }
  std::vector<std::string> attached() { return board_.attached(); }
  std::span<const sim::FaultKind> fault_kinds() const { return fault_kinds_; }

  // ---- Output of the daemon.
  const SupervisorState& supervisor() const { return supervisor_.state(); }
  State state() const { return supervisor_.controller().state; }
  Mode mode() const { return static_cast<Mode>(supervisor_.controller().mode); }
  bool has(FaultId id, std::uint16_t subject = 0) const {
    return std::ranges::any_of(supervisor().faults, [&](const FaultRecord& fault) {
      return fault.id == id && fault.subject == subject;
    });
  }
  const typename Vehicle::Telemetry& telemetry() const { return out_.telemetry; }
  const typename Vehicle::Command& orders() const { return out_.command; }
  // The same, as they will be released.
  typename Vehicle::Command due() const {
    typename Vehicle::Command orders = out_.command;
    take_due(orders);
    return orders;
  }
  const Vehicle& vehicle() const { return vehicle_; }
  std::vector<Ack> acks;
  std::vector<EventRecord> events;

  const config::Config& config() const { return config_; }
  const Parameters& parameters() const { return parameters_; }

  // ---- Memory of the daemon's threads, for flipped bits (tests/campaign/flips.h).
  struct Memory {
    const char* name;
    std::span<std::uint8_t> bytes;
    std::string what{};  // of several of this name
  };
  virtual std::vector<Memory> memory() {
    std::vector<Memory> all = {part("vehicle", vehicle_), part("supervisor", supervisor_),
                               part("inputs", in_), part("outputs", out_),
                               part("command port", port_)};
    if (protect_) {
      all.push_back(part("outputs", due_));
      all.push_back(part("second copies", twins_));
    }
    return all;
  }
  // More of it, which is flipped only when it is asked for.
  virtual std::vector<Memory> more_memory() { return {}; }
  // Of memory(), what only reports are made of: no order depends on it.
  std::vector<std::span<std::uint8_t>> memory_of_reports() {
    SeriesFinder finder;
    supervisor_.keep(finder);
    return {finder.series, bytes_of(supervisor_).subspan(Twins<Vehicle>::kSupervisor)};
  }
  // The second copies of the cycle's state are as the state is: they decide nothing then.
  std::span<std::uint8_t> second_copies() { return bytes_of(twins_); }
  bool second_copies_agree() { return !protect_ || twins_.same(vehicle_, supervisor_); }
  // The member that this byte of a part belongs to, or which of several of its name.
  std::string member_at(const std::string& part, const std::uint8_t* byte) {
    MemberFinder finder{byte};
    std::vector<Memory> all = memory();
    for (const Memory& more : more_memory()) all.push_back(more);
    for (const Memory& one : all) {
      const auto at = reinterpret_cast<std::uintptr_t>(byte) -
                      reinterpret_cast<std::uintptr_t>(one.bytes.data());
      if (at < one.bytes.size() && !one.what.empty())
        finder.path += fmt::format(": {} +{}", one.what, at / 8 * 8);
    }
    Vehicle& vehicle = vehicle_;
    Supervisor& supervisor = supervisor_;
    if (part == "vehicle") finder(vehicle);
    if (part == "supervisor") finder(supervisor);
    return part + finder.path;
  }
  // Off: without the second copies of lssd's memory, as lssd was before it had them.
  virtual void protect(bool on) { protect_ = on; }

 protected:
  static constexpr TimeNs kBegin = 1000 * kSecond;
  static constexpr TimeNs kNever = INT64_MAX;

  struct Source {
    std::string file;  // the configuration
    const char* vehicle;
    Parameters (*read)(config::Section& section);
    // Last changes of the parameters, with those that lssd takes from the common part.
    std::function<void(Parameters&, const config::Config&)> complete;
    std::uint32_t lease_ms;
  };

  // Throws std::runtime_error when the configuration cannot be read.
  VirtualChain(const Logic& logic, const sim::VehicleKind& kind, const Source& source)
      : config_(load(source, parameters_)),
        fault_kinds_(sim::fault_kinds_of(kind)),
        board_([this](const sim::Fault& fault, bool attach) { act(fault, attach); },
               [this](const sim::Fault& fault) { return in_force(fault); }),
        vehicle_(parameters_),
        supervisor_(logic, {.obc_timeout_ns = config_.obc_timeout_ns}),
        port_(logic, static_cast<std::uint32_t>(config_.lease_min_ms),
              static_cast<std::uint32_t>(config_.lease_max_ms), [this] { all_stop(); }) {
    lease_ms = source.lease_ms;
    own_codes = logic.codes;
    port_.show(supervisor_.state());
    twins_.seal(vehicle_, supervisor_);
  }
  ~VirtualChain() = default;

  virtual TimeNs next_event() = 0;
  // Does everything that is due now. Of one instant: the world, then threads by priority.
  virtual void dispatch() = 0;
  virtual void act(const sim::Fault& fault, bool attach) = 0;  // as lss-sim does
  virtual bool in_force(const sim::Fault& fault) const = 0;
  virtual void all_stop() = 0;  // an emergency stop was taken

  void send_can(sim::CanBus& line, const CanFrame& frame) {
    if (on_master) on_master(frame, now_ns_);
    line.from_master(frame, now_ns_);
  }

  // Around a turn of the bus thread, as in daemon/runtime/bus_thread.h. forget(): as there.
  template <class Master, class Forget, class Turn>
  auto turn_held(Master& master, Twin<sizeof(Master)>& twin, Forget&& forget, Turn&& turn) {
    const auto lost = [&] { return twin.check(bytes_of(master)) == MemoryCheck::lost; };
    if (protect_ && bus_work(lost)) forget();
    struct Seal {
      Master& master;
      Twin<sizeof(Master)>& twin;
      ~Seal() {
        bus_work([this] { twin.seal(bytes_of(master)); });
      }
    } seal{master, twin};
    return turn();
  }

  template <class T>
  static Memory part(const char* name, T& x, std::string what = {}) {
    return {name, std::span(reinterpret_cast<std::uint8_t*>(&x), sizeof x), std::move(what)};
  }

  // For a fault of a port, which this chain lacks.
  [[noreturn]] static void refuse(std::string_view kind) {
    throw std::runtime_error("the chain has no port: it knows no fault \"" + std::string(kind) +
                             "\"");
  }

  void pass(TimeNs until) {
    for (TimeNs next = next_event(); next <= until; next = next_event()) {
      now_ns_ = std::max(next, now_ns_);
      dispatch();
    }
    now_ns_ = until;
  }

  void beat_when_due() {
    if (now_ns_ < heartbeat_ns_) return;
    heartbeat_ns_ += 200 * kMillisecond;
    if (heartbeat_) post({.source = name_of("test")});
  }

  // More samples of the frame: as many as pop(sample) gives and fit.
  template <class Pop>
  void collect(Pop&& pop) {
    while (in_.sample_count < in_.samples.size() && pop(in_.samples[in_.sample_count]))
      ++in_.sample_count;
  }
  // The cycle of a frame whose samples and bus report are in `in_`.
  void run_cycle() {
    frame_work([this] {
      if (protect_) in_.memory = twins_.check(vehicle_, supervisor_);
      if (std::exchange(bus_memory_lost_, false)) in_.memory = MemoryCheck::lost;
      in_.request_count = port_.take(in_.requests);
      cycle(vehicle_, supervisor_, in_, out_, [](Stage) {});
      twins_.seal(vehicle_, supervisor_);
      due_ = Sealed(out_.command);
      port_.show(supervisor_.state());
    });
    ++cycles_;
    if (tape) tape(in_, out_, supervisor_, vehicle_);
    const Supervisor::Outbox& box = supervisor_.outbox();
    acks.insert(acks.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
    events.insert(events.end(), box.events.begin(), box.events.begin() + box.event_count);
  }
  // The actuate thread's orders at their release, as in daemon/runtime/frame_engine.h. False: none.
  bool take_due(typename Vehicle::Command& orders) const {
    if (protect_) return due_.open(orders);
    orders = out_.command;
    return true;
  }
  // A frame that the clock begins.
  template <class Pop>
  void run_clock_frame(const typename Vehicle::BusReport& report, Pop&& pop) {
    in_.frame += 1;
    in_.time_ns = next_frame_ns_;
    in_.sample_count = 0;
    frame_work([&] { collect(pop); });
    in_.bus = report;
    run_cycle();
    release_ns_ = next_frame_ns_ + config_.offset_ns;
    next_frame_ns_ += config_.period_ns;
  }

  Parameters parameters_;
  config::Config config_;
  TimeNs now_ns_ = kBegin;
  std::uint64_t cycles_ = 0;
  TimeNs step_ns_ = kBegin;        // of the next step of the physics
  TimeNs next_frame_ns_ = kNever;  // of frames that the clock begins
  TimeNs release_ns_ = kNever;     // of the orders of the last frame
  TimeNs heartbeat_ns_ = kBegin;   // of the next one

  std::vector<sim::FaultKind> fault_kinds_;
  sim::FaultBoard board_;

  Vehicle vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  Inputs<Vehicle> in_{};
  Outputs<Vehicle> out_{};
  Sealed<typename Vehicle::Command> due_;  // from the frame thread to the actuate thread
  Twins<Vehicle> twins_;
  bool protect_ = true;
  bool bus_memory_lost_ = false;  // since the last frame: TALARIS reports it

 private:
  static config::Config load(const Source& source, Parameters& parameters) {
    auto config = config::load(
        source.file, {source.vehicle},
        [&](const std::string&, config::Section& section) { parameters = source.read(section); });
    if (!config) throw std::runtime_error(config.error());
    source.complete(parameters, *config);
    return *config;
  }

  void post(Request request) {
    constexpr std::uint64_t kWriter = 1;  // the DDS writer of every command
    request.arrival_ns = now_ns_;
    port_.receive(request, kWriter, [this](const Ack& ack) { acks.push_back(ack); });
  }

  bool heartbeat_ = true;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::testing_support
