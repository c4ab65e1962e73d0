#include "tools/lss-ros/types.h"

#include <algorithm>
#include <stdexcept>

namespace lss::ros {

std::span<const Type> types() {
  static constexpr Type kTypes[] = {
#define LSS_ROS_TYPE(package, kind, name, hash, text) \
  {#package "/" #kind "/" #name, #package "::" #kind "::dds_::" #name "_", hash, text},
#include <ros_messages.inc>
#undef LSS_ROS_TYPE
  };
  return kTypes;
}

const Type& type(std::string_view name) {
  const auto found = std::ranges::find(types(), name, &Type::name);
  if (found == types().end()) throw std::logic_error("no ROS type " + std::string(name));
  return *found;
}

}  // namespace lss::ros
