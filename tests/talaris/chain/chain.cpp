#include "tests/talaris/chain/chain.h"

#include <algorithm>
#include <random>

namespace lss::talaris {

using testing_support::bus_work;
using testing_support::frame_work;

namespace {

std::unique_ptr<sim::talaris::Talaris> make(sim::talaris::TalarisOptions world, unsigned seed) {
  world.seed = seed;
  return std::make_unique<sim::talaris::Talaris>(world);
}

std::unique_ptr<SensorLine> imu_driver(const BusesParameters& p) {
  if (p.imu == ImuKind::crossbow) return std::make_unique<Crossbow>(p.crossbow);
  return std::make_unique<LandMark30>(p.landmark);
}

SensorFramesParameters grid_parameters(const config::Config& config, const BusesParameters& p) {
  const int packets =
      p.imu == ImuKind::crossbow ? p.crossbow.packets_per_frame : p.landmark.packets_per_frame;
  return {.packets = static_cast<std::uint32_t>(packets),
          .period_ns = config.period_ns,
          .grace_ns = p.grace_ns};
}

}  // namespace

Chain::Chain(const Options& options)
    : VirtualChain(logic(), *sim::make_talaris_kind(),
                   {.file = std::string(LSS_CAMPAIGNS) + "/" + options.config + ".toml",
                    .vehicle = "talaris",
                    .read = read_parameters,
                    // As in daemon/vehicles/talaris/wiring.cpp.
                    .complete =
                        [&](Parameters& parameters, const config::Config& config) {
                          parameters.offset_ns = config.offset_ns;
                          parameters.flight.offset_s = static_cast<double>(config.offset_ns) * 1e-9;
                          if (options.adjust) options.adjust(parameters);
                          parameters.buses = talaris::complete(parameters.buses, config);
                        },
                    .lease_ms = 60'000}),
      world_(make(options.world, options.seed)),
      wire_(std::make_unique<sim::CanBus>(sim::CanBus::Parameters{.seed = options.seed + 1},
                                          *world_)),
      late_share_(options.late_share),
      late_s_(options.late_s),
      lateness_(options.seed + 5),
      imu_(world_->lines()[0], imu_driver(parameters_.buses), options.seed + 2, kBegin),
      altimeter_(world_->lines()[1], std::make_unique<Ar1000>(parameters_.buses.altimeter),
                 options.seed + 3, kBegin),
      master_(parameters_.buses.can),
      valves_(parameters_.buses.valves),
      grid_(grid_parameters(config_, parameters_.buses), kBegin) {
  for (const sim::SerialLine& line : world_->lines()) {
    if (parameters_.buses.has_camera && line.name == "camera")
      camera_.emplace(line, std::make_unique<FlowCamera>(parameters_.buses.camera),
                      options.seed + 6, kBegin);
    if (parameters_.buses.has_standby && line.name == "standby_imu")
      standby_.emplace(line, std::make_unique<Crossbow>(parameters_.buses.standby),
                       options.seed + 7, kBegin);
    if (parameters_.buses.has_corners && line.name.starts_with("corner_"))
      corners_.push_back(std::make_unique<Line>(
          line, std::make_unique<Ar1000>(parameters_.buses.altimeter),
          options.seed + 8 + static_cast<unsigned>(corners_.size()), kBegin));
  }
  // The clocks of OBC and vehicle do not know of each other.
  std::mt19937 random(options.seed);
  step_ns_ += std::uniform_int_distribution<TimeNs>(0, sim::kStepNs - 1)(random);
  for (int ms = std::uniform_int_distribution(0, 199)(random); ms > 0; --ms) world_->step();
  master_.restart(now_ns_);
  master_twin_.seal(bytes_of(master_));
  valves_.reopened(now_ns_);
  valves_twin_.seal(bytes_of(valves_));
  grid_twin_.seal(bytes_of(grid_));
  deadline_ns_ = grid_.deadline();
  can_.open = can_.was_open = true;
  turn_can();
}

// As in daemon/vehicles/talaris/actuation.cpp.
void Chain::check_valves() {
  const auto lost = [this] { return valves_twin_.check(bytes_of(valves_)) == MemoryCheck::lost; };
  if (!protect_ || !bus_work(lost)) return;
  valves_.begin_again(parameters_.buses.valves, edges_.counters, edges_.open, now_ns_);
  bus_memory_lost_ = true;
}

TimeNs Chain::next_event() {
  check_valves();
  TimeNs corners_ns = kNever;
  for (const auto& corner : corners_) corners_ns = std::min(corners_ns, corner->next_wake());
  return std::min({step_ns_, imu_.next_wake(), altimeter_.next_wake(), wire_->next_wake(),
                   std::max(master_.next_wake(), now_ns_ + 1),
                   std::max(valves_.next_wake(), now_ns_ + 1), deadline_ns_, release_ns_,
                   heartbeat_ns_, camera_ ? camera_->next_wake() : kNever,
                   standby_ ? standby_->next_wake() : kNever, corners_ns});
}

void Chain::dispatch() {
  if (now_ns_ >= step_ns_) {
    world_->step();
    step_ns_ += sim::kStepNs;
    if (after_step) after_step();
  }
  beat_when_due();
  check_valves();  // after_step may have damaged them
  obey();
  if (now_ns_ >= release_ns_) {
    release();
  } else if (now_ns_ >= valves_.next_wake()) {
    send_edges(valves_.next_wake());
  }
  bus_work([this] { valves_twin_.seal(bytes_of(valves_)); });
  imu_.turn(now_ns_);
  altimeter_.turn(now_ns_);
  if (camera_) camera_->turn(now_ns_);
  if (standby_) standby_->turn(now_ns_);
  for (const auto& corner : corners_) corner->turn(now_ns_);
  turn_can();
  begin_frame();
}

bool Chain::run_until(const std::function<bool()>& condition, double limit_s) {
  const TimeNs end = now_ns_ + testing_support::to_ns(limit_s);
  for (std::uint64_t seen = frames(); now_ns_ < end;) {
    pass(std::min(end, next_event()));
    if (frames() == seen) continue;
    seen = frames();
    if (condition()) return true;
  }
  return false;
}
bool Chain::run_until(Phase phase, double limit_s) {
  return run_until([&] { return this->phase() == phase; }, limit_s);
}

// ---- the actuate thread, as daemon/vehicles/talaris/actuation.cpp

void Chain::release() {
  const TimeNs due_ns = release_ns_;
  release_ns_ = kNever;
  TalarisOrders due;
  if (!bus_work([&] { return take_due(due); })) return;
  if (!latch_.passes(due.all_stop, due.boundary_ns)) {
    ++edges_.refused_orders;
    return send_edges(now_ns_);
  }
  due.release_ns = due_ns;
  bus_work([&] { valves_.release(due, now_ns_); });
  send_edges(due_ns);
  turn_held(
      master_, master_twin_, [this] { forget(); },
      [&] { bus_work([&] { master_.release(due, now_ns_); }); });
  ordered_ = due;
  reset_serial_ = due.node_reset_serial;
}

// Actions without an order of the cycle.
void Chain::obey() {
  if (can_.port.restarts != restarts_) {
    restarts_ = can_.port.restarts;
    valves_.reopened(now_ns_);
  }
  if (!latch_.fell()) return;
  valves_.all_stop(now_ns_);
  send_edges(now_ns_);
  const TalarisOrders stop{.issued_ns = now_ns_,
                           .boundary_ns = now_ns_,
                           .release_ns = now_ns_,
                           .all_stop = true,
                           .node_reset_serial = reset_serial_};
  turn_held(
      master_, master_twin_, [this] { forget(); }, [&] { master_.release(stop, now_ns_); });
  ordered_ = stop;
}

void Chain::send_edges(TimeNs due_ns) {
  const std::uint8_t before = valves_.open();
  for (CanFrame frame; bus_work([&] { return valves_.due(now_ns_, frame); });) {
    send_can(*wire_, frame);
    bus_work([this] { valves_.sent(true, now_ns_); });
  }
  bus_work([&] { edges_.sent(before, valves_, due_ns, now_ns_); });
  edges_.all_stop_pending = latch_.pending();
}

// ---- the bus thread, as daemon/runtime/bus_thread.h and can_bus.h

void Chain::forget() {
  master_.begin_again(parameters_.buses.can, can_.status, ordered_, now_ns_);
  bus_memory_lost_ = true;
}

void Chain::turn_can() {
  turn_held(
      master_, master_twin_, [this] { forget(); },
      [this] {
        testing_support::turn_can(*wire_, master_, can_, samples_, now_ns_,
                                  [this](const CanFrame& frame) { send_can(*wire_, frame); });
      });
}

// ---- the frame thread, as daemon/runtime/frames.h and runtime.h

void Chain::begin_frame() {
  FrameTick tick;
  const bool ticked = imu_.take_tick(tick);
  if (!ticked && now_ns_ < deadline_ns_) return;
  bool begins = true;
  frame_work([&] {
    if (protect_ && grid_twin_.check(bytes_of(grid_)) == MemoryCheck::lost) {
      const SensorFramesParameters p = grid_parameters(config_, parameters_.buses);
      grid_ = SensorGrid(p, now_ns_ - p.period_ns - p.grace_ns, in_.frame);
      bus_memory_lost_ = true;
    }
    if (ticked) {
      begins = grid_.arrived(tick.index, tick.time_ns, boundary_);
    } else {
      grid_.held(now_ns_, boundary_);
    }
    grid_twin_.seal(bytes_of(grid_));
  });
  deadline_ns_ = grid_.deadline();
  if (begins) frame(boundary_);
}

void Chain::frame(const Boundary& boundary) {
  in_.frame = boundary.frame;
  in_.time_ns = boundary.time_ns;
  in_.held = boundary.held;
  in_.sample_count = 0;
  frame_work([this] {
    collect([&](TalarisSample& s) { return imu_.pop(s, in_.time_ns); });
    collect([&](TalarisSample& s) { return altimeter_.pop(s, in_.time_ns); });
    if (standby_) {
      collect([&](TalarisSample& s) {
        while (standby_->pop(s, in_.time_ns)) {
          if (of_standby(s)) return true;
        }
        return false;
      });
    }
    collect([&](TalarisSample& s) { return samples_.pop(s, in_.time_ns); });
    if (camera_) collect([&](TalarisSample& s) { return camera_->pop(s, in_.time_ns); });
    for (std::size_t i = 0; i < corners_.size(); ++i) {
      collect([&](TalarisSample& s) {
        if (!corners_[i]->pop(s, in_.time_ns)) return false;
        of_corner(s, static_cast<std::uint8_t>(i + 1));
        return true;
      });
    }
  });
  in_.bus = {.imu = imu_.report(),
             .altimeter = altimeter_.report(),
             .camera = camera_ ? camera_->report() : LineReport{},
             .standby = standby_ ? standby_->report() : LineReport{},
             .can = can_,
             .edges = edges_};
  run_cycle();
  release_ns_ = std::max(boundary.time_ns + config_.offset_ns, now_ns_);
  if (late_share_ > 0 && std::bernoulli_distribution(late_share_)(lateness_))
    release_ns_ += testing_support::to_ns(std::uniform_real_distribution(0.0, late_s_)(lateness_));
  if (after_frame) after_frame();
}

// ---- actions of an operator

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

void Chain::act(const sim::Fault& fault, bool attach) {
  const std::string_view kind = fault.kind->name;
  if (kind == "unplug" || kind == "line-unplug") refuse(kind);
  if (kind == "bus-off") {
    wire_->bus_off(now_ns_, attach ? testing_support::to_ns(fault.values.front()) : 0);
  } else if (kind.starts_with("line-")) {
    (fault.values.front() < 1.5 ? imu_ : altimeter_).faults().set(fault, attach);
  } else if (!wire_->faults.set(fault, attach)) {
    world_->set_fault(fault, attach);
  }
}

std::vector<Chain::Memory> Chain::memory() {
  std::vector<Memory> all = VirtualChain::memory();
  for (const Memory& more : {part("bus", master_, "master"), part("bus", can_, "report"),
                             part("bus", samples_, "queue"), part("bus", valves_, "valves"),
                             part("bus", latch_, "stop latch"), part("bus", edges_, "edges"),
                             part("bus", grid_, "grid"), part("bus", boundary_, "boundary")})
    all.push_back(more);
  if (protect_) {
    all.push_back(part("second copies", master_twin_));
    all.push_back(part("second copies", valves_twin_));
    all.push_back(part("second copies", grid_twin_));
  }
  return all;
}

std::vector<Chain::Memory> Chain::more_memory() {
  std::vector<Memory> all;
  const auto list = [&](Line& line, const std::string& name) {
    const std::span<std::uint8_t> driver = line.driver_memory();
    const auto at = static_cast<std::size_t>(reinterpret_cast<const std::uint8_t*>(&line.status()) -
                                             driver.data());
    all.push_back({"heap", driver.first(at), name});
    all.push_back({"heap", driver.subspan(at, sizeof(LineStatus)), name + " status"});
    all.push_back({"heap", driver.subspan(at + sizeof(LineStatus)), name});
    all.push_back({"sensor lines", line.queue(), name + " queue"});
    for (const auto& more : line.memory()) all.push_back({"sensor lines", more, name});
  };
  list(imu_, "imu");
  list(altimeter_, "altimeter");
  if (camera_) list(*camera_, "camera");
  if (standby_) list(*standby_, "standby");
  for (const auto& corner : corners_) list(*corner, "corner");
  return all;
}

// ---- true state

bool Chain::rests() const {
  return mode() != Mode::execute && body().velocity_m_s.norm() < 0.02 &&
         body().rate_B_rad_s.norm() < 0.05;
}

}  // namespace lss::talaris
