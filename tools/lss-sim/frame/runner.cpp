#include "tools/lss-sim/frame/runner.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/signalfd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <memory>
#include <string_view>
#include <thread>

#include "drivers/lockstep/lockstep.h"
#include "tools/lss-sim/frame/can_thread.h"
#include "tools/lss-sim/frame/control.h"
#include "tools/lss-sim/frame/line_thread.h"

namespace lss::sim {
namespace {

constexpr FaultArgument kUnplug[] = {{"SECONDS", "how long the port is gone", 0.01, 3600}};
constexpr FaultKind kUnplugKind = {"unplug", kUnplug,
                                   "the port goes away as a pulled adapter does, and comes back"};
constexpr TimeNs kMostBehindNs = 100 * kMillisecond;
constexpr int kPhysicsPriority = 40;  // below the lines and the daemon
constexpr long kStepsPerTruth = 100;
constexpr int kLookMs = 100;
// Characters that a line passes on at once: a UART's FIFO, and in simulated time, where each piece
// costs a hand-over, a packet of a USB adapter.
constexpr std::size_t kFifo = 8, kPacket = 64;

bool among(std::span<const FaultKind> kinds, std::string_view name) {
  return std::ranges::find(kinds, name, &FaultKind::name) != kinds.end();
}

class Simulation {
 public:
  Simulation(std::unique_ptr<Vehicle> vehicle, const RunOptions& options)
      : vehicle_(std::move(vehicle)),
        options_(options),
        board_([this](const Fault& fault, bool attach) { act(fault, attach); },
               [this](const Fault& fault) { return in_force(fault); }) {
    std::ranges::stable_sort(options_.faults, {}, &TimedFault::at_s);
    unsigned seed = options.seed;
    for (const SerialLine& line : vehicle_->lines()) {
      const Uart::Parameters parameters{.baud = line.baud != 0 ? line.baud : options.baud,
                                        .bits = line.bits,
                                        .paced = options.pace,
                                        .fifo = options.lockstep ? kPacket : kFifo,
                                        .frame_begin = line.frame_begin,
                                        .frame_end = line.frame_end,
                                        .seed = ++seed};
      lines_.push_back(
          std::make_unique<LineThread>(options.folder / line.name, parameters, *line.device));
      wires_.push_back(lines_.back().get());
    }
    for (const CanLine& bus : vehicle_->can_buses()) {
      const CanBus::Parameters parameters{.paced = options.pace, .seed = ++seed};
      buses_.push_back(std::make_unique<CanThread>(bus.name, options.can, parameters, *bus.device));
      wires_.push_back(buses_.back().get());
    }
  }

  ~Simulation() { stop(); }

  tl::expected<void, std::string> start() {
    if (options_.truth) {
      truth_.open(*options_.truth, std::ios::trunc);
      if (!truth_) {
        return tl::unexpected(fmt::format("cannot write the truth to {}: {}",
                                          options_.truth->string(), std::strerror(errno)));
      }
    }
    const bool own_threads = !options_.lockstep;
    for (WireThread* wire : wires_) {
      if (auto started = own_threads ? wire->start() : wire->open(); !started) return started;
    }
    thread_ = std::thread([this] { options_.lockstep ? in_lockstep() : physics(); });
    return {};
  }

  void stop() {
    stop_ = true;
    lockstep::leave();
    if (thread_.joinable()) thread_.join();
  }

  void inject(const Fault& fault) { board_.inject(fault); }

  std::string ports() const {
    std::string text;
    for (const WireThread* wire : wires_) text += ", " + wire->place();
    return text;
  }

  double slipped_s() const { return static_cast<double>(slipped_ns_) * 1e-9; }
  bool over() const { return over_; }  // the time of --for
  double simulated_s() const { return static_cast<double>(steps_ * kStepNs) * 1e-9; }

 private:
  void act(const Fault& fault, bool attach) {
    const std::string_view name = fault.kind->name;
    if (name == kUnplugKind.name) {
      const double seconds = attach ? fault.values.front() : 0;
      const auto duration_ns = static_cast<TimeNs>(seconds * kSecond);
      for (WireThread* wire : wires_) wire->unplug(duration_ns);
    } else if (among(numbered_line_fault_kinds(), name)) {
      act_on_line(fault, attach);
    } else if (among(line_fault_kinds(), name) || among(can_fault_kinds(), name)) {
      // Faults of the bus, if there is one: then lines have faults by number.
      for (const auto& bus : buses_) bus->set_fault(fault, attach);
      if (!buses_.empty()) return;
      for (const auto& line : lines_) line->set_fault(fault, attach);
    } else {
      vehicle_->set_fault(fault, attach);
    }
  }

