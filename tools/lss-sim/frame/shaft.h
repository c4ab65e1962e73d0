#pragma once

// What a gear and its shaft do to one another in a step of a plant.

namespace lss::sim {

// The order of a gear to its shaft for one step: this speed, limited by the torque.
struct ShaftDrive {
  double velocity_rad_s = 0;
  double torque_limit_Nm = 0;
};

struct ShaftState {
  double angle_rad = 0;
  double velocity_rad_s = 0;
  double torque_Nm = 0;  // that the gear gave in the last step
};

}  // namespace lss::sim
