#include "tests/zebro/chain/chain.h"

#include <algorithm>
#include <random>

#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {

Chain::Chain(const Options& options)
    : VirtualChain(logic(), *sim::make_zebro_kind(),
                   {.file = LSS_CONFIG,
                    .vehicle = "zebro",
                    .read = read_parameters,
                    .complete =
                        [&](Parameters& parameters, const config::Config& config) {
                          const config::Port& port = config.ports.front();
                          parameters.bus.baud = static_cast<int>(port.baud);
                          parameters.bus.half_duplex = port.half_duplex;
                          parameters.bus.period_ns = config.period_ns;
                          if (options.adjust) options.adjust(parameters);
                        },
                    .lease_ms = 2000}) {
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

  // The clocks of OBC and modules do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, world_->step_ns() - 1)(random);
  next_frame_ns_ = kBegin + 2 * kMillisecond;
  bus_->turn(now_ns_, {});
}

Chain::~Chain() = default;

// ---- time

TimeNs Chain::next_event() {
  const TimeNs line_ns = line_ ? line_->next_wake() : kNever;
  return std::min(
      {step_ns_, line_ns, bus_->next_wake(), plug_ns_, next_frame_ns_, release_ns_, heartbeat_ns_});
}

void Chain::dispatch() {
  if (now_ns_ >= step_ns_) {
    world_->step();
    step_ns_ += world_->step_ns();
  }
  if (now_ns_ >= plug_ns_) {
    plug_ns_ = kNever;
    bus_->plug(true, now_ns_);
  }
  beat_when_due();
  if (now_ns_ >= release_ns_) {
    release_ns_ = kNever;
    testing_support::bus_work([this] {
      if (BusOrders due; take_due(due)) bus_->release(due);
    });
    bus_->turn(now_ns_, {});
  }
  std::span<const std::uint8_t> bytes;
  if (line_) {
    line_->advance(now_ns_);
    bytes = line_->take(now_ns_);
  }
  const bool due = now_ns_ >= bus_->next_wake() || (frame_bus_ && now_ns_ >= next_frame_ns_);
  if (!bytes.empty() || due) bus_->turn(now_ns_, bytes);
  if (now_ns_ < next_frame_ns_) return;
  run_clock_frame(bus_->report(), [this](ModuleReply& r) { return bus_->pop(r, in_.time_ns); });
}

// ---- actions of an operator

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

void Chain::act(const sim::Fault& fault, bool attach) {
  if (fault.kind->name == std::string_view("unplug")) {
    plug_ns_ = attach ? now_ns_ + testing_support::to_ns(fault.values.front()) : now_ns_;
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

std::vector<Chain::Memory> Chain::memory() {
  std::vector<Memory> all = VirtualChain::memory();
  for (const auto& more : bus_->memory()) all.push_back({"bus", more});
  if (protect_) all.push_back({"second copies", bus_->second_copy()});
  return all;
}

void Chain::forget() {
  bus_->wire.clear();
  acks.clear();
  events.clear();
}

}  // namespace lss::zebro
