#pragma once

// The running daemon of one vehicle: its threads and the data between them (picture in
// docs/architecture.md). bus/NAME move bytes, frame runs the cycle at every boundary, actuate
// releases the command of the frame at the offset, the DDS listener queues requests, publish sends
// the output of the frame. frame, actuate and bus are real-time: they never allocate, lock, log or
// call DDS.
//
// Vehicle has what daemon/cycle/cycle.h needs. Buses is the vehicle's wiring and has
//   Buses(config, parameters), probe() -> expected, bodies() -> {name, function}, stop(),
//   collect(Inputs&) (frame thread), release(const Command&) (actuate thread),
//   progress(), all_stop(): called at an emergency stop, by any thread; does not wait;
// and optionally
//   Frames, frames() -> Frames&: decides when frames begin, started by start(epoch); default: the
//   clock,
//   actuation(): what the actuate thread does between releases (NoWork in daemon/runtime/frames.h);
//   then also release(Command, Boundary),
//   wrong_configuration(): as of App.
// The vehicle's structs are described for records in daemon/vehicles/NAME/record.h.

#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cstring>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

#include "daemon/app/app.h"
#include "daemon/config/config.h"
#include "daemon/cycle/cycle.h"
#include "daemon/cycle/ending.h"
#include "daemon/cycle/twins.h"
#include "daemon/parameters/saver.h"
#include "daemon/parameters/start.h"
#include "daemon/publish/dictionary_of.h"
#include "daemon/publish/publisher.h"
#include "daemon/record/build.h"
#include "daemon/record/certificate.h"
#include "daemon/record/frame_log.h"
#include "daemon/record/frame_record.h"
#include "daemon/record/schema.h"
#include "daemon/record/state.h"
#include "daemon/record/vehicle_records.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/command_port.h"
#include "daemon/runtime/frame_engine.h"
#include "daemon/runtime/service_manager.h"
#include "daemon/runtime/thread.h"

namespace lss {

// Where a vehicle's frames begin.
template <class Buses>
struct FramesOf {
  using Type = ClockFrames;
};
template <class Buses>
requires requires { typename Buses::Frames; }
struct FramesOf<Buses> {
  using Type = typename Buses::Frames;
};

template <class Vehicle, class Buses>
class Runtime final : public App {
 public:
  using Parameters = typename Buses::Parameters;
  using Frames = typename FramesOf<Buses>::Type;

  // `start`: state of the parameters, which `parameters` already contains.
  Runtime(const config::Config& config, const Parameters& parameters, const ParameterStart& start,
          const Logic& logic, const Vocabulary& vocabulary, const record::VehicleRecords& records)
      : config_(with_saved(config, start)),
        buses_(config_, parameters),
        vehicle_(parameters),
        supervisor_(logic, {.obc_timeout_ns = config.obc_timeout_ns}),
        port_(logic, static_cast<std::uint32_t>(config.lease_min_ms),
              static_cast<std::uint32_t>(config.lease_max_ms), [this] { buses_.all_stop(); }),
        publisher_(config_, logic, vocabulary,
                   dictionary_of<typename Vehicle::Telemetry>(config.vehicle, logic, vocabulary)),
        frame_log_({.folder = config_.log_folder,
                    .files = config_.log_files,
                    .vehicle_id = config_.vehicle_id,
                    .header = {{"vehicle", config_.vehicle},
                               {"vehicle_id", config_.vehicle_id},
                               {"version", LSS_VERSION}},
                    .presets = config_.running_log_presets(),
                    .recorder = flight_recorder(config_, records, publisher_.dictionary())},
                   records.to_json),
        saver_(start.store, start.isolation.store, logic.tunables, start.configured,
               [this] { publisher_.wake(); }),
        isolation_of_(logic.isolation_of),
        isolated_(isolation_of_ != nullptr ? start.isolation.modules : std::uint16_t{0}),
        isolate_first_(isolated_) {
    port_.show(supervisor_.state());
    twins_.seal(vehicle_, supervisor_);
    std::vector<Publisher::Told> told = told_of(start);
    if (const std::string refused = take_certificate(); !refused.empty())
      told.push_back({EventId::certificate_refused, refused});
    publisher_.parameters(report_of(start, logic.tunables, vehicle_.tunables()), std::move(told));
  }
  ~Runtime() override { stop(); }

