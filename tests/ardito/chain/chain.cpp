#include "tests/ardito/chain/chain.h"

#include <algorithm>
#include <random>

namespace lss::ardito {

using testing_support::bus_work;

namespace {

sim::ardito::RoverOptions seeded(sim::ardito::RoverOptions rover, unsigned seed) {
  rover.seed = seed;
  return rover;
}

}  // namespace

Chain::Chain(const Options& options)
    : VirtualChain(logic(), *sim::make_ardito_kind(),
                   {.file = LSS_CONFIG,
                    .vehicle = "ardito",
                    .read = read_parameters,
                    .complete =
                        [&](Parameters& parameters, const config::Config& config) {
                          parameters.bus.period_ns = config.period_ns;
                          if (options.adjust) options.adjust(parameters);
                        },
                    .lease_ms = 10'000}),
      world_(std::make_unique<sim::ardito::Ardito>(seeded(options.rover, options.seed))),
      line_(std::make_unique<sim::CanBus>(
          sim::CanBus::Parameters{.paced = true, .seed = options.seed + 1}, *world_)),
      master_(parameters_.bus) {
  // The clocks of OBC and nodes do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, sim::kStepNs - 1)(random);
  next_frame_ns_ = kBegin + 20 * kMillisecond;
  master_.restart(now_ns_);
  master_twin_.seal(bytes_of(master_));
  report_.open = report_.was_open = true;
  turn();
}

TimeNs Chain::next_event() {
  const TimeNs bus_ns =
      daemon == Daemon::killed ? kNever : std::max(master_.next_wake(), now_ns_ + 1);
  return std::min(
      {step_ns_, line_->next_wake(), bus_ns, next_frame_ns_, release_ns_, heartbeat_ns_});
}

void Chain::dispatch() {
  if (now_ns_ >= step_ns_) {
    world_->step();
    step_ns_ += sim::kStepNs;
  }
  beat_when_due();
  if (now_ns_ >= release_ns_) {
    release_ns_ = kNever;
    RoverOrders due;
    const bool whole = bus_work([&] { return take_due(due); });
    turn_held(
        master_, master_twin_, [this] { forget(); },
        [&] { bus_work([&] { latch_.obey(master_, whole ? &due : nullptr, now_ns_); }); });
  }
  turn();
  if (now_ns_ < next_frame_ns_) return;
  if (daemon != Daemon::runs) {
    next_frame_ns_ += config_.period_ns;
    return;
  }
  run_clock_frame(report_, [this](RoverSample& out) { return samples_.pop(out, in_.time_ns); });
}

std::vector<Chain::Memory> Chain::memory() {
  std::vector<Memory> all = VirtualChain::memory();
  for (const Memory& more : {part("bus", master_, "master"), part("bus", latch_, "stop latch"),
                             part("bus", report_, "report"), part("bus", samples_, "queue")})
    all.push_back(more);
  if (protect_) all.push_back(part("second copies", master_twin_));
  return all;
}

void Chain::forget() {
  master_.restart(now_ns_);
  latch_.ask(now_ns_);
}

// The bus thread wakes and obeys.
void Chain::all_stop() {
  latch_.ask(now_ns_);
  turn_held(
      master_, master_twin_, [this] { forget(); },
      [this] { latch_.obey(master_, static_cast<const RoverOrders*>(nullptr), now_ns_); });
  turn();
}

void Chain::turn() {
  if (daemon == Daemon::killed) {
    line_->advance(now_ns_);
    line_->take(now_ns_);  // nobody reads
    line_->advance(now_ns_);
    return;
  }
  const bool told = turn_held(
      master_, master_twin_, [this] { forget(); },
      [this] {
        bus_work(
            [this] { latch_.obey(master_, static_cast<const RoverOrders*>(nullptr), now_ns_); });
        return testing_support::turn_can(
            *line_, master_, report_, samples_, now_ns_,
            [this](const CanFrame& frame) { send_can(*line_, frame); });
      });
  if (told) {
    report_.all_stop_pending = latch_.pending();
  }
}

// ---- actions of an operator

bool Chain::start(SpeedLimit limit) {
  const auto contact = [this] {
    return supervisor().controller.unheard == 0 && supervisor().controller.silent == 0 &&
           frames() > 5;
  };
  if (!run_until(contact, 10)) return false;
  const std::uint64_t sequence = send(lss::CommandKind::start, {static_cast<double>(limit)});
  const auto completed = [&] {
    return std::ranges::any_of(acks, [&](const Ack& ack) {
      return ack.sequence == sequence && ack.phase == Phase::completed;
    });
  };
  return run_until(completed, 20) && mode() == Mode::stopped;
}

bool Chain::drive(double speed_m_s, double heading_rad, bool correction) {
  send(CommandKind::drive, {speed_m_s, heading_rad, correction ? 1.0 : 0.0, 0.0});
  return run_until(Mode::running, 20);
}

void Chain::act(const sim::Fault& fault, bool attach) {
  const std::string_view kind = fault.kind->name;
  if (kind == "unplug" || kind == "bus-off") refuse(kind);
  if (!line_->faults.set(fault, attach)) world_->set_fault(fault, attach);
}

}  // namespace lss::ardito
