// Supervision of Lunar Zebro: turns reports of the modules, the bus and the motions into events and
// faults of the locomotion controller. The panel: panel.cpp; error solving: solving.cpp.

#include <algorithm>
#include <bit>
#include <limits>
#include <utility>

#include "daemon/vehicles/zebro/tunables.h"
#include "daemon/vehicles/zebro/vehicle.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr TimeNs kNoiseWindow = kSecond;
constexpr std::uint64_t kNoisyFrames = 20;  // dropped in one window
constexpr double kHysteresis_degC = 5;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

bool rising(std::uint16_t now, std::uint16_t before, std::uint16_t flag) noexcept {
  return (now & flag) != 0 && (before & flag) == 0;
}

bool falling(std::uint16_t now, std::uint16_t before, std::uint16_t flag) noexcept {
  return rising(before, now, flag);
}

}  // namespace

void Vehicle::watch(const Inputs<Vehicle>& in, Supervisor& s) noexcept {
  supervisor_ = &s;
  isolated_ = s.controller().isolated;
  // First: a standstill of the machine makes replies old, so it is the cause.
  if (in.overrun_limit && s.controller().state == State::operational)
    s.raise(FaultId::frame_overrun);
  watch_bus(in.bus, s);
  watch_resets(s);
  watch_modules(s);
  for (std::size_t i = 0; i < kModules; ++i) {
    watch_temperature(i, s);
    watch_motor(i, in.bus.counters.module[i]);
    if (!in_service(i)) continue;
    watch_reports(i, s);
    watch_flags(i, s);
    watch_current(i, s);
    watch_obedience(i, in.bus.counters.module[i], s);
  }
  watch_current_sum(s);
  watch_motion(s);
  watch_ground(s);
  watch_panel(s);
  watch_solver(s);
  watch_rounds(s);
}

void Vehicle::watch_bus(const BusReport& bus, Supervisor& s) noexcept {
  if (bus.time_ns == 0) return;  // no report of the bus thread yet
  s.check_stop(bus.all_stop_pending);
  port_.watch(bus, bus.counters.safe_commands, 0, now_ns_, s);
  const BusCounters& c =
      bus.counters;  // a late reply is intact: the machine is slow, not the line noisy
  const std::uint64_t broken = c.bad_start + c.bad_length + c.bad_character + c.bad_check;
  if (now_ns_ - noise_window_ns_ >= kNoiseWindow) {
    const std::uint64_t dropped = broken - noise_frames_;
    if (dropped >= kNoisyFrames) s.raise(FaultId::bus_noise);
    if (dropped == 0) s.clear(FaultId::bus_noise);
    noise_window_ns_ = now_ns_;
    noise_frames_ = broken;
  }
}

void Vehicle::watch_resets(Supervisor& s) noexcept {
  resets_.watch(
      now_ns_, parameters_.reset_ns, port_.open(), [&](std::size_t i) { return resets_seen_[i]; },
      [&](std::size_t i) { return answers(i); }, s);
}

// Contact: no reply yet, answering, or silent. Isolated modules are ignored.
void Vehicle::watch_modules(Supervisor& s) noexcept {
  std::array<std::int64_t, kMaxModules> age_ms{};
  std::array<double, kMaxModules> sense{};
  for (std::size_t i = 0; i < kModules; ++i) {
    if (modules_[i].heard_ns != 0) age_ms[i] = (now_ns_ - modules_[i].heard_ns) / kMillisecond;
    sense[i] = answers(i) ? modules_[i].status.position_rad : kUnknown;
    const bool motor = i < kLegs && (modules_[i].status.flags & kFlagMotionControl) != 0;
    sense[kSenseMotorsOn] += motor && answers(i) ? 1 : 0;
    // A module stopped by its watchdog only lost contact, which is back: start clears it.
    const bool tripped =
        in_service(i) && (modules_[i].status.flags & kStopFlags & ~kFlagWatchdog) != 0;
    if (tripped && sense[kSenseTripped] == 0) sense[kSenseTripped] = number(i);
  }
  sense[kSenseTurnLimit] = parameters_.locomotion.swing_limit_rad_s;
  sense[kSenseLongestLease] = longest_lease_ms(parameters_);
  if (const unsigned legs = isolated_ & kAllLegs; !walks_without_[legs])
    sense[kSenseUnstable] = std::countr_zero(legs) + 1;
  s.set_ages(age_ms, parameters_.module_silent_ns / kMillisecond);
  s.set_sense(sense);
  for (std::size_t i = 0; i < kModules; ++i) {
    // Counts as answering after its first status: guards need it.
    if (modules_[i].status_ns == 0 || !in_service(i)) continue;
    const lc::ControllerState& c = s.controller();
    const bool lost = ((c.silent | c.unheard) >> i & 1u) != 0;
    if (answers(i) && lost) {
      s.happen(lc::Event::module_heard, number(i));
      s.note(events::module_online, number(i));
    } else if (!answers(i) && !lost && !resets_.away(i)) {
      s.happen(lc::Event::module_silent, number(i));
      kit::blame(FaultId::module_silent, i, s);
    }
  }
}