  std::string wrong_configuration() const override {
    if constexpr (requires { buses_.wrong_configuration(); }) {
      return buses_.wrong_configuration();
    } else {
      return "";
    }
  }

  tl::expected<void, Refusal> start() override {
    const auto refuse = [](const std::string& why) { return tl::unexpected(Refusal{why}); };
    if (auto ok = buses_.probe(); !ok) return refuse(ok.error());
    // DDS first: its threads inherit the ordinary scheduling of this one.
    if (auto ok = publisher_.open([this](const Request& r, std::uint64_t writer) {
          port_.receive(r, writer, [&](const Ack& ack) {
            publisher_.answer(ack, {r.name.data(), ::strnlen(r.name.data(), r.name.size())});
          });
        });
        !ok) {
      return ok;
    }
    const auto locked = rt::lock_memory();
    if (!locked && config_.realtime_enforce) return refuse(locked.error());
    if (!locked) publisher_.complain(locked.error());
    publisher_.memory_locked(locked.has_value());
    rt::populate_memory();

    frame_log_.start();
    saver_.start();
    engine_ = std::make_unique<Engine>(start_frames(), engine_parameters());
    for (auto& [name, body] : buses_.bodies()) {
      if (auto ok = launch(name, std::move(body)); !ok) return refuse(ok.error());
    }
    if (auto ok = launch("actuate", [this] { actuate(); }); !ok) return refuse(ok.error());
    if (auto ok = launch("frame", [this] { frame(); }); !ok) return refuse(ok.error());
    if (!lockstep::on()) {
      if (auto ok = await_frames(); !ok) return refuse(ok.error());
    }
    for (const auto& thread : threads_) thread->mark_ready();
    publisher_.start(threads_,
                     {.newest_telemetry = [this] { return newest_telemetry(); },
                      .telemetry_missed = [this] { return telemetry_.replaced(); },
                      .commands_refused = [this] { return port_.refused(); },
                      .log_event = [this](EventId& e) { return frame_log_.pop(e); },
                      .log_dropped = [this] { return frame_log_.dropped(); },
                      .recording = [this] { return frame_log_.recording(); },
                      .parameters_saved = [this](SaveResult& r) { return saver_.pop(r); }});
    if (!lockstep::on()) return {};
    constexpr unsigned kOthers = 3;  // publish, log, save
    if (!lockstep::begin(static_cast<unsigned>(threads_.size()) + kOthers))
      return refuse("lockstep: a thread does not start");
    if (auto ok = await_frames(); !ok) return refuse(ok.error());
    return {};
  }

  void stop() override {
    if (threads_.empty()) return;
    shut_down_ = true;
    land();
    Ending ending(engine_->frames(), now_ns());
    await(INT64_MAX, config_.period_ns,
          [&] { return ending.over(engine_->frames(), now_ns(), may_be_left_); });
    engine_->stop();
    buses_.stop();
    lockstep::leave();
    for (const auto& thread : threads_) thread->join();
    saver_.stop();
    publisher_.stop();
    frame_log_.stop();
    threads_.clear();
  }

  std::vector<Progress> progress() const override {
    std::vector<Progress> all{{"frame", engine_->frames()}, {"actuate", engine_->releases()}};
    std::ranges::move(buses_.progress(), std::back_inserter(all));
    all.push_back({"publish", publisher_.turns()});
    all.push_back({"log", frame_log_.turns()});
    return all;
  }
  void keep_frames() override { frame_log_.keep(); }
  void program_damaged() override { program_damaged_ = true; }
  std::string summary() const override { return publisher_.summary(); }
  const char* restart_reason() const override { return publisher_.restart_reason(); }

 private:
  static constexpr TimeNs kStandstill = 3 * kSecond;  // of simulated time, by the machine's clock

  using Engine = FrameEngine<Frames, typename Vehicle::Command>;

