#include "tests/talaris/chain/chain.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string_view>

#include "tools/lss-sim/frame/runner.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kHeartbeatEvery = 200 * kMillisecond;
constexpr TimeNs kReportEvery = 5 * kMillisecond;  // as daemon/runtime/can_bus.h
constexpr std::uint32_t kLease_ms = 60'000;

// As in daemon/vehicles/talaris/wiring.cpp.
const Logic& kLogic = logic();

config::Config read(Parameters& parameters, const Chain::Options& options) {
  const std::string path = std::string(LSS_CAMPAIGNS) + "/" + options.config + ".toml";
  auto config = config::load(path, {"talaris"}, [&](const std::string&, config::Section& s) {
    parameters = read_parameters(s);
  });
  if (!config) throw std::runtime_error(config.error());
  parameters.offset_ns = config->offset_ns;
  parameters.flight.offset_s = static_cast<double>(config->offset_ns) * 1e-9;
  if (options.adjust) options.adjust(parameters);
  parameters.buses = complete(parameters.buses, *config);
  return *config;
}

std::unique_ptr<sim::talaris::Talaris> make(sim::talaris::TalarisOptions world, unsigned seed) {
  world.seed = seed;
  return std::make_unique<sim::talaris::Talaris>(world);
}

std::unique_ptr<SensorLine> imu_driver(const BusesParameters& p) {
  if (p.imu == ImuKind::crossbow) return std::make_unique<Crossbow>(p.crossbow);
  return std::make_unique<LandMark30>(p.landmark);
}

std::uint32_t packets(const BusesParameters& p) {
  return static_cast<std::uint32_t>(p.imu == ImuKind::crossbow ? p.crossbow.packets_per_frame
                                                               : p.landmark.packets_per_frame);
}

Name name(const char* text) {
  Name name{};
  std::string_view(text).copy(name.data(), name.size() - 1);
  return name;
}

// The DDS writer of every command.
constexpr std::uint64_t kWriter = 1;

TimeNs to_ns(double seconds) { return std::llround(seconds * 1e9); }

template <std::size_t N>
bool among(const std::array<std::string_view, N>& names, std::string_view name) {
  return std::ranges::find(names, name) != names.end();
}
constexpr std::array<std::string_view, 4> kUnknown = {"unplug", "line-unplug", "bus-off", ""};

}  // namespace

Chain::Chain(const Options& options)
    : config_(read(parameters_, options)),
      late_share_(options.late_share),
      late_s_(options.late_s),
      lateness_(options.seed + 5),
      world_(make(options.world, options.seed)),
      wire_(std::make_unique<sim::CanBus>(sim::CanBus::Parameters{.seed = options.seed + 1},
                                          *world_)),
      fault_kinds_(sim::fault_kinds_of(*sim::make_talaris_kind())),
      board_(std::make_unique<sim::FaultBoard>(
          [this](const sim::Fault& fault, bool attach) { act(fault, attach); },
          [this](const sim::Fault& fault) { return world_->in_force(fault); })),
      imu_(world_->lines()[0], imu_driver(parameters_.buses), options.seed + 2, kBegin),
      altimeter_(world_->lines()[1], std::make_unique<Ar1000>(parameters_.buses.altimeter),
                 options.seed + 3, kBegin),
      master_(parameters_.buses.can),
      valves_(parameters_.buses.valves),
      grid_({.packets = packets(parameters_.buses),
             .period_ns = config_.period_ns,
             .grace_ns = parameters_.buses.grace_ns},
            kBegin),
      vehicle_(parameters_),
      supervisor_(kLogic, {.obc_timeout_ns = config_.obc_timeout_ns}),
      port_(kLogic, static_cast<std::uint32_t>(config_.lease_min_ms),
            static_cast<std::uint32_t>(config_.lease_max_ms), [this] { latch_.ask(now_ns_); }) {
  port_.show(supervisor_.state());
  // The clocks of OBC and vehicle do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, sim::kStepNs - 1)(random);
  for (int ms = std::uniform_int_distribution(0, 199)(random); ms > 0; --ms) world_->step();
  master_.restart(now_ns_);
  valves_.reopened(now_ns_);
  can_.open = can_.was_open = true;
  turn_can();
}

Chain::~Chain() = default;

// ---- time

TimeNs Chain::next_event() {
  return std::min({step_ns_, imu_.next_wake(), altimeter_.next_wake(), wire_->next_wake(),
                   std::max(master_.next_wake(), now_ns_ + 1),
                   std::max(valves_.next_wake(), now_ns_ + 1), grid_.deadline(), release_ns_,
                   heartbeat_ns_});
}

void Chain::pass(TimeNs until) {
  for (TimeNs next = next_event(); next <= until; next = next_event()) {
    now_ns_ = std::max(next, now_ns_);
    happen();
  }
  now_ns_ = until;
}

