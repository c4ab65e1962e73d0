#pragma once

// What ROS has of TALARIS. Pure data.

#include "tools/lss-ros/face.h"

namespace lss::ros::talaris {
extern const Face kFace;
}