  // Null when there is no such line.
  LineThread* line_of(const Fault& fault) const {
    const auto number = static_cast<std::size_t>(fault.values.front());
    return number <= lines_.size() ? lines_[number - 1].get() : nullptr;
  }

  void act_on_line(const Fault& fault, bool attach) {
    LineThread* line = line_of(fault);
    if (line == nullptr) {
      fmt::print(stderr, "lss-sim: {} does nothing: there are {} lines\n", to_text(fault),
                 lines_.size());
    } else if (std::string_view(fault.kind->name) == "line-unplug") {
      line->unplug(attach ? static_cast<TimeNs>(fault.values.back() * kSecond) : 0);
    } else {
      line->set_fault(fault, attach);
    }
  }

  bool in_force(const Fault& fault) const {
    const std::string_view name = fault.kind->name;
    if (name == kUnplugKind.name) {
      return std::ranges::any_of(wires_, &WireThread::unplugged);
    }
    if (among(numbered_line_fault_kinds(), name)) {
      const LineThread* line = line_of(fault);
      return line != nullptr && (name != "line-unplug" || line->unplugged());
    }
    if (name == "bus-off") {
      return std::ranges::any_of(buses_, [](const auto& bus) { return bus->is_off(); });
    }
    return among(line_fault_kinds(), name) || among(can_fault_kinds(), name) ||
           vehicle_->in_force(fault);
  }

  void physics() {
    // Faster than real time it would leave no CPU time to others.
    if (options_.speed <= 1) keep_time(kPhysicsPriority);
    const auto period_ns = static_cast<TimeNs>(static_cast<double>(kStepNs) / options_.speed);
    TimeNs next = monotonic_now();
    for (std::size_t fault = 0; !stop_; ++steps_) {
      step(fault);
      for (WireThread* wire : wires_) {
        if (wire->wants_to_send()) wire->wake();
      }
      next += period_ns;
      const TimeNs now = monotonic_now();
      if (now > next + kMostBehindNs) {
        slipped_ns_ += now - next;
        next = now;
      }
      const timespec until{.tv_sec = next / kSecond, .tv_nsec = next % kSecond};
      while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
      }
    }
  }

  // One step of physics, after all due work. `fault`: the next of options_.faults.
  void step(std::size_t& fault) {
    while (fault < options_.faults.size() && options_.faults[fault].at_s <= simulated_s()) {
      inject(options_.faults[fault++].fault);
    }
    if (steps_ % kStepsPerTruth == 0) write_truth();
    vehicle_->step();
  }

  // Physics, lines and buses as one thread that takes part in simulated time.
  void in_lockstep() {
    const lockstep::Part part("sim");
    TimeNs next = lockstep::now();
    begin_s_ = static_cast<double>(next - lockstep::kBegin) * 1e-9;
    const TimeNs end = options_.for_s < 0 ? lockstep::kNever : next + seconds_ns(options_.for_s);
    for (std::size_t fault = 0; !stop_;) {
      const TimeNs now = lockstep::now();
      if (now >= end) {
        lockstep::finish();
        write_truth();
        over_ = true;
        return;
      }
      if (now >= next) {
        step(fault);
        ++steps_;
        next += kStepNs;
      }
      TimeNs wake = next;
      for (WireThread* wire : wires_) wake = std::min(wake, wire->serve(now));
      lockstep::wait(wake);
    }
  }

  static TimeNs seconds_ns(double s) { return static_cast<TimeNs>(s * kSecond); }

  void write_truth() {
    if (!truth_.is_open()) return;
    nlohmann::ordered_json line = {{"t_s", begin_s_ + simulated_s()}};
    line.update(vehicle_->truth());
    line["attached_faults"] = board_.attached();
    truth_ << line.dump() << std::endl;
  }

  std::unique_ptr<Vehicle> vehicle_;
  RunOptions options_;
  FaultBoard board_;
  std::vector<std::unique_ptr<LineThread>> lines_;
  std::vector<std::unique_ptr<CanThread>> buses_;
  std::vector<WireThread*> wires_;  // all of them
  std::ofstream truth_;
  double begin_s_ = 0;  // of simulated time, when a simulator ran before this one
  std::atomic<bool> stop_ = false, over_ = false;
  std::atomic<long> steps_ = 0;
  std::atomic<TimeNs> slipped_ns_ = 0;
  std::thread thread_;
};

// Reports once when simulated time stands still because a participant does not end its turn, and
// when it continues. Called ten times a second of wall time.
class StandstillWatch {
 public:
  void look() {
    const std::uint64_t turns = lockstep::turns();
    const std::string holder = lockstep::waits_for();
    if (turns != turns_ || holder.empty()) {
      if (said_) fmt::print(stderr, "lss-sim: time goes on\n");
      said_ = false;
      still_ = 0;
    } else if (++still_ == kTold) {
      fmt::print(stderr, "lss-sim: time stands still: waiting for {}\n", holder);
      said_ = true;
    }
    turns_ = turns;
  }

