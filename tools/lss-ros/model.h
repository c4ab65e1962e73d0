#pragma once

// The picture of a vehicle: links and joints in REP-103 axes, m, and the same as URDF. Pure.

#include <ros_messages.h>

#include <string>
#include <string_view>
#include <vector>

namespace lss::ros {

using geometry_msgs::Vector3;

struct Shape {
  enum class Kind { box, cylinder, sphere };
  Kind kind = Kind::box;
  Vector3 size_m;  // of a cylinder along y: radius, length; of a sphere: radius
  Vector3 at_m{};
};

// A link and the joint that it hangs on.
struct Part {
  std::string joint;   // its name; the link is JOINT_link
  std::string parent;  // name of a joint; empty: the base
  Vector3 at_m{};      // in the parent
  Vector3 axis{};      // zero: fixed
  std::vector<Shape> shapes{};
};

struct Model {
  std::vector<Shape> base;  // of base_link
  std::vector<Part> parts;  // parents first
};

inline constexpr std::string_view kBaseLink = "base_link";
// Name of the link of this joint; of the base without one.
std::string link_name(std::string_view joint);
// `prefix` goes before the name of each link.
std::string urdf(const Model& model, std::string_view name, std::string_view prefix);

}  // namespace lss::ros
