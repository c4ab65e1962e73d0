#include "daemon/vehicles/zebro/vehicle.h"

#include <algorithm>
#include <limits>

#include "daemon/kit/gate.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

using Kind = ModuleOrder::Kind;

constexpr double kGateMargin = 1.1;  // above the gait's own swing limit

// Of the arguments of walk or start.
gnc::zebro::WalkRequest walk_request(const auto& walk) noexcept {
  return {.direction = walk.forward ? 1.0 : -1.0,
          .heading_rad = walk.heading_rad,
          .speed = static_cast<gnc::zebro::Speed>(walk.speed)};
}

// Noise whose check fits changes one status alone. Flag 7 is in one alone, too: the other one shows
// the reset by a motor that is off, and by no calibration, unless it restarted at its sensor.
void believe(Module& module, std::uint16_t flags) noexcept {
  const auto both = static_cast<std::uint16_t>(flags & module.reported);
  const auto any = static_cast<std::uint16_t>(flags | module.reported);
  module.believed = static_cast<std::uint16_t>((module.believed & any) | both);
  const bool calibrated = (any & kFlagCalibrated) != 0 && (any & kFlagHallSensor) == 0;
  const bool reset = (any & kFlagReset) != 0 && (any & kFlagMotionControl) == 0 && !calibrated;
  module.reset |= reset;
  module.reported = reset ? static_cast<std::uint16_t>(flags & ~kFlagReset) : flags;  // shown once
}

}  // namespace

Vehicle::Vehicle(const Parameters& parameters) noexcept
    : parameters_(parameters),
      tunables_(values_of(tuning().tunables, parameters)),
      locomotion_(parameters.locomotion),
      solver_(parameters.solver),
      sinking_(gnc::zebro::lowered_rad(parameters.locomotion.belly_height_m,
                                       parameters.locomotion.leg_diameter_m)) {
  order_all(Kind::motion_off);
  for (std::size_t i = 0; i < walks_without_.size(); ++i)
    walks_without_[i] =
        gnc::zebro::can_walk_without(static_cast<gnc::zebro::LegSet>(i), parameters.locomotion);
}

// ---- read

void Vehicle::read(const Inputs<Vehicle>& in) noexcept {
  now_ns_ = in.time_ns;
  if (epoch_ns_ == 0) epoch_ns_ = in.time_ns;
  data_requested_ = false;
  for (std::size_t i = 0; i < kModules; ++i) resets_seen_[i] = in.bus.counters.module[i].resets;
  for (Module& module : modules_) module.reset = false;
  for (std::uint32_t i = 0; i < in.sample_count; ++i) {
    if (in.samples[i].module < kModules) take(in.samples[i]);
  }
}

// As much of a report as the armour lets through.
void Vehicle::take(const ModuleReply& reply) noexcept {
  Module& module = modules_[reply.module];
  ReportCheck& check = checks_[reply.module];
  switch (static_cast<Code>(reply.code)) {
    case Code::status: {
      const Status before = module.status, status = decode_status(reply.data);
      const auto use = check.take(status, reply.time_ns, reply.module != kPanel);
      if (use == ReportCheck::Use::nothing) return;
      module.status = status;
      if (use == ReportCheck::Use::flags) {
        module.status.position_rad = before.position_rad;
        module.status.velocity_rad_s = before.velocity_rad_s;
      }
      believe(module, status.flags);
      module.status_ns = reply.time_ns;
      break;
    }
    case Code::health: {
      const Health health = decode_health(reply.data);
      if (check.take(health, reply.time_ns) == ReportCheck::Use::nothing) return;
      module.health = health;
      break;
    }
    case Code::identity:
      module.identity = decode_identity(reply.data);
      lateness_[reply.module].heard(reply.time_ns, module.identity.uptime_s);
      break;
    default: break;
  }
  module.heard_ns = reply.time_ns;
}

bool Vehicle::answers(std::size_t module) const noexcept {
  return modules_[module].heard_ns != 0 &&
         now_ns_ - modules_[module].heard_ns <= parameters_.module_silent_ns;
}

// ---- adjust: a parameter

Adjusted Vehicle::adjust(std::size_t index, double value, bool really) noexcept {
  return lss::adjust(tuning(), parameters_, tunables_, index, value, really, [&] {
    solver_.configure(parameters_.solver);
    locomotion_.configure(parameters_.locomotion);  // none of them changes while it moves
  });
}

// ---- act: actions of the locomotion controller, at once