 private:
  static constexpr int kTold = 10;
  std::uint64_t turns_ = 0;
  int still_ = 0;
  bool said_ = false;
};

// The statistics of simulated time, for people.
void tell_pace(double simulated_s, double wall_s, double speed) {
  fmt::print(stderr, "lss-sim: {:.1f} s simulated in {:.1f} s: {:.2f} times real time", simulated_s,
             wall_s, simulated_s / wall_s);
  if (lockstep::slipped_s() > 0)
    fmt::print(stderr, "; the machine was too slow for {:g}: {:.2f} s slipped", speed,
               lockstep::slipped_s());
  fmt::print(stderr, "; {} turns, {} hand-overs between threads, {:.1f} us each\n",
             lockstep::turns(), lockstep::handovers(),
             wall_s * 1e6 / static_cast<double>(std::max<std::uint64_t>(1, lockstep::handovers())));
}

// Called before any thread starts, so that all threads leave these signals to the returned
// descriptor.
File take_signals() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGTERM, SIGINT, SIGHUP}) sigaddset(&signals, signal);
  ::pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  return File(::signalfd(-1, &signals, SFD_CLOEXEC));
}

}  // namespace

std::vector<FaultKind> fault_kinds_of(const VehicleKind& kind) {
  const auto own = kind.fault_kinds();
  std::vector<FaultKind> kinds(own.begin(), own.end());
  const bool can = !kind.can_address().empty();
  const auto wire = can ? can_fault_kinds() : line_fault_kinds();
  kinds.insert(kinds.end(), wire.begin(), wire.end());
  if (const auto lines = numbered_line_fault_kinds(); can && kind.has_lines()) {
    kinds.insert(kinds.end(), lines.begin(), lines.end());
  }
  kinds.push_back(kUnplugKind);
  return kinds;
}

tl::expected<void, std::string> run(const VehicleKind& kind, const RunOptions& options) {
  const File signals = take_signals();
  auto control = Control::open(options.folder);
  if (!control) return tl::unexpected(control.error());
  const std::vector<FaultKind> kinds = fault_kinds_of(kind);
  if (options.lockstep) {
    const auto client_at = static_cast<TimeNs>(options.client_at_s * kSecond);
    const std::string error = lockstep::create(
        options.folder.string(),
        {.speed = options.speed, .client_speed = options.client_speed, .client_at = client_at});
    if (!error.empty()) return tl::unexpected(error);
  }
  Simulation simulation(kind.make(options.seed), options);
  if (auto started = simulation.start(); !started) return started;
  fmt::print("lss-sim: {} ready{}\n", kind.name(), simulation.ports());
  std::fflush(stdout);

  pollfd files[] = {{signals.get(), POLLIN, 0}, {control->fd(), POLLIN, 0}};
  StandstillWatch watch;
  double wall_s = 0;
  TimeNs before = 0;  // of the wall clock, at the last progress of simulated time
  while ((files[0].revents & POLLIN) == 0 && !simulation.over()) {
    const int polled = ::poll(files, 2, options.lockstep ? kLookMs : -1);
    if (options.lockstep) {
      watch.look();
      const TimeNs wall = lockstep::wall_now();
      if (simulation.simulated_s() > 0 && before != 0)
        wall_s += static_cast<double>(wall - before) * 1e-9;
      before = wall;
    }
    if (polled < 0) continue;
    if ((files[1].revents & POLLIN) == 0) continue;
    control->serve([&](const std::string& text) -> std::string {
      const auto fault = parse_fault(text, kinds);
      if (!fault) return fault.error();
      simulation.inject(*fault);
      return {};
    });
  }
  const double simulated_s = simulation.simulated_s();
  simulation.stop();
  if (options.lockstep && wall_s > 0) tell_pace(simulated_s, wall_s, options.speed);
  if (simulation.slipped_s() > 0) {
    fmt::print(stderr, "lss-sim: the machine was too slow: {:.2f} s of {:.2f} s were slipped\n",
               simulation.slipped_s(), simulation.slipped_s() + simulation.simulated_s());
  }
  return {};
}

}  // namespace lss::sim
