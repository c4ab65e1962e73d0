#include "daemon/vehicles/talaris/vehicle.h"

#include <algorithm>
#include <cmath>

#include "daemon/vehicles/talaris/tunables.h"

namespace lss::talaris {
namespace {

using gnc::talaris::NavState;

constexpr double kSilent_s = 0.4;  // an altimeter: three readings

// Share of the weight that the fans carry, above which it may slide on a slope.
constexpr double kLight = 0.5;

// From the frame in which both nodes are away: then they are lost. 300 ms of a cut bus, and the
// time in which they are configured again.
constexpr TimeNs kLongestCut = 700 * kMillisecond;
constexpr TimeNs kQuiet = 80 * kMillisecond;  // without its heartbeat, which comes every 50 ms

TimeNs nanoseconds(double s) noexcept { return std::llround(s * 1e9); }

// Rounding must not make a pulse longer than its frame.
ValvePulse pulse_of(const gnc::talaris::Pulse& pulse) noexcept {
  if (!(pulse.on_s > 0)) return {};
  const TimeNs delay_ns = nanoseconds(pulse.delay_s);
  return {delay_ns, std::min(nanoseconds(pulse.on_s), kFrame - delay_ns)};
}

}  // namespace

Vehicle::Vehicle(const Parameters& parameters) noexcept
    : parameters_(parameters),
      tunables_(values_of(tuning().tunables, parameters)),
      sensors_(parameters),
      navigation_(parameters.navigation),
      flight_(parameters.flight),
      hand_(parameters.flight.fans, parameters.flight.gains[0]),
      solver_(parameters.solver) {}

// ---- adjust: a parameter

Adjusted Vehicle::adjust(std::size_t index, double value, bool really) noexcept {
  return lss::adjust(tuning(), parameters_, tunables_, index, value, really, [&] {
    solver_.configure(parameters_.solver);
    sensors_.configure(parameters_);
    // The other parameters do not affect the flight and must not invalidate its plan.
    if (tuning().infos[index].change == Change::at_rest) {
      flight_.configure(parameters_.flight);
      hand_.set_gains(parameters_.flight.gains[flight_.gains() - 1]);
    }
  });
}

// ---- read

void Vehicle::read(const lss::Inputs<Vehicle>& in) noexcept {
  now_ns_ = in.time_ns;
  if (begun_ns_ == 0) begun_ns_ = now_ns_;
  data_requested_ = false;
  bus_ = in.bus;
  sensors_.begin(in.time_ns, !output_.airborne);
  for (std::uint32_t i = 0; i < in.sample_count; ++i) sensors_.take(in.samples[i]);
}

Mode Vehicle::mode() const noexcept { return static_cast<Mode>(supervisor_->controller().mode); }

bool Vehicle::answers(std::size_t node) const noexcept {
  return bus_.can.open && link(node).node.state == canopen::NodeState::operational;
}

bool Vehicle::flying() const noexcept { return flight_.active() && !output_.all_stop; }

// ---- navigate, guide, control

void Vehicle::navigate(TimeNs) noexcept {
  if (mode() == Mode::calibrate) {
    navigation_.calibrate(sensors_.batch());
  } else if (navigation_.aligned()) {
    using gnc::talaris::Phase;
    const bool spins_up = output_.phase == Phase::spin_up;
    const bool light =
        spins_up && output_.lift_m_s2 > kLight * gnc::talaris::kGravity_m_s2 && !output_.still;
    const bool waits = output_.phase == Phase::ready || spins_up;
    const bool standing =
        mode() == Mode::standby || (mode() == Mode::execute && (waits || output_.stands));
    gnc::talaris::Batch batch = sensors_.batch();
    if (altimeter_repeats()) batch.ranges = {};
    navigation_.step(batch, standing, light);
  }
}

void Vehicle::guide(TimeNs now) noexcept {
  gnc::talaris::FlightInputs in;
  in.time_ns = now;
  in.nav = navigation_.state();
  in.nav.valid = in.nav.valid && sensors_.imu_heard();
  in.imu_age_s = sensors_.imu_age_s();
  feel_ground(in);
  const gnc::talaris::RangeSample corners = range_by_corners();
  const bool by_corners = corners.time_ns != 0;
  in.range_m = by_corners ? corners.range_m : sensors_.range_m();
  in.range_age_s =
      by_corners ? static_cast<double>(age_of(corners.time_ns)) * 1e-9 : sensors_.range_age_s();
  // Both nodes at once: the bus is cut. They shut and slow down by themselves, and come back with
  // it.
  const bool valves = answers(kValveNode), fans = answers(kFanNode);
  const auto quiet = [&](std::size_t node) {
    return !answers(node) || age_of(link(node).node.heartbeat_ns) > kQuiet;
  };
  if (cut_ns_ == 0 && quiet(kValveNode) && quiet(kFanNode)) cut_ns_ = now;
  const gnc::talaris::Limits& limits = parameters_.flight.limits;
  const bool heard =
      sensors_.gas_age_s() <= limits.valve_age_s && sensors_.fan_age_s() <= limits.fan_age_s;
  if (valves && fans && heard) cut_ns_ = 0;
  in.unheard = cut_ns_ != 0 && now - cut_ns_ < kLongestCut;
  if (in.unheard) {
    in.valve_age_s = in.fan_age_s = 0;
  } else {
    if (valves) in.valve_age_s = sensors_.gas_age_s();
    if (fans) in.fan_age_s = sensors_.fan_age_s();
  }
  in.rpm = sensors_.rpm();
  in.tank_kPa = sensors_.tank_kPa();
  in.regulated_kPa = sensors_.regulated_kPa();
  if (overrun_) in.faults |= gnc::talaris::kOverruns;
  if (altimeter_repeats() && !(by_corners && in.range_age_s <= kSilent_s))
    in.faults |= gnc::talaris::kAltimeterLost;
  // Which of both is right nobody knows.
  if (sensors_.standby().disagrees() && output_.airborne && !disagreed_) flight_.land();
  disagreed_ = sensors_.standby().disagrees();
  if (gate_failed_ >= 2)
    in.faults |= gnc::talaris::kValvesLost;  // such orders mean: no valves, fans alone
  output_ = flight_.step(in);
}

// In the air each reading differs. On the ground a good altimeter may say the same for long.
bool Vehicle::altimeter_repeats() const noexcept {
  return output_.airborne && sensors_.range_repeats() >= parameters_.altimeter_repeats;
}

// That of the altimeter by those at the corners, when it repeats, says nothing or contradicts them.
// time_ns 0: it is right, or they say nothing either.
gnc::talaris::RangeSample Vehicle::range_by_corners() const noexcept {
  const gnc::talaris::RangeSample& corners = navigation_.range_by_corners();
  if (navigation_.range_doubted()) return corners;  // however old
  const double age = static_cast<double>(age_of(corners.time_ns)) * 1e-9;
  const bool silent = sensors_.range_age_s() > kSilent_s && sensors_.range_age_s() > age;
  const bool wrong = altimeter_repeats() || silent;
  return corners.time_ns != 0 && wrong && age <= kSilent_s ? corners : gnc::talaris::RangeSample{};
}

// Whether the IMU detects the ground; on the way down only, since valves and fans shake it.
void Vehicle::feel_ground(gnc::talaris::FlightInputs& in) noexcept {
  using gnc::talaris::Phase;
  if (!output_.airborne) return contact_.reset();
  contact_.step(sensors_.batch(), output_.lift_m_s2);
  const Phase phase = output_.phase;
  const bool down = phase == Phase::descend || phase == Phase::escape || phase == Phase::parachute;
  in.contact = down && contact_.supported();
  in.shock = down && contact_.shocked();
  in.jolt = down && contact_.jolted();
}

Vehicle::Command Vehicle::control(TimeNs now) noexcept {
  const lc::ControllerState& c = supervisor_->controller();
  const TalarisOrders before = orders_;
  orders_ = {};
  orders_.issued_ns = orders_.boundary_ns = now;
  orders_.release_ns = now + parameters_.offset_ns;
  orders_.node_reset_serial = before.node_reset_serial;
  orders_.reset_nodes = before.reset_nodes;
  orders_.enabled = enabled_;
  orders_.all_stop = c.state == State::fatal_error || c.state == State::solve_errors;
  // In the air a rebooted node must not be used.
  orders_.boot_allowed = !flying();
  const bool speeds = sensors_.fan_age_s() < parameters_.flight.limits.fan_age_s;
  const auto* rpm = speeds ? &sensors_.rpm() : nullptr;
  arming_ = false;
  if (c.state == State::operational) {
    if (mode() == Mode::script) {
      script_.advance(orders_, [&](const FanChange& change) {
        change.rpm ? hand_.rpm(change.fans, change.value)
                   : hand_.throttle(change.fans, change.value);
      });
    }
    if (mode() == Mode::manual || mode() == Mode::duty_cycle || mode() == Mode::script) {
      hand_.step(orders_, rpm);
      arming_ = hand_.arming();
      // One that would come too soon after another is left out.
      for (std::size_t i = 0; i < kHopperValves; ++i) {
        if (!pauses(orders_, sent_, i)) orders_.pulse[i] = {};
      }
    }
    if (mode() == Mode::execute) actuate_flight();
  }
  if (!arming_) {
    for (std::size_t i = 0; i < kHopperFans; ++i)
      orders_.fan_us[i] = static_cast<std::uint16_t>(
          std::min<int>(orders_.fan_us[i], sent_.fan_us[i] + fan_step_us()));
  }
  return orders_;
}

int Vehicle::fan_step_us() const noexcept {
  return static_cast<int>(parameters_.fan_slew_us_s * static_cast<double>(kFrame) * 1e-9);
}

void Vehicle::actuate_flight() noexcept {
  for (std::size_t i = 0; i < kHopperValves; ++i)
    orders_.pulse[i] = pulse_of(output_.actuation.valve[i]);
  for (std::size_t i = 0; i < kHopperFans; ++i)
    orders_.fan_us[i] = fan_us(output_.actuation.fan_throttle[i]);
}

// ---- gate

Vehicle::Command Vehicle::gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept {
  const GateLimits limits{.offset_ns = parameters_.offset_ns,
                          .enabled = enabled_,
                          .fan_step_us = fan_step_us(),
                          .arming = arming_};
  const GateCheck failed = check(wanted, sent_, supervisor.controller(), limits, now);
  const std::array<std::uint16_t, kHopperFans> fans_before = sent_.fan_us;
  sent_ = wanted;
  if (failed == GateCheck::passed) {
    gate_failed_ = 0;
  } else {
    supervisor.gate_closed(static_cast<double>(failed));  // in the air the flight goes on
    make_safe(sent_);
    if (supervisor.airborne()) {
      ++gate_failed_;
      sent_.fan_us = fans_before;
    }
    sent_.issued_ns = sent_.boundary_ns = now;
    sent_.release_ns = now + parameters_.offset_ns;
    sent_.all_stop = !supervisor.airborne();
  }
  count_gas();
  return sent_;
}

// The flight counts its own use.
void Vehicle::count_gas() noexcept {
  if (flight_.active()) return;
  std::array<double, kHopperValves> open_s{};
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    TimeNs open_ns = sent_.pulse[i].on_ns;
    if (sent_.hold[i].open)
      open_ns = std::clamp<TimeNs>(sent_.hold[i].until_ns - sent_.release_ns, 0, kFrame);
    if ((enabled_ & 1u << i) != 0) open_s[i] = static_cast<double>(open_ns) * 1e-9;
  }
  flight_.count_gas(open_s);
}