void Vehicle::order(std::size_t module, Kind kind) noexcept {
  ModuleOrder& order = orders_.module[module];
  order = {.kind = kind, .position_cdeg = 0, .arrive_ns = 0, .serial = order.serial + 1};
}

void Vehicle::order_all(Kind kind) noexcept {
  for (std::size_t i = 0; i < kModules; ++i) order(i, kind);
}

void Vehicle::order_move(std::size_t module, double position_rad, TimeNs arrive_ns,
                         bool forward) noexcept {
  order(module, forward ? Kind::rotate_forward : Kind::rotate_backward);
  orders_.module[module].position_cdeg = position_cdeg(position_rad);
  orders_.module[module].arrive_ns = arrive_ns;
}

void Vehicle::act(lc::ActionSet actions, const Request* request) noexcept {
  if (actions & (lc::kEmergencyStop | lc::kMotorsOff)) {
    if (actions & lc::kEmergencyStop) {
      make_safe(orders_, now_ns_);
    } else {
      order_all(Kind::motion_off);
    }
    locomotion_.hold(seconds(now_ns_));
    walking_legs_ = in_motion_ = false;
    bridge_ = {};
    panel_.step = Panel::Step::rest;
  }
  if (actions & lc::kEndSolve) solver_.end();
  if (request != nullptr && event_of(*request) == lc::Event::reset_controller) rounds_.forget();
  // A request that follows in the same frame is judged by it.
  if ((actions & lc::kIsolate) && request != nullptr)
    isolated_ = static_cast<std::uint16_t>(isolated_ | 1u << (arguments<OneLeg>(*request).leg - 1));
  if (actions & lc::kRestore) restore(request);
  if (actions & lc::kResetModule) reset_modules(*request);
  if (actions & lc::kPublishData) data_requested_ = true;
  if (actions & kPanelDeploy) move_panel(true);
  if (actions & kPanelRetract) move_panel(false);
  if (actions & kPanelStop) stop_panel();
  begin_motion(actions, request);
}

// Their reports are evaluated again.
void Vehicle::restore(const Request* request) noexcept {
  const bool one = request != nullptr && request->kind == kind_of(CommandKind::restore_leg);
  const unsigned module = one ? arguments<OneLeg>(*request).leg : 0;
  const unsigned these = module != 0 ? isolated_ & 1u << (module - 1) : isolated_;
  for (std::size_t i = 0; i < kModules; ++i) {
    if ((these >> i & 1u) == 0) continue;
    flags_before_[i] = 0;
    disobeyed_[i] = false;
    checks_[i] = {};
  }
  isolated_ = static_cast<std::uint16_t>(isolated_ & ~these);
}

Verdict Vehicle::consider(const Request& request) noexcept {
  // What was out of service stays so, with any configuration; then nothing starts.
  const bool saved = (request.flags & kFlagSaved) != 0;
  if (request.kind != kind_of(CommandKind::isolate) || saved) return {};
  const unsigned leg = arguments<OneLeg>(request).leg;
  const unsigned all = (isolated_ | 1u << (leg - 1)) & kAllLegs;
  if (walks_without_[all]) return {};
  return {.reason = reasons::not_stable, .subject = static_cast<std::uint16_t>(leg)};
}

void Vehicle::begin_motion(lc::ActionSet actions, const Request* request) noexcept {
  const double now_s = seconds(now_ns_);
  if (actions & kMotorsOn) {
    // The last order of a module, for example a reset, does not apply in Operational.
    for (std::size_t i = 0; i < kModules; ++i)
      order(i, i < kLegs && in_service(i) ? Kind::motion_on : Kind::motion_off);
    motors_on_ns_ = now_ns_;
    locomotion_.isolate(static_cast<gnc::zebro::LegSet>(isolated_ & kAllLegs));
    locomotion_.reset_odometry();
    walk_ = walk_request(arguments<Start>(*request));  // used when the follow-up is to walk
  }
  if (actions & kMoveLeg) move_leg(*request);
  if ((actions & (kStandUp | kWalk | kFinishStep | kLayDown | kStow)) == 0) return;

  end_bridge();
  walking_legs_ = true;
  in_motion_ = (actions & kWalk) == 0;
  if (actions & kStandUp) locomotion_.stand_up(now_s);
  if (actions & kFinishStep) locomotion_.finish_step(now_s);
  if (actions & kLayDown) locomotion_.lay_down(now_s);
  if (actions & kStow) locomotion_.stow(now_s);
  if (actions & kWalk) begin_walk(request);
}