// What the armour found, once per change.
void Vehicle::watch_reports(std::size_t i, Supervisor& s) noexcept {
  if (i != kPanel)
    checks_[i].follow(sent_.module[i], modules_[i].status, modules_[i].status_ns, now_ns_);
  const ReportCheck::Finding finding = checks_[i].finding(now_ns_);
  if (std::exchange(found_[i], finding) == finding || finding == ReportCheck::Finding::none) return;
  s.note(events::report_refused, number(i), checks_[i].measured(), checks_[i].limit());
  kit::blame(fault_of(finding), i, s);
}

// Reports of a module's own flags, once per change that two statuses show.
void Vehicle::watch_flags(std::size_t i, Supervisor& s) noexcept {
  const auto reset_flag = modules_[i].reset ? kFlagReset : std::uint16_t{0};
  const auto flags = static_cast<std::uint16_t>((modules_[i].believed & ~kFlagReset) | reset_flag);
  const std::uint16_t before = flags_before_[i];
  if (modules_[i].status_ns == 0) return;
  const bool first = !std::exchange(modules_[i].greeted, true);  // every module was reset before
  // Which of a motor that is off, its reason and a reset came first shows when all of them last.
  constexpr std::uint16_t kTogether = kFlagMotionControl | kFlagCalibrated | kStopFlags;
  if (flags == before || ((flags ^ modules_[i].reported) & kTogether) != 0) return;
  flags_before_[i] = flags;
  // Whether its motor may be on: only then is a stop by itself a fault.
  const bool driven = i == kPanel ? (s.controller().flags & kPanelMoving) != 0
                                  : s.controller().state == State::operational;
  if (rising(flags, before, kFlagOverCurrent) && driven)
    s.raise(FaultId::module_over_current, number(i));
  if (rising(flags, before, kFlagWatchdog) && driven) s.raise(faults::module_watchdog, number(i));
  if (rising(flags, before, kFlagDriverFault)) kit::blame(faults::module_driver_fault, i, s);
  // Only a reset loses the calibration: the status with the reset flag may have been lost.
  const bool reset = rising(flags, before, kFlagReset) || falling(flags, before, kFlagCalibrated);
  if (reset && !first) {
    if (driven || s.controller().state == State::operational) {
      s.raise(FaultId::module_reset, number(i));
    } else {
      s.note(EventId::module_was_reset, number(i));
    }
  } else if (falling(flags, before, kFlagMotionControl) && i != kPanel && driven &&
             (flags & kStopFlags) == 0 && (s.controller().flags & kMotorsConfirmed) != 0) {
    s.raise(FaultId::module_disobeys, number(i));
  }
  if (rising(flags, before, kFlagCalibrated)) {
    s.note(events::module_calibrated, number(i));
    s.clear(faults::not_calibrated, number(i));
  }
}

void Vehicle::watch_current(std::size_t i, Supervisor& s) noexcept {
  Module& module = modules_[i];
  const lc::ControllerState& c = s.controller();
  const bool moves =
      c.state == State::operational || (i == kPanel && (c.flags & kPanelMoving) != 0);
  if (!moves || module.status.current_A <= parameters_.current_limit_A) {
    module.over_limit_ns = 0;
    return;
  }
  if (module.over_limit_ns == 0) module.over_limit_ns = now_ns_;
  if (now_ns_ - module.over_limit_ns >= parameters_.current_time_ns)
    s.raise(faults::current_limit, number(i));
}

// What the Power sub-system sees (Zebro thesis [P-Int-1]).
void Vehicle::watch_current_sum(Supervisor& s) noexcept {
  double sum_A = 0;
  for (std::size_t i = 0; i < kModules; ++i) sum_A += answers(i) ? modules_[i].status.current_A : 0;
  if (sum_A <= parameters_.total_limit_A) over_sum_ns_ = 0;
  if (sum_A <= parameters_.total_limit_A || s.controller().state != State::operational) return;
  if (over_sum_ns_ == 0) over_sum_ns_ = now_ns_;
  if (now_ns_ - over_sum_ns_ >= parameters_.current_time_ns) s.raise(faults::current_sum);
}

// Reported, not acted on (Zebro thesis [Prod-5]): by the module's own judgement or by ours.
void Vehicle::watch_temperature(std::size_t i, Supervisor& s) noexcept {
  Module& module = modules_[i];
  const double limit = parameters_.temperature_warning_degC;
  const bool says_hot = (module.status.flags & kFlagHot) != 0;
  if (!module.hot && (says_hot || module.health.temperature_degC > limit)) {
    module.hot = true;
    s.raise(FaultId::temperature_warning, number(i));
  } else if (module.hot && !says_hot && module.health.temperature_degC < limit - kHysteresis_degC) {
    module.hot = false;
    s.clear(FaultId::temperature_warning, number(i));
  }
}

// A motor that goes on in spite of its last order is sent an emergency stop, which the bus repeats
// until it is obeyed: the module may obey again at any time.
void Vehicle::watch_motor(std::size_t i, const ModuleLink& link) noexcept {
  const Kind last = orders_.module[i].kind;
  const bool motor = answers(i) && (modules_[i].status.flags & kFlagMotionControl) != 0;
  if (link.disobeys && motor && (last == Kind::motion_off || last == Kind::reset))
    order(i, Kind::emergency_stop);
}

