#include "tests/zebro/chain/chain.h"

#include <algorithm>
#include <random>
#include <stdexcept>

#include "tools/lss-sim/frame/runner.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr TimeNs kHeartbeatEvery = 200 * kMillisecond;
constexpr std::uint32_t kLease_ms = 2000;

const Logic& kLogic = logic();

config::Config read(Parameters& parameters) {
  auto config = config::load(LSS_CONFIG, {"zebro"}, [&](const std::string&, config::Section& s) {
    parameters = read_parameters(s);
  });
  if (!config) throw std::runtime_error(config.error());
  return *config;
}

Name name(const char* text) {
  Name name{};
  std::string_view(text).copy(name.data(), name.size() - 1);
  return name;
}

// The DDS writer of every command.
constexpr std::uint64_t kWriter = 1;

TimeNs to_ns(double seconds) { return std::llround(seconds * 1e9); }

}  // namespace

Chain::Chain(const Options& options)
    : config_(read(parameters_)),
      supervisor_(kLogic, {.obc_timeout_ns = config_.obc_timeout_ns}),
      port_(kLogic, static_cast<std::uint32_t>(config_.lease_min_ms),
            static_cast<std::uint32_t>(config_.lease_max_ms), [this] { bus_->all_stop(now_ns_); }) {
  own_codes = kLogic.codes;
  const config::Port& port = config_.ports.front();
  parameters_.bus.baud = static_cast<int>(port.baud);
  parameters_.bus.half_duplex = port.half_duplex;
  parameters_.bus.period_ns = config_.period_ns;
  if (options.adjust) options.adjust(parameters_);
  vehicle_ = std::make_unique<Vehicle>(parameters_);

  sim::zebro::TerrainOptions terrain = options.terrain;
  terrain.seed = options.seed;
  world_ = options.vehicle ? options.vehicle(terrain)
                           : std::make_unique<sim::zebro::Zebro>(
                                 sim::zebro::ZebroOptions{.terrain = terrain,
                                                          .check = parameters_.bus.check,
                                                          .stop = parameters_.bus.stop,
                                                          .plant = options.plant});
  if (options.whole_frames) {
    auto bus = std::make_unique<FrameBus>(parameters_.bus, *world_, options.seed + 1);
    frame_bus_ = bus.get();
    bus_ = std::move(bus);
    bus_->plug(true, now_ns_);
  } else {
    line_ = std::make_unique<sim::Uart>(
        sim::Uart::Parameters{.baud = parameters_.bus.baud, .seed = options.seed + 1}, *world_);
    bus_ = std::make_unique<BusLine>(parameters_.bus, *line_);
  }
  fault_kinds_ = sim::fault_kinds_of(*sim::make_zebro_kind());
  board_ = std::make_unique<sim::FaultBoard>(
      [this](const sim::Fault& fault, bool attach) { act(fault, attach); },
      [this](const sim::Fault& fault) { return in_force(fault); });
  port_.show(supervisor_.state());

  // The clocks of OBC and modules do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, world_->step_ns() - 1)(random);
  frame_ns_ = kBegin + 2 * kMillisecond;
  bus_->turn(now_ns_, {});
}

Chain::~Chain() = default;

// ---- time

TimeNs Chain::next_event() const {
  const TimeNs line_ns = line_ ? line_->next_wake() : kNever;
  return std::min(
      {step_ns_, line_ns, bus_->next_wake(), plug_ns_, frame_ns_, release_ns_, heartbeat_ns_});
}

void Chain::pass(TimeNs until) {
  for (TimeNs next = next_event(); next <= until; next = next_event()) {
    now_ns_ = next;
    happen();
  }
  now_ns_ = until;
}

// Everything that is due now. Of one instant: the world, then threads by priority.
void Chain::happen() {
  if (now_ns_ >= step_ns_) {
    world_->step();
    step_ns_ += world_->step_ns();
  }
  if (now_ns_ >= plug_ns_) {
    plug_ns_ = kNever;
    bus_->plug(true, now_ns_);
  }
  if (now_ns_ >= heartbeat_ns_) {
    heartbeat_ns_ += kHeartbeatEvery;
    if (heartbeat_) post({.source = name("test")});
  }
  if (now_ns_ >= release_ns_) {
    release_ns_ = kNever;
    bus_->release(out_.command);
    bus_->turn(now_ns_, {});
  }
  std::span<const std::uint8_t> bytes;
  if (line_) {
    line_->advance(now_ns_);
    bytes = line_->take(now_ns_);
  }
  const bool due = now_ns_ >= bus_->next_wake() || (frame_bus_ && now_ns_ >= frame_ns_);
  if (!bytes.empty() || due) bus_->turn(now_ns_, bytes);
  if (now_ns_ >= frame_ns_) frame();
}

