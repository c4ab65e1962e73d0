// The solar panel of Lunar Zebro: its position and its movements in Idle. It counts as in only when
// its module knows its position, or has it at the Hall sensor, where it is retracted: a module that
// was reset counts from any position of the panel.

#include <algorithm>
#include <cmath>

#include "daemon/vehicles/zebro/vehicle.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"

namespace lss::zebro {
namespace {

constexpr double kTurn_rad = 360 * kDegree;
constexpr double kPanelIn_rad = 0.2;               // beyond this it is not retracted
constexpr double kSeekFurther_rad = 20 * kDegree;  // more than the whole way, to the sensor
constexpr double kLongestWay_rad = 350 * kDegree;  // maximum of one order
// Speed over the sensor, whose middle is at the mechanical stop: until the module's answer has led
// to an order, the panel presses 0.2 deg into the stop. At the speed of seeking it trips there.
constexpr double kCreep_rad_s = 1.5 * kDegree;
constexpr TimeNs kSwitchOn = kSecond;
// Minimum age of a status after the order to switch on: an earlier one may still show the state
// before it.
constexpr TimeNs kSettled = 100 * kMillisecond;
constexpr TimeNs kLastBit = kSecond;  // from where the sensor was passed

}  // namespace

bool Vehicle::panel_known() const noexcept {
  return (modules_[kPanel].status.flags & (kFlagCalibrated | kFlagHallSensor)) != 0;
}

bool Vehicle::panel_in() const noexcept {
  const Status& status = modules_[kPanel].status;
  if ((status.flags & kFlagCalibrated) == 0) return (status.flags & kFlagHallSensor) != 0;
  return std::abs(std::remainder(status.position_rad, kTurn_rad)) <= kPanelIn_rad;
}

void Vehicle::move_panel(bool deploy) noexcept {
  panel_ = {.step = Panel::Step::switching_on, .deploy = deploy, .due_ns = now_ns_ + kSwitchOn};
  order(kPanel, ModuleOrder::Kind::motion_on);
}

void Vehicle::stop_panel() noexcept {
  if (panel_.step == Panel::Step::rest) return;
  panel_.step = Panel::Step::rest;
  order(kPanel, ModuleOrder::Kind::motion_off);
}

// Backward until the module passes its sensor: from then on its position is the true one.
void Vehicle::seek_panel_sensor() noexcept {
  const double whole_rad = parameters_.panel_deployed_rad;
  const double way_rad = std::min(whole_rad + kSeekFurther_rad, kLongestWay_rad);
  panel_.step = Panel::Step::seeking;
  panel_.due_ns = now_ns_ + static_cast<TimeNs>(way_rad / whole_rad *
                                                static_cast<double>(parameters_.panel_move_ns));
  order_move(kPanel, modules_[kPanel].status.position_rad - way_rad, panel_.due_ns, false);
}

void Vehicle::creep_over_panel_sensor() noexcept {
  panel_.step = Panel::Step::creeping;
  panel_.due_ns = now_ns_ + static_cast<TimeNs>(kSeekFurther_rad / kCreep_rad_s * kSecond);
  order_move(kPanel, modules_[kPanel].status.position_rad - kSeekFurther_rad, panel_.due_ns, false);
}

void Vehicle::drive_panel() noexcept {
  const Status& status = modules_[kPanel].status;
  // At the sensor but not over it yet: this position counts as retracted.
  const double in_rad = (status.flags & kFlagCalibrated) != 0 ? 0 : status.position_rad;
  // The module went on in the same sense after it passed the sensor.
  const bool sought = panel_.step == Panel::Step::seeking || panel_.step == Panel::Step::creeping;
  const bool past = sought && std::remainder(status.position_rad, kTurn_rad) < 0;
  const bool last_bit = sought && !panel_.deploy;
  panel_.step = Panel::Step::moving;
  panel_.due_ns = now_ns_ + (last_bit ? kLastBit : parameters_.panel_move_ns);
  order_move(kPanel, in_rad + (panel_.deploy ? parameters_.panel_deployed_rad : 0), panel_.due_ns,
             panel_.deploy || past);
}

void Vehicle::watch_panel(Supervisor& s) noexcept {
  const Status& status = modules_[kPanel].status;
  if (panel_.step == Panel::Step::ended) {
    panel_.step = Panel::Step::rest;
    s.abandon(Reason::superseded);
    s.happen(event::panel_seen_out);
  }
  if (modules_[kPanel].status_ns == 0 || !in_service(kPanel)) return;
  const bool ended = now_ns_ >= panel_.due_ns && (status.flags & kFlagMoving) == 0;
  switch (panel_.step) {
    case Panel::Step::rest:
    case Panel::Step::ended:
      if (panel_in() || (s.controller().flags & kPanelOut) != 0) return;
      // It moves without an order: a panel that is out while legs move is an emergency.
      if (s.controller().state == State::operational) s.latch(FaultId::module_disobeys, kModules);
      s.happen(event::panel_seen_out);
      return;
    case Panel::Step::switching_on:
      if ((status.flags & kFlagMotionControl) == 0 ||
          modules_[kPanel].status_ns < panel_.due_ns - kSwitchOn + kSettled)
        break;
      panel_known() ? drive_panel() : seek_panel_sensor();
      break;
    case Panel::Step::seeking:
    case Panel::Step::creeping:
      if (panel_.step == Panel::Step::seeking && (status.flags & kFlagCalibrated) == 0 &&
          (status.flags & kFlagHallSensor) != 0) {
        creep_over_panel_sensor();
        break;
      }
      if ((status.flags & kFlagCalibrated) != 0 || (ended && panel_known())) drive_panel();
      break;
    case Panel::Step::moving:
      if (!ended || (!panel_.deploy && !panel_in())) break;
      panel_.step = Panel::Step::rest;
      order(kPanel, ModuleOrder::Kind::motion_off);
      s.happen(panel_.deploy ? event::panel_arrived_out : event::panel_arrived_in);
      return;
  }
  if (now_ns_ - panel_.due_ns > kMoveGrace) s.raise(faults::motion_timeout, number(kPanel));
}

}  // namespace lss::zebro
