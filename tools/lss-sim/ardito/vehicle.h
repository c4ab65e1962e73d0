#pragma once

// D.I.A.N.A. Ardito as its Locomotion Controller sees it: one CAN bus with twelve CANopen nodes on
// it, and a six-wheel rocker-bogie rover behind them. The entry for lss-sim's roster, and the
// vehicle itself for tests that step it without threads.

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "tools/lss-sim/ardito/devices.h"
#include "tools/lss-sim/ardito/drive.h"
#include "tools/lss-sim/ardito/rover.h"
#include "tools/lss-sim/ardito/train.h"
#include "tools/lss-sim/canopen/node_bus.h"
#include "tools/lss-sim/frame/vehicle.h"

namespace lss::sim {

std::unique_ptr<VehicleKind> make_ardito_kind();

namespace ardito {

inline constexpr std::array<std::uint8_t, kSteered> kSteeringIds = {0x11, 0x12, 0x15, 0x16};

class Ardito final : public Vehicle, public NodeBus {
 public:
  explicit Ardito(const RoverOptions& options);

  std::vector<CanLine> can_buses() override { return {{"rover", this}}; }
  void step() override;
  nlohmann::ordered_json truth() const override;
  void set_fault(const Fault& fault, bool attach) override;

  // For tests, which have one thread.
  const RoverPlant& rover() const { return *rover_; }
  const WheelDrive& wheel(std::size_t i) const { return *wheels_[i]; }
  const SteeringDrive& steering(std::size_t i) const { return *steering_[i]; }
  const WheelTrain& train(std::size_t i) const { return trains_[i]; }
  const IoNode& io() const { return io_; }

 private:
  Drive& drive(double number);  // its number on the bus
  ShaftState steering_shaft(std::size_t i) const;
  void step_power();
  void feel();
  bool set_train_fault(const Fault& fault, bool attach);
  bool set_steering_fault(const Fault& fault, bool attach);
  bool set_sensor_fault(const Fault& fault, bool attach);

  std::unique_ptr<RoverPlant> rover_;
  // The mutex guards all below: shared by physics, the bus and faults.
  std::array<std::unique_ptr<WheelDrive>, kWheels> wheels_;
  std::array<std::unique_ptr<SteeringDrive>, kSteered> steering_;
  IoNode io_;
  ImuNode imu_;
  std::array<WheelTrain, kWheels> trains_{};
  std::array<SteeringTrain, kSteered> steering_trains_{};
  std::array<std::optional<double>, kWheels> held_degC_{};
  std::array<double, kSteered> bent_rad_{};  // of the brackets, to the left
  bool button_ = false, power_bad_ = false;
  double link_V_ = 0;
};

// The faults: every failure of the Ardito thesis' section 19, and faults of nodes and sensors.
std::span<const FaultKind> fault_kinds();

}  // namespace ardito
}  // namespace lss::sim
