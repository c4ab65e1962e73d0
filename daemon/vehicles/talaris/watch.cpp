// Supervision of TALARIS: turns reports of nodes, bus, sensors and supply into events and faults of
// the locomotion controller. Faults in the air are in watch_flight.cpp.

#include "daemon/cycle/solving.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "idl/talaris/codes.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kBoot = 5 * kSecond;  // a module that is silent until then is missing

std::uint16_t module_of(std::size_t node) noexcept {
  return static_cast<std::uint16_t>(node + kValveModule);
}

}  // namespace

void Vehicle::watch(const lss::Inputs<Vehicle>& in, Supervisor& s) noexcept {
  supervisor_ = &s;
  overrun_ = in.overrun_limit;
  if (overrun_ && s.controller().state == State::operational) s.raise(FaultId::frame_overrun);
  watch_bus(in.bus.can, s);
  s.check_stop(in.bus.edges.all_stop_pending);
  watch_resets(s);
  watch_nodes(s);
  watch_imu(s);
  watch_altimeter(s);
  watch_corners(s);
  watch_camera(s);
  watch_supply(s);
  watch_hand(s);
  watch_script(s);
  watch_calibration(s);
  watch_flight(s);
  watch_solver(s);
  tell_sense(s);
}

void Vehicle::tell_sense(Supervisor& s) const noexcept {
  std::array<double, kMaxModules> sense{};
  sense[kSenseActive] = active(sent_) ? 1 : 0;
  sense[kSensePulsing] = hand_.pulsing() ? 1 : 0;
  s.set_sense(sense);
}

// A warning that comes and goes.
void Vehicle::warn(bool wrong, bool& told, FaultId id, std::uint16_t subject,
                   Supervisor& s) noexcept {
  if (wrong == told) return;
  wrong ? s.latch(id, subject) : s.clear(id, subject);
  told = wrong;
}

void Vehicle::watch_bus(const HopperCan::Report& bus, Supervisor& s) noexcept {
  port_.watch(bus, bus.status.counters.safe_commands, bus.port.bus_offs, now_ns_, s, s.airborne());
  port_.watch_masters(bus.status.counters.master.other_masters, now_ns_, s);
}

// ---- nodes

// Of nodes only: the state of the IMU is cleared at once.
void Vehicle::watch_resets(Supervisor& s) noexcept {
  const auto node_of = [](std::size_t module) { return module - (kValveModule - 1); };
  resets_.watch(
      now_ns_, parameters_.reset_ns, bus_.can.open,
      [&](std::size_t module) { return link(node_of(module)).node.boots; },
      [&](std::size_t module) { return answers(node_of(module)); }, s);
}

void Vehicle::watch_nodes(Supervisor& s) noexcept {
  std::array<std::int64_t, kMaxModules> age_ms{};
  const auto age = [&](unsigned module, TimeNs heard_ns) {
    if (heard_ns != 0) age_ms[module - 1u] = age_of(heard_ns) / kMillisecond;
  };
  age(kImuModule, sensors_.imu_ns());
  age(kAltimeterModule, sensors_.altimeter_ns());
  for (std::size_t i = 0; i < kHopperNodes; ++i) age(module_of(i), link(i).node.heartbeat_ns);
  s.set_ages(age_ms, parameters_.buses.can.node_timeout_ns / kMillisecond);

  // Sensors are checked by their users.
  for (const int number : {kImuModule, kAltimeterModule}) {
    const auto module = static_cast<unsigned>(number);
    if ((s.controller().unheard & 1u << (module - 1)) != 0)
      s.happen(lc::Event::module_heard, module);
  }
  watch_node(kValveNode, s);
  watch_node(kFanNode, s);
  if (!parameters_.buses.can.load_cell) return;
  watch_link(kLoadCellNode, s);
  const bool expected = now_ns_ - begun_ns_ > kBoot && !resets_.away(kLoadCellModule - 1);
  warn(!answers(kLoadCellNode) && expected, load_cell_told_, faults::load_cell_lost,
       kLoadCellModule, s);
}