  // The daemon is READY when frames run: the first frame gives the safe command to the buses.
  tl::expected<void, std::string> await_frames() {
    const TimeNs until = now_ns() + 5 * kSecond;
    await(until, kMillisecond / 4, [this] { return engine_->frames() != 0; });
    if (engine_->frames() == 0 && now_ns() >= until)
      return tl::unexpected(std::string(
          "the frame thread does not run: check the CPU numbers and priorities in [realtime]"));
    return {};
  }

  // A flying vehicle lands first, however long that takes: its flight has limits of its own. The
  // service manager gives the time, if it is asked again and again. Without frames it cannot land.
  void land() {
    constexpr TimeNs kFrameless = 3 * kSecond;
    for (std::uint64_t seen = 0; airborne_ && engine_->frames() != seen;) {
      seen = engine_->frames();
      tell_service_manager("EXTEND_TIMEOUT_USEC=10000000");
      await(now_ns() + kFrameless, config_.period_ns, [this] { return !airborne_; });
    }
  }

  // Looks every `step`. Simulated time may have ended, or stand still: it waits for a client, or
  // for another process.
  template <class Done>
  static void await(TimeNs until, TimeNs step, Done done) {
    TimeNs seen = now_ns(), moved = machine_ns();
    while (!done() && now_ns() < until && !(lockstep::on() && lockstep::over())) {
      if (const TimeNs now = now_ns(); now != seen) {
        seen = now;
        moved = machine_ns();
      }
      if (machine_ns() - moved > kStandstill) return;
      sleep_until(seen + step);
    }
  }

  // Frame 1 begins 1 to 2 ms from now, on a whole millisecond of the monotonic clock. If a sensor
  // begins the frames, it begins after the sensor has had time to send.
  Frames& start_frames() {
    const TimeNs epoch = (now_ns() / kMillisecond + 2) * kMillisecond - config_.period_ns;
    if constexpr (std::is_same_v<Frames, ClockFrames>) {
      frames_ = std::make_unique<Frames>(FrameClock(epoch, config_.period_ns, config_.offset_ns));
      return *frames_;
    } else {
      buses_.frames().start(epoch);
      return buses_.frames();
    }
  }

  tl::expected<void, std::string> launch(const std::string& name, std::function<void()> body) {
    rt::ThreadRequest request{.name = name};
    for (const config::Thread& t : config_.threads) {
      if (t.name == name) request = {.name = name, .priority = t.priority, .cpu = t.cpu};
    }
    threads_.push_back(std::make_unique<rt::Thread>());
    auto ok = threads_.back()->start(request, config_.realtime_enforce, std::move(body));
    if (!ok && !config_.realtime_enforce) {
      publisher_.complain(ok.error());
      return {};
    }
    return ok;
  }

  FrameParameters engine_parameters() const {
    FrameParameters p{.period_ns = config_.period_ns,
                      .offset_ns = config_.offset_ns,
                      .max_consecutive_overruns = config_.max_consecutive_overruns};
    for (const config::Thread& t : config_.threads) {
      if (t.name == "frame") p.frame_spin_ns = t.spin_ns;
      if (t.name == "actuate") p.actuate_spin_ns = t.spin_ns;
    }
    return p;
  }

  // For the header of recordings.
  static config::Config with_saved(config::Config config, const ParameterStart& start) {
    config.saved = start.taken.values;
    return config;
  }

  // Events about the saved parameters.
  static std::vector<Publisher::Told> told_of(const ParameterStart& start) {
    std::vector<Publisher::Told> told;
    for (const std::string& trouble : start.loaded.troubles)
      told.push_back({EventId::parameters_damaged, "saved parameters: " + trouble});
    for (const std::string& trouble : start.isolation.troubles)
      told.push_back({EventId::parameters_damaged, "saved modules out of service: " + trouble});
    for (const std::string& refused : start.taken.refused)
      told.push_back({EventId::parameters_refused, "saved parameter ignored: " + refused});
    if (start.loaded.state == SavedState::lost) {
      told.push_back({EventId::parameters_refused,
                      "no undamaged copy of the saved parameters: the configuration applies"});
    }
    if (start.loaded.taken) {
      told.push_back({EventId::parameters_taken,
                      "",
                      {static_cast<double>(start.taken.values.size()),
                       static_cast<double>(start.loaded.taken->number)}});
    }
    return told;
  }

