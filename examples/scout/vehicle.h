#pragma once

// The scout in the daemon: two velocity drives on one CAN bus, left and right of the body. Frame
// thread; time is data; no allocation.

#include <scout_fields.h>  // of the IDL

#include "daemon/kit/drive_vehicle.h"
#include "modes.h"

namespace lss::scout {

struct Parameters : kit::DriveParameters {
  Parameters() : DriveParameters(kit::drives({0x01, 0x02})) {}
  double wheel_radius_m = 0.10, track_m = 0.40, gear = 50;
  double speed_m_s = kMostSpeed_m_s, acceleration_m_s2 = 0.5;
};
Parameters read_parameters(config::Section& section);
const Tuning<Parameters>& tuning() noexcept;

class Vehicle final : public kit::DriveVehicle {
 public:
  using Telemetry = lss_ScoutTelemetry;

  explicit Vehicle(const Parameters& parameters) noexcept;

  void act(lc::ActionSet actions, const Request* request) noexcept override;
  Adjusted adjust(std::size_t index, double value, bool really) noexcept override;
  void navigate(TimeNs now) noexcept;
  void guide(TimeNs now) noexcept;
  Command control(TimeNs now) noexcept;
  bool describe(const Inputs<Vehicle>& in, const SupervisorState& state, Telemetry& out) noexcept;

  const TunableValues& tunables() const noexcept { return tunables_; }
  // For records: every member that the cycle changes.
  template <class V>
  void keep(V& v) {
    keep_base(v);
    v(parameters_, tunables_, wanted_m_s_, wanted_rad_s_, speed_m_s_, turn_rad_s_, measured_m_s_,
      measured_rad_s_, distance_m_, x_m_, y_m_, yaw_rad_, free_ns_);
  }

 private:
  void watch_own(Supervisor& supervisor) noexcept override;
  double dt_s() const noexcept;

  Parameters parameters_;
  TunableValues tunables_;
  double wanted_m_s_ = 0, wanted_rad_s_ = 0;  // commanded
  double speed_m_s_ = 0, turn_rad_s_ = 0;     // on the way to it
  double measured_m_s_ = 0, measured_rad_s_ = 0;
  std::array<TimeNs, kDrives> free_ns_{};  // when its wheel was not blocked last
  double distance_m_ = 0, x_m_ = 0, y_m_ = 0, yaw_rad_ = 0;
};

}  // namespace lss::scout
