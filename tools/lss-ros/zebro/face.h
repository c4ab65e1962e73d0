#pragma once

// What ROS has of Lunar Zebro. Pure data.

#include "tools/lss-ros/face.h"

namespace lss::ros::zebro {
extern const Face kFace;
}