// Strides in the soil count over short walks. After such a walk the next one from standing steps
// again, and one stride more in the soil is enough. Without a leg nothing is felt.
void Vehicle::begin_walk(const Request* request) noexcept {
  const bool goes_on = locomotion_.motion() == gnc::zebro::Motion::walk;
  const bool rows = goes_on && walk_.rows;
  if (request != nullptr) walk_ = walk_request(arguments<Walk>(*request));
  walk_.rows = rows;
  if (!goes_on && in_soil_ != 0) {
    sinking_.reset();
    const bool feels = feels_soil();
    for (int& strides : deep_strides_) strides = feels ? std::min(strides, kDeepStrides - 1) : 0;
    for (int& strides : side_strides_) strides = feels ? std::min(strides, kSideStrides - 1) : 0;
  }
  locomotion_.walk(seconds(now_ns_), walk_);
}

void Vehicle::move_leg(const Request& request) noexcept {
  const auto move = arguments<MoveLeg>(request);
  const std::size_t leg = move.leg - 1;
  walking_legs_ = in_motion_ = false;
  locomotion_.hold(seconds(now_ns_));
  end_bridge();
  const auto duration_ns = static_cast<TimeNs>(move.duration_s * 1e9);
  bridge_ = {.leg = leg,
             .due_ns = now_ns_ + duration_ns,
             .switching_on = !in_service(leg),
             .position_rad = move.position_rad,
             .duration_ns = duration_ns,
             .forward = move.forward};
  if (bridge_.switching_on) {
    order(leg, Kind::motion_on);
  } else {
    order_move(leg, bridge_.position_rad, bridge_.due_ns, bridge_.forward);
  }
}

void Vehicle::end_bridge() noexcept {
  const ModuleOrder::Kind last = orders_.module[bridge_.leg].kind;
  if (!in_service(bridge_.leg) && last != Kind::motion_off && last != Kind::emergency_stop)
    order(bridge_.leg, Kind::motion_off);
  bridge_ = {};
}

void Vehicle::reset_modules(const Request& request) noexcept {
  const auto number = static_cast<std::size_t>(arguments<Reset>(request).module);
  for (std::size_t i = 0; i < kModules; ++i) {
    if (number != 0 && number != i + 1) continue;
    order(i, Kind::reset);
    resets_.begin(i, now_ns_, resets_seen_[i]);
    if (i == kPanel && panel_.step != Panel::Step::rest) panel_.step = Panel::Step::ended;
  }
}

// ---- navigate, guide, control

void Vehicle::navigate(TimeNs) noexcept {
  for (std::size_t i = 0; i < kLegs; ++i) {
    const Status& status = modules_[i].status;
    measured_[i] = {.angle_rad = -status.position_rad,
                    .known = in_service(i) && answers(i) && modules_[i].status_ns != 0,
                    .calibrated = (status.flags & kFlagCalibrated) != 0};
  }
}

void Vehicle::guide(TimeNs now) noexcept {
  if (!walking_legs_) return;
  locomotion_.update(seconds(now), measured_);
  feel_ground();
}

void Vehicle::feel_ground() noexcept {
  gnc::zebro::PerLeg<gnc::zebro::Sinking::Leg> legs;
  for (std::size_t i = 0; i < kLegs; ++i) {
    legs[i] = {.theta_rad = measured_[i].angle_rad,
               .current_A = modules_[i].status.current_A,
               .known = measured_[i].known && measured_[i].calibrated,
               .flies = locomotion_.targets()[i].swing};
  }
  if (!sinking_.update(legs)) return;
  for (std::size_t side = 0; side < deep_strides_.size(); ++side) {
    const double share = sinking_.shares()[side];
    const auto counted = [share](int strides, double limit, int enough) {
      return share > limit ? std::min(strides + 1, enough) : 0;
    };
    deep_strides_[side] = counted(deep_strides_[side], parameters_.soil_share, kDeepStrides);
    side_strides_[side] =
        counted(side_strides_[side], kSideShare * parameters_.soil_share, kSideStrides);
  }
}

Vehicle::Command Vehicle::control(TimeNs now) noexcept {
  if (walking_legs_) {
    for (std::size_t i = 0; i < kLegs; ++i) {
      const gnc::zebro::LegTarget& target = locomotion_.targets()[i];
      if (target.segment == segment_[i] || target.rotation == 0) continue;
      segment_[i] = target.segment;
      order_move(i, -target.angle_rad, nanoseconds(target.arrive_s), target.rotation > 0);
    }
  }
  orders_.issued_ns = now;
  return orders_;
}