// The identity of a node, and its own reports.
void Vehicle::watch_link(std::size_t i, Supervisor& s) noexcept {
  const canopen::NodeStatus& node = link(i).node;
  const std::uint16_t module = module_of(i);
  const auto follow = [&](canopen::NodeState state, FaultId id) {
    if (node.state == state) s.latch(id, module);
    if (node.state == canopen::NodeState::operational) s.clear(id, module);
  };
  follow(canopen::NodeState::wrong_device, FaultId::node_wrong);
  follow(canopen::NodeState::failed, FaultId::node_refuses);
  follow(canopen::NodeState::babbling, FaultId::node_babbles);
  if (node.emcys != emcys_[i]) {
    emcys_[i] = node.emcys;
    s.note(EventId::emergency_message, module, node.emcy_code);
  }
}

void Vehicle::watch_node(std::size_t i, Supervisor& s) noexcept {
  watch_link(i, s);
  const std::uint16_t module = module_of(i);
  const canopen::NodeStatus& node = link(i).node;
  if (node.reboots != reboots_[i]) {
    reboots_[i] = node.reboots;
    if (i == kFanNode) s.happen(event::fans_unarmed);  // their pulses stopped
    if (s.controller().state == State::operational) {
      s.raise(FaultId::module_reset, module);
    } else {
      s.note(EventId::module_was_reset, module);
    }
  }
  const lc::ControllerState& c = s.controller();
  const bool expected = !resets_.away(module - 1u) && !flying();
  const unsigned bit = 1u << (module - 1);
  const bool unheard = (c.unheard & bit) != 0, silent = (c.silent & bit) != 0;
  if (answers(i) && (unheard || silent)) {
    s.happen(lc::Event::module_heard, module);
    s.note(EventId::node_configured, module);
  } else if (!answers(i) && !unheard && !silent && expected && bus_.can.open) {
    s.happen(lc::Event::module_silent, module);
    // During error solving the strategies check it themselves.
    if (c.state == State::solve_errors) {
      s.latch(FaultId::module_silent, module);
    } else {
      s.raise(FaultId::module_silent, module);
    }
  }
}

// ---- sensors

void Vehicle::watch_imu(Supervisor& s) noexcept {
  if (sensors_.scale_changed())
    s.note(events::imu_scale_changed, kImuModule, sensors_.scale_before(), sensors_.scale());
  if (sensors_.imu_lost_packets() != 0)
    s.note(events::imu_packets_lost, kImuModule, static_cast<double>(sensors_.imu_lost_packets()),
           static_cast<double>(sensors_.imu_lost_in_all()));
  const bool expected = sensors_.imu_known() || now_ns_ - begun_ns_ > kBoot;
  warn(sensors_.imu_silent() && expected, imu_silent_told_, faults::imu_silent, kImuModule, s);
  warn(sensors_.imu_stuck(), imu_stuck_told_, faults::imu_stuck, kImuModule, s);
  warn(sensors_.imu_lossy(), lossy_told_, faults::imu_lossy, kImuModule, s);
  warn(sensors_.imu_test_failed(), test_told_, faults::imu_test_failed, kImuModule, s);
  if (parameters_.buses.has_standby) {
    const bool heard = sensors_.standby().heard_ns() != 0;
    warn(sensors_.standby().silent() && (heard || now_ns_ - begun_ns_ > kBoot), standby_told_,
         faults::standby_imu_lost, 0, s);
    warn(sensors_.standby().disagrees(), disagree_told_, faults::imus_disagree, kImuModule, s);
  }
  const bool lost = sensors_.imu_lost();
  if (((s.controller().flags & kImuLost) != 0) == lost) return;
  s.happen(lost ? event::imu_lost : event::imu_good);
}

void Vehicle::watch_altimeter(Supervisor& s) noexcept {
  if (sensors_.range_errors() != 0)
    s.note(events::altimeter_error, kAltimeterModule, sensors_.range_error(),
           static_cast<double>(sensors_.range_errors_in_all()));
  const bool lost = parameters_.navigation.altimeter && sensors_.altimeter_lost();
  const bool expected = sensors_.altimeter_ns() != 0 || now_ns_ - begun_ns_ > kBoot;
  warn(lost && expected, altimeter_told_, faults::altimeter_lost, kAltimeterModule, s);
  const bool stuck = altimeter_repeats() || (altimeter_stuck_told_ && output_.airborne);
  warn(stuck, altimeter_stuck_told_, faults::altimeter_stuck, kAltimeterModule, s);
  if (((s.controller().flags & kAltimeterLost) != 0) == lost) return;
  s.happen(lost ? event::altimeter_lost : event::altimeter_good);
}

