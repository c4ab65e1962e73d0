#include "tools/lss-ros/model.h"

#include <fmt/format.h>

#include <numbers>

namespace lss::ros {
namespace {

std::string shape(const Shape& one) {
  const Vector3& s = one.size_m;
  std::string geometry, turn = "0 0 0";
  switch (one.kind) {
    case Shape::Kind::box:
      geometry = fmt::format(R"(<box size="{} {} {}"/>)", s.x, s.y, s.z);
      break;
    case Shape::Kind::sphere: geometry = fmt::format(R"(<sphere radius="{}"/>)", s.x); break;
    case Shape::Kind::cylinder:
      geometry = fmt::format(R"(<cylinder radius="{}" length="{}"/>)", s.x, s.y);
      turn = fmt::format("{} 0 0", std::numbers::pi / 2);
      break;
  }
  return fmt::format(
      "    <visual><origin xyz=\"{} {} {}\" rpy=\"{}\"/><geometry>{}</geometry></visual>\n",
      one.at_m.x, one.at_m.y, one.at_m.z, turn, geometry);
}

std::string link(const std::string& name, const std::vector<Shape>& shapes) {
  std::string text = fmt::format("  <link name=\"{}\">\n", name);
  for (const Shape& one : shapes) text += shape(one);
  return text + "  </link>\n";
}

bool is_fixed(const Vector3& axis) { return axis.x == 0 && axis.y == 0 && axis.z == 0; }

}  // namespace

std::string link_name(std::string_view joint) {
  return joint.empty() ? std::string(kBaseLink) : std::string(joint) + "_link";
}

std::string urdf(const Model& model, std::string_view name, std::string_view prefix) {
  const auto full = [&](std::string_view joint) { return std::string(prefix) + link_name(joint); };
  std::string text = fmt::format("<?xml version=\"1.0\"?>\n<robot name=\"{}\">\n", name);
  text += link(full(""), model.base);
  for (const Part& part : model.parts) {
    text += link(full(part.joint), part.shapes);
    text += fmt::format(
        "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{}\"/><child link=\"{}\"/>\n"
        "    <origin xyz=\"{} {} {}\" rpy=\"0 0 0\"/>",
        part.joint, is_fixed(part.axis) ? "fixed" : "continuous", full(part.parent),
        full(part.joint), part.at_m.x, part.at_m.y, part.at_m.z);
    if (!is_fixed(part.axis))
      text += fmt::format("<axis xyz=\"{} {} {}\"/>", part.axis.x, part.axis.y, part.axis.z);
    text += "\n  </joint>\n";
  }
  return text + "</robot>\n";
}

}  // namespace lss::ros