// Everything that is due now. Of one instant: the world, then threads by priority.
void Chain::happen() {
  if (now_ns_ >= step_ns_) {
    world_->step();
    step_ns_ += sim::kStepNs;
    if (after_step) after_step();
  }
  if (now_ns_ >= heartbeat_ns_) {
    heartbeat_ns_ += kHeartbeatEvery;
    if (heartbeat_) post({.source = name("test")});
  }
  obey();
  if (now_ns_ >= release_ns_) {
    release();
  } else if (now_ns_ >= valves_.next_wake()) {
    send_edges(valves_.next_wake());
  }
  imu_.turn(now_ns_);
  altimeter_.turn(now_ns_);
  turn_can();
  begin_frame();
}

void Chain::run(double seconds) { pass(now_ns_ + to_ns(seconds)); }

bool Chain::run_until(const std::function<bool()>& condition, double limit_s) {
  const TimeNs end = now_ns_ + to_ns(limit_s);
  for (std::uint64_t seen = frames(); now_ns_ < end;) {
    pass(std::min(end, next_event()));
    if (frames() == seen) continue;
    seen = frames();
    if (condition()) return true;
  }
  return false;
}
bool Chain::run_until(State state, double limit_s) {
  return run_until([&] { return this->state() == state; }, limit_s);
}
bool Chain::run_until(Mode mode, double limit_s) {
  return run_until([&] { return this->mode() == mode; }, limit_s);
}
bool Chain::run_until(Phase phase, double limit_s) {
  return run_until([&] { return this->phase() == phase; }, limit_s);
}

// ---- the actuate thread, as daemon/vehicles/talaris/actuation.cpp

void Chain::release() {
  const TimeNs due_ns = release_ns_;
  release_ns_ = kNever;
  if (!latch_.passes(out_.command.all_stop, out_.command.boundary_ns)) {
    ++edges_.refused_orders;
    return send_edges(now_ns_);
  }
  TalarisOrders due = out_.command;
  due.release_ns = due_ns;
  valves_.release(due, now_ns_);
  send_edges(due_ns);
  master_.release(due, now_ns_);
  reset_serial_ = due.node_reset_serial;
}

// Actions without an order of the cycle.
void Chain::obey() {
  if (!latch_.fell()) return;
  valves_.all_stop(now_ns_);
  send_edges(now_ns_);
  master_.release({.issued_ns = now_ns_,
                   .boundary_ns = now_ns_,
                   .release_ns = now_ns_,
                   .all_stop = true,
                   .node_reset_serial = reset_serial_},
                  now_ns_);
}

void Chain::send_edges(TimeNs due_ns) {
  const std::uint8_t before = valves_.open();
  for (CanFrame frame; valves_.due(now_ns_, frame);) {
    wire_->from_master(frame, now_ns_);
    valves_.sent(true, now_ns_);
  }
  const std::uint8_t after = valves_.open();
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (((before ^ after) >> i & 1) == 0) continue;
    ((after >> i & 1) != 0 ? edges_.opened_ns : edges_.shut_ns)[i] = now_ns_;
    edges_.last_ns = now_ns_;
    edges_.last_late_ns = now_ns_ - due_ns;
  }
  edges_.open = after;
  edges_.counters = valves_.counters();
  edges_.all_stop_pending = latch_.pending();
}

// ---- the bus thread, as daemon/runtime/can_bus.h

void Chain::turn_can() {
  wire_->advance(now_ns_);
  for (CanFrame heard : wire_->take(now_ns_)) {
    heard.time_ns = now_ns_;
    ++can_.port.received;
    master_.receive({&heard, 1});
  }
  for (CanFrame sent; master_.transmit(now_ns_, sent); ++can_.port.sent)
    wire_->from_master(sent, now_ns_);
  wire_->advance(now_ns_);
  std::array<TalarisSample, HopperBus::kMaxSamples> samples;
  const std::size_t count = master_.take(samples);
  for (std::size_t i = 0; i < count; ++i) samples_.push(samples[i]);
  if (now_ns_ - can_.time_ns < kReportEvery) return;
  can_.status = master_.status();
  can_.time_ns = now_ns_;
}

// ---- the frame thread, as daemon/runtime/frames.h and runtime.h

void Chain::begin_frame() {
  if (FrameTick tick; imu_.take_tick(tick)) {
    if (grid_.arrived(tick.index, tick.time_ns, boundary_)) frame(boundary_);
  } else if (now_ns_ >= grid_.deadline()) {
    grid_.held(now_ns_, boundary_);
    frame(boundary_);
  }
}

