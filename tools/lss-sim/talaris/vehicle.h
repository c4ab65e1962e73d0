#pragma once

// TALARIS as its Locomotion Controller sees it: IMUs, altimeters and a camera on serial lines,
// valves, fans and on test stands a load cell as nodes on a CAN bus, and the vehicle behind them.
// The entry for lss-sim's roster, and the vehicle itself for tests that step it without threads:
//
//   Talaris world({.plant = {.stand = Stand::sled, .heading_rad = 0.8}, .seed = 7});
//   sim::CanBus bus({.seed = 7}, world);               // its devices: world
//   sim::Uart imu({.baud = 115'200, .bits = 12}, world.imu());
//   world.step();                                      // a millisecond
//
// Frames as in plant.h.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "tools/lss-sim/canopen/node_bus.h"
#include "tools/lss-sim/frame/vehicle.h"
#include "tools/lss-sim/talaris/air.h"
#include "tools/lss-sim/talaris/altimeter.h"
#include "tools/lss-sim/talaris/fans.h"
#include "tools/lss-sim/talaris/flow_camera.h"
#include "tools/lss-sim/talaris/gas.h"
#include "tools/lss-sim/talaris/imu.h"
#include "tools/lss-sim/talaris/nodes.h"
#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim {

std::unique_ptr<VehicleKind> make_talaris_kind();

namespace talaris {

enum class Pointing : std::uint8_t { down, sideways };  // along -x, along +z

struct TalarisOptions {
  PlantOptions plant{};
  GasOptions gas{};
  FanOptions fans{};
  ImuOptions imu{};
  bool standby_imu = false;  // a second one, a Crossbow with the errors of the first one's options
  AltimeterOptions altimeter{};
  // Four more at the corners, with biases of their own up to that of the first: +y +z, +y -z,
  // -y -z, -y +z from the IMU.
  bool corner_altimeters = false;
  double corner_y_m = 0.38, corner_z_m = 0.495;
  FlowCameraOptions camera{};
  AirOptions air{};
  std::optional<Pointing> pointing{};        // unset: sideways on rail and sled, otherwise down
  Vector3 altimeter_at_m = Vector3::Zero();  // as [talaris.altimeter]; the camera is there, too
  std::optional<bool> load_cell{};           // unset: only on the stand for it
  unsigned seed = 1;                         // of noise and biases
};

// Ranges from which a vehicle is drawn: shares and values either way, evenly, unless it says
// "sigma" (normal).
struct Spread {
  // manufacture
  double mass = 0.02, inertia = 0.3;
  double cg_x_m = 0.010, cg_m = 0.0015;  // in height; sideways
  double valve_thrust = 0.03, fan_thrust = 0.01, fan_lag = 0.2, valve_lag_ms = 2;
  double friction = 0.5, heading_rad = 3 * kDegree;  // of stands
  // and of a day in the field; the heading, wind, gusts and uphill direction are any
  double tank_fill = 0;  // less than full
  double droop = 0, fade = 0, fan_torque_m = 0, fan_torque = 0, rotor_kg_m2 = 0;
  double imu_scale_sigma = 0, imu_misaligned_sigma_rad = 0, imu_skewed_sigma_rad = 0;
  double vibration_m_s2 = 0, vibration_rad_s = 0;
  double altimeter_bias_m = 0, altimeter_latency_s = 0;
  double camera_scale_sigma = 0;
  double slope_rad = 0, density_kg_m3 = 0, wind_m_s = 0, gust_m_s = 0;
};
inline constexpr Spread kNarrow{};
// What a field test may bring at once (ours).
inline constexpr Spread kWide{.cg_m = 0.003,
                              .tank_fill = 0.05,
                              .droop = 0.02,
                              .fade = 0.03,
                              .fan_torque_m = 0.004,
                              .fan_torque = 0.1,
                              .rotor_kg_m2 = 2e-4,
                              .imu_scale_sigma = 1e-3,
                              .imu_misaligned_sigma_rad = 2e-3,
                              .imu_skewed_sigma_rad = 5e-4,
                              .vibration_m_s2 = 0.5,
                              .vibration_rad_s = 0.01,
                              .altimeter_bias_m = 0.02,
                              .altimeter_latency_s = 0.03,
                              .camera_scale_sigma = 0.005,
                              .slope_rad = 4 * kDegree,
                              .density_kg_m3 = 1.2,
                              .wind_m_s = 2.5,
                              .gust_m_s = 2};

// The same vehicle with tolerances drawn from the seed about the given ones. The order of draws of
// the first group is that of all earlier versions.
TalarisOptions dispersed(const TalarisOptions& nominal, unsigned seed,
                         const Spread& spread = kNarrow);

class Talaris final : public Vehicle, public nodes::NodeBus {
 public:
  explicit Talaris(const TalarisOptions& options);

  std::vector<SerialLine> lines() override;
  std::vector<CanLine> can_buses() override { return {{"hopper", this}}; }
  void step() override;
  nlohmann::ordered_json truth() const override;
  void set_fault(const Fault& fault, bool attach) override;

  // For tests, which have one thread.
  const TalarisOptions& options() const { return options_; }
  Imu& imu() { return *imu_; }
  Altimeter& altimeter() { return altimeter_; }
  Altimeter& corner_altimeter(std::size_t corner) { return *corners_[corner]; }
  FlowCamera& camera() { return camera_; }
  const Plant& plant() const { return plant_; }
  const ColdGas& gas() const { return gas_; }
  const Fans& fans() const { return fans_; }
  const ValveNode& valve_node() const { return valve_node_; }
  const FanNode& fan_node() const { return fan_node_; }
  const LoadCellNode& load_cell() const { return load_cell_.value(); }
  double voltage_V() const;
  std::optional<double> range_m() const;  // the true range of the altimeter
  std::optional<double> corner_range_m(std::size_t corner) const;

 private:
  Wrench act();
  std::optional<std::array<double, 2>> ground_passes_rad_s() const;
  bool set_imu_fault(const Fault& fault, bool attach);
  bool set_camera_fault(const Fault& fault, bool attach);
  bool set_altimeter_fault(const Fault& fault, bool attach);
  bool set_corner_fault(const Fault& fault, bool attach);
  bool set_named_node_fault(const Fault& fault, bool attach);
  bool set_actuator_fault(const Fault& fault, bool attach);

  TalarisOptions options_;
  Plant plant_;
  Air air_;
  std::unique_ptr<Imu> imu_, standby_imu_;
  Altimeter altimeter_;
  std::vector<std::unique_ptr<Altimeter>> corners_;
  FlowCamera camera_;

  // The mutex guards all below: shared by physics, the bus and faults.
  ColdGas gas_;
  Fans fans_;
  ValveNode valve_node_;
  FanNode fan_node_;
  std::optional<LoadCellNode> load_cell_;
  Vector3 push_N_ = Vector3::Zero();
  double power_W_ = 0, drained_J_ = 0;
};

// The faults.
std::span<const FaultKind> fault_kinds();

}  // namespace talaris
}  // namespace lss::sim