  // Why the configured certificate is not valid here. Empty: it is used, or none is configured.
  std::string take_certificate() {
    if (config_.certificate.empty()) return "";
    const auto made = record::read_certificate(config_.certificate);
    const std::string why =
        made ? record::not_valid(made->on, record::certified_here(
                                               record::program_version(LSS_VERSION), config_.text))
             : made.error();
    if (why.empty()) {
      publisher_.certificate(*made);
      return "";
    }
    return "timing certificate rejected; make a new one with lss-cli timing certify: " + why;
  }

  static std::optional<record::RecorderSettings> flight_recorder(
      const config::Config& config, const record::VehicleRecords& records,
      const std::string& dictionary) {
    if (!config.recorder.record) return std::nullopt;
    return record::recorder_settings(config, LSS_VERSION, records.schema(), records.state_layout(),
                                     dictionary);
  }

  // Publish thread: nullptr when there is nothing new.
  const void* newest_telemetry() {
    if (!telemetry_.update()) return nullptr;
    return &telemetry_.value();
  }

  void frame() noexcept;
  void actuate() noexcept;
  void collect(const Boundary& boundary, const Released& released, TimingPoints& timing) noexcept;
  void hand_over(const TimingPoints& timing) noexcept;
  void ask_to_save() noexcept;
  void isolate_as_before() noexcept;
  void save_isolation() noexcept;
  void record_frame(const TimingPoints& timing) noexcept;

  config::Config config_;
  Buses buses_;
  Vehicle vehicle_;
  Supervisor supervisor_;
  CommandPort port_;
  Publisher publisher_;
  record::FrameLog frame_log_;
  ParameterSaver saver_;
  // Modules out of service: those that are saved, and those that the first frames must isolate.
  Request (*isolation_of_)(unsigned module);
  std::uint16_t isolated_, isolate_first_;
  std::unique_ptr<Frames> frames_;  // empty: the buses have them
  std::unique_ptr<Engine> engine_;