void Chain::collect(const Boundary& boundary) {
  in_.frame = boundary.frame;
  in_.time_ns = boundary.time_ns;
  in_.held = boundary.held;
  in_.sample_count = 0;
  const auto take = [&](auto&& pop) {
    while (in_.sample_count < in_.samples.size() && pop(in_.samples[in_.sample_count]))
      ++in_.sample_count;
  };
  take([&](TalarisSample& s) { return imu_.pop(s, in_.time_ns); });
  take([&](TalarisSample& s) { return altimeter_.pop(s, in_.time_ns); });
  take([&](TalarisSample& out) {
    return samples_.pop_if(out, [&](const TalarisSample& s) { return s.time_ns < in_.time_ns; });
  });
  in_.bus = {.imu = imu_.report(), .altimeter = altimeter_.report(), .can = can_, .edges = edges_};
  in_.request_count = port_.take(in_.requests);
}

void Chain::frame(const Boundary& boundary) {
  collect(boundary);
  cycle(vehicle_, supervisor_, in_, out_, [](Stage) {});
  if (tape) tape(in_, out_, supervisor_, vehicle_);
  port_.show(supervisor_.state());
  const Supervisor::Outbox& box = supervisor_.outbox();
  acks.insert(acks.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
  events.insert(events.end(), box.events.begin(), box.events.begin() + box.event_count);
  release_ns_ = std::max(boundary.time_ns + config_.offset_ns, now_ns_);
  if (late_share_ > 0 && std::bernoulli_distribution(late_share_)(lateness_))
    release_ns_ += to_ns(std::uniform_real_distribution(0.0, late_s_)(lateness_));
  if (after_frame) after_frame();
}

// ---- actions of an operator

void Chain::post(Request request) {
  request.arrival_ns = now_ns_;
  port_.receive(request, kWriter, [this](const Ack& ack) { acks.push_back(ack); });
}

std::uint64_t Chain::send(std::uint16_t kind, std::span<const double> parameters) {
  Request request{
      .source = name("test"), .sequence = ++sequence_, .kind = kind, .lease_ms = kLease_ms};
  std::ranges::copy(parameters, request.parameter.begin());
  post(request);
  return sequence_;
}

bool Chain::start() {
  const auto contact = [this] {
    const auto& c = supervisor().controller;
    return c.unheard == 0 && c.silent == 0 && frames() > 10 && telemetry().modules[0].online &&
           (!parameters_.navigation.altimeter || telemetry().modules[1].online);
  };
  if (!run_until(contact, 10)) return false;
  send(lss::CommandKind::start);
  return run_until(Mode::manual, 2);
}

bool Chain::arm() {
  send(CommandKind::edf_arm, {0});
  return run_until([&] { return telemetry().fans[0].armed; }, 3);
}

bool Chain::calibrate() {
  send(CommandKind::gnc, {static_cast<double>(GncStep::standby)});
  if (!run_until(Mode::standby, 1)) return false;
  send(CommandKind::gnc, {static_cast<double>(GncStep::calibrate)});
  if (!run_until(Mode::calibrate, 1)) return false;
  return run_until(Mode::standby, parameters_.navigation.calibration_s + 20) &&
         telemetry().calibrated;
}

bool Chain::fly(Program program, const HopRequest& request) {
  send(CommandKind::plan, {static_cast<double>(program), request.height_m, request.distance_m,
                           request.turn_rad, request.time_s});
  if (!run_until([&] { return telemetry().planned; }, 1)) return false;
  send(CommandKind::gnc, {static_cast<double>(GncStep::execute)});
  return run_until(Mode::execute, 1);
}

Reason Chain::rejected() const {
  const auto found = std::find_if(acks.rbegin(), acks.rend(),
                                  [](const Ack& ack) { return ack.phase == lss::Phase::rejected; });
  return found != acks.rend() ? found->verdict.reason : Reason::none;
}

// ---- faults

void Chain::inject(const std::string& text) {
  const auto fault = sim::parse_fault(text, fault_kinds_);
  if (!fault) throw std::runtime_error(fault.error());
  board_->inject(*fault);
}

// As lss-sim does (tools/lss-sim/frame/runner.cpp).
void Chain::act(const sim::Fault& fault, bool attach) {
  const std::string_view kind = fault.kind->name;
  if (among(kUnknown, kind))
    throw std::runtime_error("the chain has no port: it knows no fault \"" + std::string(kind) +
                             "\"");
  if (kind.starts_with("line-")) {
    (fault.values.front() < 1.5 ? imu_ : altimeter_).faults().set(fault, attach);
  } else if (!wire_->faults.set(fault, attach)) {
    world_->set_fault(fault, attach);
  }
}

// ---- true state

bool Chain::has(FaultId id, std::uint16_t subject) const {
  return std::ranges::any_of(supervisor().faults, [&](const FaultRecord& fault) {
    return fault.id == id && fault.subject == subject;
  });
}

bool Chain::rests() const {
  return mode() != Mode::execute && body().velocity_m_s.norm() < 0.02 &&
         body().rate_B_rad_s.norm() < 0.05;
}

}  // namespace lss::talaris
