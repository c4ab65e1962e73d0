#include "tests/ardito/chain/chain.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>
#include <string_view>

#include "tools/lss-sim/frame/runner.h"

namespace lss::ardito {
namespace {

constexpr TimeNs kHeartbeatEvery = 200 * kMillisecond;
constexpr TimeNs kReportEvery = 5 * kMillisecond;  // as daemon/runtime/can_bus.h

const Logic& kLogic = logic();

config::Config read(Parameters& parameters, const Chain::Options& options) {
  auto config = config::load(LSS_CONFIG, {"ardito"}, [&](const std::string&, config::Section& s) {
    parameters = read_parameters(s);
  });
  if (!config) throw std::runtime_error(config.error());
  parameters.bus.period_ns = config->period_ns;
  if (options.adjust) options.adjust(parameters);
  return *config;
}

sim::ardito::RoverOptions seeded(sim::ardito::RoverOptions rover, unsigned seed) {
  rover.seed = seed;
  return rover;
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
    : config_(read(parameters_, options)),
      world_(std::make_unique<sim::ardito::Ardito>(seeded(options.rover, options.seed))),
      line_(std::make_unique<sim::CanBus>(
          sim::CanBus::Parameters{.paced = true, .seed = options.seed + 1}, *world_)),
      fault_kinds_(sim::fault_kinds_of(*sim::make_ardito_kind())),
      board_(std::make_unique<sim::FaultBoard>(
          [this](const sim::Fault& fault, bool attach) { act(fault, attach); },
          [this](const sim::Fault& fault) { return world_->in_force(fault); })),
      master_(parameters_.bus),
      vehicle_(parameters_),
      supervisor_(kLogic, {.obc_timeout_ns = config_.obc_timeout_ns}),
      port_(kLogic, static_cast<std::uint32_t>(config_.lease_min_ms),
            static_cast<std::uint32_t>(config_.lease_max_ms), [this] { all_stop(); }) {
  port_.show(supervisor_.state());
  // The clocks of OBC and nodes do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, sim::kStepNs - 1)(random);
  frame_ns_ = kBegin + 20 * kMillisecond;
  master_.restart(now_ns_);
  report_.open = report_.was_open = true;
  turn();
}

Chain::~Chain() = default;

// ---- time

TimeNs Chain::next_event() {
  const TimeNs bus_ns =
      daemon == Daemon::killed ? kNever : std::max(master_.next_wake(), now_ns_ + 1);
  return std::min({step_ns_, line_->next_wake(), bus_ns, frame_ns_, release_ns_, heartbeat_ns_});
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
    step_ns_ += sim::kStepNs;
  }
  if (now_ns_ >= heartbeat_ns_) {
    heartbeat_ns_ += kHeartbeatEvery;
    if (heartbeat_) post({.source = name("test")});
  }
  if (now_ns_ >= release_ns_) {
    release_ns_ = kNever;
    latch_.obey(master_, &out_.command, now_ns_);
  }
  turn();
  if (now_ns_ >= frame_ns_) frame();
}

// An emergency stop was taken: the bus thread wakes and obeys.
void Chain::all_stop() {
  latch_.ask(now_ns_);
  latch_.obey(master_, static_cast<const RoverOrders*>(nullptr), now_ns_);
  turn();
}

// One turn of the bus thread.
void Chain::turn() {
  line_->advance(now_ns_);
  for (CanFrame heard : line_->take(now_ns_)) {
    if (daemon == Daemon::killed) continue;
    heard.time_ns = now_ns_;
    ++report_.port.received;
    master_.receive({&heard, 1});
  }
  for (CanFrame sent; daemon != Daemon::killed && master_.transmit(now_ns_, sent);
       ++report_.port.sent)
    line_->from_master(sent, now_ns_);
  line_->advance(now_ns_);
  std::array<RoverSample, RoverBus::kMaxSamples> samples;
  const std::size_t count = master_.take(samples);
  for (std::size_t i = 0; i < count; ++i) samples_.push(samples[i]);
  if (now_ns_ - report_.time_ns < kReportEvery) return;
  report_.status = master_.status();
  report_.all_stop_pending = latch_.pending();
  report_.time_ns = now_ns_;
}

void Chain::frame() {
  if (daemon != Daemon::runs) {
    frame_ns_ += config_.period_ns;
    return;
  }
  in_.frame += 1;
  in_.time_ns = frame_ns_;
  in_.sample_count = 0;
  const auto before = [this](const RoverSample& s) { return s.time_ns < in_.time_ns; };
  while (in_.sample_count < in_.samples.size() &&
         samples_.pop_if(in_.samples[in_.sample_count], before))
    ++in_.sample_count;
  in_.bus = report_;
  in_.request_count = port_.take(in_.requests);
  cycle(vehicle_, supervisor_, in_, out_, [](Stage) {});
  if (tape) tape(in_, out_, supervisor_, vehicle_);
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

std::uint64_t Chain::send(std::uint16_t kind, std::span<const double> parameters) {
  Request request{
      .source = name("test"), .sequence = ++sequence_, .kind = kind, .lease_ms = lease_ms};
  std::ranges::copy(parameters, request.parameter.begin());
  post(request);
  return sequence_;
}

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

// ---- faults

void Chain::inject(const std::string& text) {
  const auto fault = sim::parse_fault(text, fault_kinds_);
  if (!fault) throw std::runtime_error(fault.error());
  board_->inject(*fault);
}

void Chain::act(const sim::Fault& fault, bool attach) {
  const std::string_view kind = fault.kind->name;
  if (kind == "unplug" || kind == "bus-off")
    throw std::runtime_error("the chain has no port: it knows no fault \"" + std::string(kind) +
                             "\"");
  if (!line_->faults.set(fault, attach)) world_->set_fault(fault, attach);
}

bool Chain::has(FaultId id, std::uint16_t subject) const {
  return std::ranges::any_of(supervisor().faults, [&](const FaultRecord& fault) {
    return fault.id == id && fault.subject == subject;
  });
}

}  // namespace lss::ardito