// ---- error solving

std::uint16_t Vehicle::faulty_modules() const noexcept {
  unsigned mask = 0;
  if (!answers(kValveNode)) mask |= 1u << (kValveModule - 1);
  if (!answers(kFanNode)) mask |= 1u << (kFanModule - 1);
  if (parameters_.buses.can.load_cell && !answers(kLoadCellNode))
    mask |= 1u << (kLoadCellModule - 1);
  return static_cast<std::uint16_t>(mask);
}

// Sensors have no reset: their state is cleared.
void Vehicle::reset_modules(std::uint16_t modules) noexcept {
  const unsigned nodes = modules >> (kValveModule - 1) & ((1u << kHopperNodes) - 1);
  if (nodes != 0) {
    const bool sent = orders_.node_reset_serial == sent_.node_reset_serial;
    orders_.reset_nodes = static_cast<std::uint8_t>(sent ? nodes : orders_.reset_nodes | nodes);
    ++orders_.node_reset_serial;
    if (supervisor_ != nullptr && nodes >> kFanNode & 1u) supervisor_->happen(event::fans_unarmed);
  }
  if (modules & 1u << (kImuModule - 1)) sensors_.forget_imu();
}

void Vehicle::realign() noexcept {
  navigation_.begin_calibration();
  sensors_.forget_imu();
}

}  // namespace lss::talaris