// ---- gate

Vehicle::Command Vehicle::gate(const Command& wanted, Supervisor& supervisor, TimeNs now) noexcept {
  std::array<std::int32_t, kModules> measured_cdeg;
  for (std::size_t i = 0; i < kModules; ++i) {
    measured_cdeg[i] = answers(i) ? position_cdeg(modules_[i].status.position_rad) : -1;
  }
  const GateLimits limits{parameters_.locomotion.swing_limit_rad_s / kDegree * kGateMargin};
  const GateCheck failed =
      check(wanted, sent_, measured_cdeg, supervisor.controller(), limits, now);
  return kit::pass_gate(failed, wanted, orders_, sent_, supervisor,
                        [&] { make_safe(orders_, now); });
}

// ---- telemetry

bool Vehicle::describe(const Inputs<Vehicle>& in, const SupervisorState& state,
                       Telemetry& out) noexcept {
  out.time_ns = in.time_ns;
  out.frame = in.frame;
  out.state = static_cast<std::uint8_t>(state.controller.state);
  out.mode = state.controller.mode;
  const bool walking = static_cast<Mode>(out.mode) == Mode::walking;
  out.speed = walking ? static_cast<std::uint8_t>(walk_.speed) : std::uint8_t{0};
  out.heading_rad = walking ? walk_.heading_rad : 0;
  out.direction = walk_.direction;
  out.distance_m = locomotion_.distance_m();
  out.yaw_rad = locomotion_.yaw_rad();
  out.speed_m_s = walking_legs_ ? locomotion_.speed_m_s() : 0;
  out.steps = locomotion_.steps();
  out.rows = walking && locomotion_.rows();
  static_assert(std::extent_v<decltype(out.soil_share)> == 2);
  for (std::size_t side = 0; side < 2; ++side) {
    const double share = sinking_.shares()[side];
    out.soil_share[side] =
        feels_soil() && share >= 0 ? share : std::numeric_limits<double>::quiet_NaN();
  }
  static_assert(std::extent_v<decltype(out.modules)> == kModules);
  for (std::size_t i = 0; i < kModules; ++i)
    describe_module(i, in.bus.counters.module[i], out.modules[i]);
  const BusCounters& bus = in.bus.counters;
  out.bus_frames_sent = bus.frames_sent;
  out.bus_frames_received = bus.frames_received;
  out.bus_frames_dropped = bus.frames_dropped;
  out.bus_overflows = bus.overflows;
  out.bus_cycle_ns = static_cast<std::uint64_t>(bus.cycle_ns);
  out.port_open = in.bus.open;
  return data_requested_;
}

void Vehicle::describe_module(std::size_t i, const ModuleLink& link,
                              lss_ZebroModule& out) const noexcept {
  const Module& module = modules_[i];
  out.id = static_cast<std::uint8_t>(i + 1);
  out.address = parameters_.bus.address[i];
  out.online = answers(i);
  out.isolated = !in_service(i);
  out.flags = module.status.flags;
  out.calibrated = (module.status.flags & kFlagCalibrated) != 0;
  out.motion_control = (module.status.flags & kFlagMotionControl) != 0;
  out.moving = (module.status.flags & kFlagMoving) != 0;
  out.swing = i < kLegs && walking_legs_ && locomotion_.targets()[i].swing;
  out.position_rad = module.status.position_rad;
  out.velocity_rad_s = module.status.velocity_rad_s;
  out.set_point_rad = module.health.set_point_rad;
  out.time_left_s = module.health.time_left_s;
  out.current_A = module.status.current_A;
  out.temperature_degC = module.health.temperature_degC;
  out.supply_V = module.health.supply_V;
  out.uptime_s = module.identity.uptime_s;
  out.firmware_major = module.identity.firmware_major;
  out.firmware_minor = module.identity.firmware_minor;
  out.reset_cause = module.identity.reset_cause;
  out.dropped_frames = module.identity.dropped_frames;
  out.age_ms = module.heard_ns == 0
                   ? kNeverHeard_ms
                   : static_cast<std::uint64_t>(
                         (std::max<TimeNs>(now_ns_ - module.heard_ns, 0) + lateness_[i].late_ns()) /
                         kMillisecond);
  out.replies = link.replies;
  out.resends = link.resends;
}

}  // namespace lss::zebro