  Inputs<Vehicle> in_;
  Outputs<Vehicle> out_;
  Twins<Vehicle> twins_;
  // Space for any record and for the state of the vehicle.
  std::array<std::uint8_t,
             std::max(sizeof(record::FrameRecord<Vehicle>),
                      sizeof(Vehicle) + sizeof(Supervisor) + sizeof(typename Vehicle::Telemetry))>
      scratch_{};
  Latest<typename Vehicle::Telemetry> telemetry_;
  std::uint32_t changes_ = 0;  // of parameters already shown
  std::atomic<bool> shut_down_{false}, airborne_{false}, may_be_left_{false},
      program_damaged_{false};
  std::vector<std::unique_ptr<rt::Thread>> threads_;
};

// The frame thread.
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::frame() noexcept {
  engine_->frame(
      [this](const Boundary& boundary, const Released& released,
             TimingPoints& timing) noexcept -> const typename Vehicle::Command& {
        collect(boundary, released, timing);
        cycle(vehicle_, supervisor_, in_, out_, [&](Stage stage) {
          if (stage == Stage::navigated) timing.navigated_ns = now_ns();
        });
        return out_.command;
      },
      [this](const TimingPoints& timing) noexcept { hand_over(timing); });
}

// The actuate thread.
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::actuate() noexcept {
  using Command = typename Vehicle::Command;
  if constexpr (requires { buses_.actuation(); }) {
    engine_->actuate(
        [this](const Command& command, const Boundary& boundary) noexcept {
          buses_.release(command, boundary);
        },
        buses_.actuation());
  } else {
    engine_->actuate([this](const Command& command) noexcept { buses_.release(command); });
  }
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::collect(const Boundary& boundary, const Released& released,
                                      TimingPoints& timing) noexcept {
  in_.memory = twins_.check(vehicle_, supervisor_);
  if (program_damaged_.load(std::memory_order_relaxed)) in_.memory = MemoryCheck::lost;
  in_.frame = boundary.frame;
  in_.time_ns = boundary.time_ns;
  in_.held = boundary.held;
  buses_.collect(in_);
  in_.request_count = port_.take(in_.requests);
  isolate_as_before();
  in_.late_commands = released.overruns;
  in_.overrun_limit = released.limit;
  in_.shut_down = shut_down_.load(std::memory_order_relaxed);
  timing.samples = in_.sample_count;
  timing.read_ns = now_ns();
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::hand_over(const TimingPoints& timing) noexcept {
  twins_.seal(vehicle_, supervisor_);
  port_.show(supervisor_.state());
  const bool airborne = supervisor_.airborne();
  publisher_.airborne(airborne);
  airborne_.store(airborne, std::memory_order_relaxed);
  may_be_left_.store(may_be_left(vehicle_, supervisor_.controller()), std::memory_order_relaxed);
  const TunableValues& parameters = vehicle_.tunables();
  if (std::exchange(changes_, parameters.changes) != parameters.changes) publisher_.put(parameters);
  publisher_.put(supervisor_.outbox());
  ask_to_save();
  save_isolation();
  publisher_.put(supervisor_.state());
  publisher_.put(timing);
  if (config_.telemetry_periodic || out_.data_requested) telemetry_.put(out_.telemetry);
  publisher_.wake();
  record_frame(timing);
}

// Called after the acknowledgements so far were put, so that the answer of the save thread follows
// them.
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::ask_to_save() noexcept {
  const SupervisorState::Active* asked = supervisor_.save_asked();
  if (asked == nullptr || saver_.ask({*asked, vehicle_.tunables()})) return;
  publisher_.put(Ack{.source = asked->source,
                     .sequence = asked->sequence,
                     .kind = asked->kind,
                     .phase = Phase::failed,
                     .verdict = {.reason = Reason::busy},
                     .time_ns = in_.time_ns});
}

// Isolates the saved modules by commands of the first frame, so that recordings contain them.
template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::isolate_as_before() noexcept {
  for (; isolate_first_ != 0 && in_.request_count < in_.requests.size();
       isolate_first_ = static_cast<std::uint16_t>(isolate_first_ & (isolate_first_ - 1))) {
    Request request = isolation_of_(static_cast<unsigned>(std::countr_zero(isolate_first_)) + 1);
    constexpr std::string_view kName = "lssd";
    std::ranges::copy(kName, request.source.begin());
    request.flags = kFlagSaved;
    request.arrival_ns = in_.time_ns;
    in_.requests[in_.request_count++] = request;
  }
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::save_isolation() noexcept {
  const std::uint16_t isolated = supervisor_.controller().isolated;
  if (isolation_of_ == nullptr || isolated == isolated_ || isolate_first_ != 0) return;
  if (saver_.ask({.command = {}, .values = {}, .isolation = true, .isolated = isolated}))
    isolated_ = isolated;
}

template <class Vehicle, class Buses>
void Runtime<Vehicle, Buses>::record_frame(const TimingPoints& timing) noexcept {
  record::Writer writer(scratch_);
  fields(writer,
         record::FrameView<Vehicle>{in_, out_.command, supervisor_.outbox(), supervisor_.state(),
                                    out_.telemetry, out_.data_requested, timing});
  if (!writer.fits()) return;  // a struct names a member twice
  const Supervisor::Outbox& outbox = supervisor_.outbox();
  frame_log_.put({.fault = record::first_fault(outbox),
                  .events = outbox.event_count + outbox.ack_count + outbox.dropped != 0,
                  .time_ns = in_.time_ns},
                 std::span(scratch_).first(writer.size()));
  if (!frame_log_.wants_state()) return;
  record::StateWriter state(scratch_);
  record::keep(state, vehicle_, supervisor_, out_.telemetry);
  if (state.fits()) frame_log_.put_state(std::span(scratch_).first(state.size()));
}

}  // namespace lss