void Vehicle::watch_corners(Supervisor& s) noexcept {
  if (!parameters_.navigation.corners) return;
  warn(navigation_.range_doubted(), doubted_told_, faults::altimeter_off, kAltimeterModule, s);
  warn(navigation_.corners_uneven() && !output_.airborne, uneven_told_, faults::corners_uneven, 0,
       s);
  const bool expected = now_ns_ - begun_ns_ > kBoot;
  for (std::size_t i = 0; i < kCornerAltimeters; ++i)
    warn(expected && sensors_.corner_lost(i), corner_told_[i], faults::corner_altimeter_lost,
         static_cast<std::uint16_t>(kFirstCorner + i), s);
}

void Vehicle::watch_camera(Supervisor& s) noexcept {
  if (!parameters_.navigation.camera) return;
  const bool expected = sensors_.camera_ns() != 0 || now_ns_ - begun_ns_ > kBoot;
  const bool lost = (sensors_.camera_lost() && expected) || navigation_.camera_doubted();
  warn(lost, camera_told_, faults::camera_lost, 0, s);
}

void Vehicle::watch_supply(Supervisor& s) noexcept {
  constexpr double kHysteresis_V = 0.2;
  if (sensors_.gas_age_s() > 1) return;
  const bool watched = parameters_.min_voltage_V > 0;
  const double limit_V = parameters_.min_voltage_V + (supply_told_ ? kHysteresis_V : 0);
  warn(watched && sensors_.gas().voltage_V < limit_V, supply_told_, faults::supply_low,
       kValveModule, s);
}

// ---- by hand and by scripts

void Vehicle::watch_hand(Supervisor& s) noexcept {
  if (hand_.armed() && s.happen(event::fans_armed).reason == Reason::none)
    s.note(events::fans_armed, kFanModule);
  if (hand_.timed_out() != 0 && mode() == Mode::manual)
    s.note(events::valve_timed_out, kValveModule, hand_.timed_out());
}

void Vehicle::watch_script(Supervisor& s) noexcept {
  if (mode() != Mode::script || !script_.running()) return;
  if (script_.done() != script_told_) {
    script_told_ = script_.done();
    s.note(events::script_step_done, 0, script_.id(), script_.done(), script_.steps());
  }
  if (!script_.over()) return;
  s.note(events::script_ended, 0, script_.id());
  s.happen(event::script_ended);
}

// ---- error solving

void Vehicle::begin_solving(const Supervisor& s) noexcept {
  std::array<FaultClass, kMaxFaults + 1> wrong;
  std::size_t count = 0;
  each_fatal(s, [&](const FaultRecord& fault) { wrong[count++] = class_of(fault.id); });
  if (faulty_modules() != 0) wrong[count++] = FaultClass::contact;
  solver_.begin(std::span(wrong).first(count));
}

void Vehicle::watch_solver(Supervisor& s) noexcept {
  if (s.controller().state != State::solve_errors) return;
  constexpr unsigned kActuators = 1u << (kValveModule - 1) | 1u << (kFanModule - 1);
  const lc::ControllerState& c = s.controller();
  const bool healthy = bus_.can.open && !kit::PortWatch::stands_still(bus_.can, now_ns_) &&
                       (faulty_modules() & kActuators) == 0 && c.unheard == 0 && c.silent == 0 &&
                       !bus_.edges.all_stop_pending;
  const auto treat = [this] {
    if (solver_.kind() == StrategyKind::reset_node) reset_modules(faulty_modules());
    if (solver_.kind() == StrategyKind::realign) realign();
    return Treatment::done;
  };
  const auto step = [&] {
    return solver_.step(
        now_ns_, healthy, [this] { return parameters_.solver.budget_ns; }, treat);
  };
  solve_errors(
      s, solver_, [&] { begin_solving(s); }, step);
}

}  // namespace lss::talaris
