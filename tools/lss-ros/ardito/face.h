#pragma once

// What ROS has of D.I.A.N.A. Ardito. Pure data.

#include "tools/lss-ros/face.h"

namespace lss::ros::ardito {
extern const Face kFace;
}
