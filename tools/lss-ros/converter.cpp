#include "tools/lss-ros/converter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::ros {
namespace {

using diagnostic_msgs::DiagnosticStatus;

// diagnostic_msgs/DiagnosticStatus and rcl_interfaces/Log.
constexpr std::uint8_t kOk = 0, kWarn = 1, kError = 2, kStale = 3;
constexpr std::uint8_t kInfoLog = 20, kWarnLog = 30, kErrorLog = 40, kFatalLog = 50;
constexpr double kSecond_ns = 1e9;

// "target_rad" is what was commanded.
bool is_measured(std::string_view field) {
  return !field.starts_with("target") && !field.starts_with("set_point");
}

std::string member(const nlohmann::json& fields, std::string_view unit) {
  for (const nlohmann::json& field : fields) {
    const std::string name = field.at("name").get<std::string>();
    if (field.value("unit", "") == unit && !field.contains("count") && is_measured(name))
      return name;
  }
  return "";
}

}  // namespace

std::vector<std::byte> to_cdr(const Message& message) {
  return std::visit([](const auto& one) { return to_cdr(one); }, message);
}

std::string ros_name(std::string_view vehicle_id) {
  std::string name;
  for (const char c : vehicle_id) {
    const bool fits = std::isalnum(static_cast<unsigned char>(c)) != 0;
    name += fits ? c : '_';
  }
  if (name.empty() || std::isalpha(static_cast<unsigned char>(name.front())) == 0)
    name = "v" + name;
  return name;
}

Fields::Fields(std::string_view idl, std::string_view type)
    : types_(idl), layout_([&]() -> const cli::recording::Type& {
        const cli::recording::Type* found = types_.find(type);
        if (found == nullptr)
          throw std::runtime_error("the IDL does not have " + std::string(type));
        return *found;
      }()) {
  for (const cli::recording::Column& column : layout_.columns())
    if (column.text_size == 0) columns_[column.name] = &column;
}

void Fields::set(std::span<const std::byte> cdr) {
  layout_.check(cdr);
  cdr_ = cdr;
}

double Fields::operator()(const std::string& name) const {
  const auto found = columns_.find(name);
  return found == columns_.end() ? std::nan("") : layout_.number(*found->second, cdr_);
}

std::int64_t Fields::time_ns() const {
  const auto found = columns_.find("time_ns");
  return found == columns_.end() ? 0 : layout_.json(*found->second, cdr_).get<std::int64_t>();
}

void Odometer::add(double way_m, double anticlockwise_rad) {
  double x_m = own_.x_m, y_m = own_.y_m;
  if (way_m == 0 && anticlockwise_rad == 0) {
    x_m = y_m = 0;
  } else if (way_m_) {
    const double course_rad = (own_.yaw_rad + anticlockwise_rad) / 2;
    x_m += (way_m - *way_m_) * std::cos(course_rad);
    y_m += (way_m - *way_m_) * std::sin(course_rad);
  }
  if (std::isnan(x_m + y_m + way_m + anticlockwise_rad)) return;
  way_m_ = way_m;
  set(x_m, y_m, anticlockwise_rad);
}

void Odometer::set(double x_m, double y_m, double anticlockwise_rad) {
  if (std::isnan(x_m + y_m + anticlockwise_rad)) return;
  if (x_m == 0 && y_m == 0 && anticlockwise_rad == 0) start_ = place();
  own_ = {x_m, y_m, anticlockwise_rad};
}

Odometer::Place Odometer::place() const {
  const double cosine = std::cos(start_.yaw_rad), sine = std::sin(start_.yaw_rad);
  return {start_.x_m + cosine * own_.x_m - sine * own_.y_m,
          start_.y_m + sine * own_.x_m + cosine * own_.y_m, start_.yaw_rad + own_.yaw_rad};
}

geometry_msgs::Pose Odometer::pose() const {
  const Place at = place();
  return {{at.x_m, at.y_m, 0}, yawed(at.yaw_rad)};
}

const Face* find_face(std::string_view vehicle) {
  for (const Face* face : faces())
    if (face->vehicle == vehicle) return face;
  return nullptr;
}