void Vehicle::watch_obedience(std::size_t i, const ModuleLink& link, Supervisor& s) noexcept {
  if (link.disobeys && !disobeyed_[i]) kit::blame(FaultId::module_disobeys, i, s);
  disobeyed_[i] = link.disobeys;
  if (link.resends != resends_before_[i]) {
    resends_before_[i] = link.resends;
    s.note(events::module_resent, number(i), static_cast<double>(link.resends));
  }
}

void Vehicle::watch_motion(Supervisor& s) noexcept {
  const auto mode = static_cast<Mode>(s.controller().mode);
  if (mode == Mode::holding && (s.controller().flags & kMotorsConfirmed) == 0 &&
      motors_confirmed()) {
    s.happen(event::motors_confirmed);
  }
  if (bridge_.due_ns != 0) watch_bridge(s);
  if (!walking_legs_) return;
  const gnc::zebro::Progress progress = locomotion_.progress();
  if (progress == gnc::zebro::Progress::failed) {
    const gnc::zebro::LegSet late = locomotion_.late();
    if (late == 0) s.raise(faults::motion_timeout);
    for (std::size_t i = 0; i < kLegs; ++i) {
      if (contains(late, i)) s.raise(faults::motion_timeout, number(i));
    }
  } else if (in_motion_ && progress == gnc::zebro::Progress::done) {
    in_motion_ = false;
    if (mode == Mode::standing_up) report_uncalibrated(s);
    s.happen(event::motion_done);
  }
}

// On its belly, or a side of it, the vehicle gets on by rowing only. A warning stays until a stride
// shows that the side is clear.
void Vehicle::watch_ground(Supervisor& s) noexcept {
  constexpr std::array kWarnings = {FaultId::none, faults::left_in_soil, faults::right_in_soil,
                                    faults::belly_in_soil};
  unsigned deep = std::ranges::min(deep_strides_) >= kDeepStrides ? kBothSides : 0, clear = 0;
  for (std::size_t side = 0; side < deep_strides_.size(); ++side) {
    if (side_strides_[side] >= kSideStrides) deep |= 1u << side;
    if (deep_strides_[side] == 0) clear |= 1u << side;
  }
  if (const unsigned now = (in_soil_ | deep) & ~clear; now != in_soil_) {
    if (in_soil_ != 0) s.clear(kWarnings[in_soil_]);
    const std::array<double, 2>& shares = sinking_.shares();
    const double limit = (now == kBothSides ? 1 : kSideShare) * parameters_.soil_share;
    const double share = now == kBothSides ? std::ranges::min(shares) : shares[now / 2];
    if (now != 0) s.raise(kWarnings[now], 0, share, limit);
    in_soil_ = now;
  }
  const bool walks =
      locomotion_.motion() == gnc::zebro::Motion::walk && walk_.speed != gnc::zebro::Speed::zero;
  if (deep == 0 || !walks || walk_.rows) return;
  walk_.rows = true;
  locomotion_.walk(seconds(now_ns_), walk_);
}

// A leg moves by direct command. One out of service is no emergency when it fails.
void Vehicle::watch_bridge(Supervisor& s) noexcept {
  const Status& status = modules_[bridge_.leg].status;
  const bool out = !in_service(bridge_.leg), late = now_ns_ - bridge_.due_ns > kMoveGrace;
  if (out && (late || !answers(bridge_.leg) || (status.flags & kStopFlags) != 0 ||
              status.current_A > parameters_.current_limit_A)) {
    s.note(events::leg_switched_off, number(bridge_.leg));
    s.abandon(reasons::leg_blocked);
    end_bridge();
    s.happen(event::motion_done);
  } else if (bridge_.switching_on) {
    if ((status.flags & kFlagMotionControl) == 0) return;
    bridge_.switching_on = false;
    bridge_.due_ns = now_ns_ + bridge_.duration_ns;
    order_move(bridge_.leg, bridge_.position_rad, bridge_.due_ns, bridge_.forward);
  } else if (now_ns_ >= bridge_.due_ns && (status.flags & kFlagMoving) == 0) {
    end_bridge();
    s.happen(event::motion_done);
  } else if (late) {
    s.raise(faults::motion_timeout, number(bridge_.leg));
  }
}

// All legs report it in a status younger than the order.
bool Vehicle::motors_confirmed() const noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (in_service(i) && ((modules_[i].status.flags & kFlagMotionControl) == 0 ||
                          modules_[i].status_ns < motors_on_ns_))
      return false;
  }
  return true;
}

// Walking goes on with uncalibrated legs (Zebro thesis 5.2.3), but is reported.
void Vehicle::report_uncalibrated(Supervisor& s) noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    if (in_service(i) && (modules_[i].status.flags & kFlagCalibrated) == 0)
      s.raise(faults::not_calibrated, number(i));
  }
}

}  // namespace lss::zebro