void Chain::frame() {
  in_.frame += 1;
  in_.time_ns = frame_ns_;
  in_.sample_count = 0;
  while (in_.sample_count < in_.samples.size() &&
         bus_->pop(in_.samples[in_.sample_count], in_.time_ns))
    ++in_.sample_count;
  in_.bus = bus_->report();
  in_.request_count = port_.take(in_.requests);
  cycle(*vehicle_, supervisor_, in_, out_, [](Stage) {});
  if (tape) tape(in_, out_, supervisor_, *vehicle_);
  port_.show(supervisor_.state());
  const Supervisor::Outbox& box = supervisor_.outbox();
  acks.insert(acks.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
  events.insert(events.end(), box.events.begin(), box.events.begin() + box.event_count);
  release_ns_ = frame_ns_ + config_.offset_ns;
  frame_ns_ += config_.period_ns;
}

void Chain::run(double seconds) { pass(now_ns_ + to_ns(seconds)); }

bool Chain::run_until(const std::function<bool()>& condition, double limit_s) {
  const TimeNs end = now_ns_ + to_ns(limit_s);
  while (frame_ns_ <= end) {
    pass(frame_ns_);
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

// ---- actions of an operator

void Chain::post(Request request) {
  request.arrival_ns = now_ns_;
  port_.receive(request, kWriter, [this](const Ack& ack) { acks.push_back(ack); });
}

std::uint64_t Chain::send(std::uint16_t kind, std::span<const double> parameters, const char* from,
                          std::uint16_t flags) {
  Request request{.source = name(from),
                  .sequence = ++sequence_,
                  .kind = kind,
                  .flags = flags,
                  .lease_ms = kLease_ms};
  std::ranges::copy(parameters, request.parameter.begin());
  post(request);
  return sequence_;
}

bool Chain::stand() {
  const auto contact = [this] {
    return supervisor().controller.unheard == 0 && supervisor().controller.silent == 0;
  };
  if (!run_until(contact, 2)) return false;
  send(lss::CommandKind::start, {1});
  return run_until(Mode::standing, 60);
}

bool Chain::walk(bool forward, double heading_rad, gnc::zebro::Speed speed) {
  send(CommandKind::walk, {forward ? 1.0 : 0.0, heading_rad, static_cast<double>(speed)});
  return run_until(Mode::walking, 1);
}

bool Chain::solve(double limit_s) {
  send(lss::CommandKind::solve);
  if (!run_until(State::solve_errors, 0.1)) return false;
  run_until([this] { return state() != State::solve_errors; }, limit_s);
  return state() == State::idle;
}

// ---- faults

void Chain::inject(const std::string& text) {
  const auto fault = sim::parse_fault(text, fault_kinds_);
  if (!fault) throw std::runtime_error(fault.error());
  board_->inject(*fault);
}

// As lss-sim does (tools/lss-sim/frame/runner.cpp).
void Chain::act(const sim::Fault& fault, bool attach) {
  if (fault.kind->name == std::string_view("unplug")) {
    plug_ns_ = attach ? now_ns_ + to_ns(fault.values.front()) : now_ns_;
    if (attach) bus_->plug(false, now_ns_);
  } else if (!(line_ ? line_->faults : frame_bus_->faults).set(fault, attach)) {
    world_->set_fault(fault, attach);
  }
}

bool Chain::in_force(const sim::Fault& fault) const {
  if (fault.kind->name == std::string_view("unplug")) return plug_ns_ != kNever;
  return world_->in_force(fault);
}

// ---- true state

bool Chain::has(FaultId id, std::uint16_t subject) const {
  return std::ranges::any_of(supervisor().faults, [&](const FaultRecord& fault) {
    return fault.id == id && fault.subject == subject;
  });
}

bool Chain::has_fatal() const {
  return std::ranges::any_of(supervisor().faults, [](const FaultRecord& fault) {
    return fault.id != FaultId::none &&
           info(fault.id)->severity == static_cast<std::uint8_t>(Severity::fatal);
  });
}

const Ack* Chain::last_ack(std::uint64_t sequence) const {
  const auto found = std::find_if(acks.rbegin(), acks.rend(),
                                  [&](const Ack& ack) { return ack.sequence == sequence; });
  return found == acks.rend() ? nullptr : &*found;
}

const EventRecord* Chain::last(EventId id) const {
  const auto found = std::find_if(events.rbegin(), events.rend(), [&](const EventRecord& event) {
    return event.id == static_cast<std::uint16_t>(id);
  });
  return found == events.rend() ? nullptr : &*found;
}

std::unique_ptr<sim::zebro::Zebro> Chain::take_world() { return std::move(world_); }

sim::zebro::BodyState Chain::body() const { return world_->robot().body(); }

void Chain::forget() {
  bus_->wire.clear();
  acks.clear();
  events.clear();
}

}  // namespace lss::zebro