Converter::Converter(const cli::Vehicle& vehicle, std::string vehicle_id, Put put)
    : vehicle_(vehicle),
      vehicle_id_(std::move(vehicle_id)),
      name_(ros_name(vehicle_id_)),
      prefix_(name_ + "/"),
      put_(std::move(put)),
      face_(find_face(vehicle.name)) {
  if (face_ != nullptr) model_ = face_->model();
  if (vehicle.telemetry != nullptr) {
    fields_.emplace(vehicle.idl, vehicle.telemetry->m_typename);
    find_joints();
  }
  const std::string own = "/" + name_ + "/";
  constexpr Qos kFrames{.depth = 100}, kOnce{.depth = 1, .transient_local = true};
  constexpr Qos kLog{.depth = 1000, .transient_local = true, .lifespan_ns = 10'000'000'000};
  if (face_ != nullptr && face_->has_imu) add(Place::imu, own + "imu/data", "sensor_msgs/msg/Imu");
  if (!sources_.empty()) add(Place::joints, own + "joint_states", "sensor_msgs/msg/JointState");
  if (face_ != nullptr && face_->has_pose) {
    add(Place::odom, own + "odom", "nav_msgs/msg/Odometry");
    add(Place::tf, "/tf", "tf2_msgs/msg/TFMessage", kFrames);
    add(Place::tf_static, "/tf_static", "tf2_msgs/msg/TFMessage", kOnce);
  }
  if (face_ != nullptr && face_->has_battery)
    add(Place::battery, own + "battery_state", "sensor_msgs/msg/BatteryState");
  if (face_ != nullptr)
    add(Place::description, own + "robot_description", "std_msgs/msg/String", kOnce);
  add(Place::diagnostics, "/diagnostics", "diagnostic_msgs/msg/DiagnosticArray");
  add(Place::log, "/rosout", "rcl_interfaces/msg/Log", kLog);
}

void Converter::add(Place place, const std::string& topic, std::string_view type_name, Qos qos) {
  places_[place] = channels_.size();
  channels_.push_back({topic, &type(type_name), qos});
}

void Converter::put(Place place, const Message& message) {
  const auto found = places_.find(place);
  if (found != places_.end()) put_(found->second, message);
}

// Elements of an array that the dictionary calls parts, with an angle or an angular velocity.
void Converter::find_joints() {
  const nlohmann::json parts = vehicle_.presentation->value("parts", nlohmann::json::array());
  for (const nlohmann::json& part : parts) {
    const auto name = part.at("field").get<std::string>();
    const auto field = std::ranges::find_if(
        *vehicle_.fields, [&](const nlohmann::json& one) { return one.at("name") == name; });
    if (field == vehicle_.fields->end() || !field->contains("fields")) continue;
    const std::string angle = member(field->at("fields"), "rad");
    const std::string rate = member(field->at("fields"), "rad/s");
    if (angle.empty() && rate.empty()) continue;
    const auto first = part.at("first").get<std::uint16_t>();
    for (std::size_t i = 0; i < field->value("count", std::size_t{0}); ++i) {
      const std::string element = fmt::format("{}[{}].", name, i);
      const auto subject = static_cast<std::uint16_t>(first + i + 1);
      sources_.push_back({cli::subject_name(vehicle_, subject),
                          angle.empty() ? "" : element + angle,
                          rate.empty() ? "" : element + rate});
    }
  }
}

std_msgs::Header Converter::header(std::int64_t utc_ns, std::string_view frame) const {
  return {stamp(utc_ns), prefix_ + std::string(frame)};
}

geometry_msgs::TransformStamped Converter::transform(std::int64_t utc_ns, const std::string& parent,
                                                     const std::string& child) const {
  geometry_msgs::TransformStamped result{header(utc_ns, parent), prefix_ + child, {}};
  result.transform.rotation.w = 1;
  return result;
}

std::vector<Joint> Converter::joints(double step_s) {
  std::vector<Joint> all;
  for (Source& source : sources_) {
    const double velocity_rad_s =
        source.velocity.empty() ? std::nan("") : (*fields_)(source.velocity);
    if (source.position.empty() && !std::isnan(velocity_rad_s))
      source.angle_rad += velocity_rad_s * step_s;
    all.push_back({source.name,
                   source.position.empty() ? source.angle_rad : (*fields_)(source.position),
                   velocity_rad_s});
  }
  return all;
}

void Converter::send_joints(std::int64_t utc_ns, const std::vector<Joint>& all) {
  sensor_msgs::JointState state;
  state.header = header(utc_ns, kBaseLink);
  for (const Joint& joint : all) {
    if (std::isnan(joint.position_rad)) continue;
    state.name.push_back(joint.name);
    state.position.push_back(joint.position_rad);
    state.velocity.push_back(joint.velocity_rad_s);
  }
  put(Place::joints, state);
}

void Converter::send_frames(std::int64_t utc_ns, const Motion& motion,
                            const std::vector<Joint>& all) {
  tf2_msgs::TFMessage frames;
  if (motion.pose) {
    geometry_msgs::TransformStamped& base =
        frames.transforms.emplace_back(transform(utc_ns, "odom", std::string(kBaseLink)));
    const geometry_msgs::Point& at = motion.pose->position;
    base.transform = {{at.x, at.y, at.z}, motion.pose->orientation};
  }
  for (const Part& part : model_.parts) {
    const auto joint = std::ranges::find(all, part.joint, &Joint::name);
    if (joint == all.end() || std::isnan(joint->position_rad)) continue;
    geometry_msgs::TransformStamped& link = frames.transforms.emplace_back(
        transform(utc_ns, link_name(part.parent), link_name(part.joint)));
    link.transform = {part.at_m, turned(part.axis, joint->position_rad)};
  }
  put(Place::tf, frames);
}

void Converter::send_once(std::int64_t utc_ns) {
  tf2_msgs::TFMessage fixed;
  fixed.transforms.push_back(transform(utc_ns, "map", "odom"));
  put(Place::tf_static, fixed);
  put(Place::description, std_msgs::String{urdf(model_, name_, prefix_)});
}

void Converter::telemetry(std::span<const std::byte> cdr) {
  if (!clock_.known() || !fields_) return;
  fields_->set(cdr);
  const std::int64_t time_ns = fields_->time_ns();
  const std::int64_t utc_ns = clock_.utc_ns(time_ns);
  const double step_s = last_ns_ == 0 ? 0 : static_cast<double>(time_ns - last_ns_) / kSecond_ns;
  last_ns_ = time_ns;
  std::vector<Joint> all = joints(step_s);
  Motion motion;
  if (face_ != nullptr) face_->read(*fields_, odometer_, motion);
  all.insert(all.end(), motion.joints.begin(), motion.joints.end());
  if (!all.empty()) send_joints(utc_ns, all);
  if (motion.imu) {
    motion.imu->header = header(utc_ns, kBaseLink);
    put(Place::imu, *motion.imu);
  }
  if (motion.battery) {
    motion.battery->header = header(utc_ns, kBaseLink);
    put(Place::battery, *motion.battery);
  }
  if (motion.pose) {
    nav_msgs::Odometry odom;
    odom.header = header(utc_ns, "odom");
    odom.child_frame_id = prefix_ + std::string(kBaseLink);
    odom.pose.pose = *motion.pose;
    odom.twist.twist = motion.twist;
    put(Place::odom, odom);
  }
  send_frames(utc_ns, motion, all);
}

void Converter::status(const lss_Status& status, const void* sample) {
  const bool first = !clock_.known();
  clock_.set(status.time_ns, status.utc_ns);
  status_ = status;
  if (first) send_once(status.utc_ns);
  std::uint8_t worst = kOk;
  std::vector<DiagnosticStatus> more;
  for (const cli::Problem& problem : cli::problems(vehicle_, status, sample)) {
    const std::uint8_t level = problem.error ? kError : kWarn;
    worst = std::max(worst, level);
    DiagnosticStatus& one = more.emplace_back();
    one.level = level;
    one.name = vehicle_id_ + ": problem " + std::to_string(more.size());
    one.message = problem.text;
    one.hardware_id = vehicle_id_;
    one.values = {{"advice", problem.advice}};
  }
  if (!trouble_.empty()) {
    worst = std::max(worst, kWarn);
    DiagnosticStatus& one = more.emplace_back();
    one.level = kWarn;
    one.name = vehicle_id_ + ": cmd_vel";
    one.message = trouble_;
    one.hardware_id = vehicle_id_;
  }
  const std::string mode(cli::text(status.mode_name));
  send_diagnostics(status.utc_ns, worst,
                   std::string(cli::state_name(status.state)) +
                       (status.state == lss_STATE_OPERATIONAL ? " " + mode : ""),
                   std::move(more));
}

void Converter::lost(std::int64_t utc_ns) {
  send_diagnostics(utc_ns, kStale, "the daemon sends nothing", {});
}

void Converter::send_diagnostics(std::int64_t utc_ns, std::uint8_t level, const std::string& text,
                                 std::vector<DiagnosticStatus> more) {
  DiagnosticStatus whole;
  whole.level = level;
  whole.name = vehicle_id_ + ": lssd";
  whole.message = text;
  whole.hardware_id = vehicle_id_;
  whole.values = {{"vehicle", std::string(vehicle_.name)},
                  {"version", std::string(cli::text(status_.version))},
                  {"authority", std::string(cli::text(status_.authority))},
                  {"faults", std::to_string(status_.fault_count)},
                  {"overruns", std::to_string(status_.overruns)},
                  {"commands_rejected", std::to_string(status_.commands_rejected)}};
  more.insert(more.begin(), std::move(whole));
  put(Place::diagnostics, diagnostic_msgs::DiagnosticArray{{stamp(utc_ns), ""}, std::move(more)});
}

void Converter::log(std::int64_t utc_ns, std::uint8_t level, const std::string& text) {
  rcl_interfaces::Log line;
  line.stamp = stamp(utc_ns);
  line.level = level;
  line.name = name_ + ".lss_ros";
  line.msg = text;
  put(Place::log, line);
}

void Converter::event(const lss_Event& event) {
  constexpr std::uint8_t kLevels[] = {kInfoLog, kWarnLog, kErrorLog, kFatalLog};
  const auto severity = static_cast<std::size_t>(event.severity);
  log(event.utc_ns, severity < std::size(kLevels) ? kLevels[severity] : kErrorLog,
      std::string(cli::text(event.text)));
}

void Converter::report(const std::string& trouble, std::int64_t utc_ns) {
  if (!trouble.empty()) log(utc_ns, kWarnLog, trouble);
  trouble_ = trouble;
}

}  // namespace lss::ros
