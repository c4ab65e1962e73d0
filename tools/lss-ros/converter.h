#pragma once

// What a daemon publishes, as ROS messages: for lss-ros, which sends them, and for lss-cli record,
// which writes them into a file. One thread, no I/O. Which channels there are depends on the
// vehicle; docs/ros2.md has the table.

#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "lss.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-ros/cdr.h"
#include "tools/lss-ros/face.h"
#include "tools/lss-ros/frames.h"
#include "tools/lss-ros/types.h"

namespace lss::ros {

// Quality of service of a reliable topic.
struct Qos {
  int depth = 10;
  bool transient_local = false;
  std::int64_t lifespan_ns = 0;  // 0: unlimited
};

struct Channel {
  std::string topic;  // /zebro_1/imu/data
  const Type* type;
  Qos qos;
};

// zebro_1: a name in ROS has letters, digits and underscores, and begins with a letter.
std::string ros_name(std::string_view vehicle_id);

// All that is sent alone by a channel.
using Message =
    std::variant<sensor_msgs::Imu, sensor_msgs::JointState, sensor_msgs::BatteryState,
                 nav_msgs::Odometry, tf2_msgs::TFMessage, diagnostic_msgs::DiagnosticArray,
                 rcl_interfaces::Log, std_msgs::String>;
std::vector<std::byte> to_cdr(const Message& message);

class Converter {
 public:
  using Put = std::function<void(std::size_t channel, const Message& message)>;

  // Messages go to `put`, within the calls below. Frames are VEHICLE/base_link and so on; the
  // vehicle must stay.
  Converter(const cli::Vehicle& vehicle, std::string vehicle_id, Put put);

  const std::vector<Channel>& channels() const { return channels_; }

  // The first status also gives what is sent once: picture and fixed frames. `sample`: of the
  // telemetry, in memory, or nullptr.
  void status(const lss_Status& status, const void* sample);
  // A message; nothing before the first status.
  void telemetry(std::span<const std::byte> cdr);
  void event(const lss_Event& event);

  // A line in the log, and a warning in the diagnostics until it is empty.
  void report(const std::string& trouble, std::int64_t utc_ns);
  // Nobody hears from the daemon any more.
  void lost(std::int64_t utc_ns);

 private:
  enum class Place { imu, joints, odom, tf, tf_static, diagnostics, battery, description, log };
  // Of an element of an array of the telemetry that is a part.
  struct Source {
    std::string name, position, velocity;  // fields; empty: none
    double angle_rad = 0;                  // of one with a velocity alone
  };

  void add(Place place, const std::string& topic, std::string_view type, Qos qos = {});
  void put(Place place, const Message& message);
  void find_joints();
  std_msgs::Header header(std::int64_t utc_ns, std::string_view frame) const;
  geometry_msgs::TransformStamped transform(std::int64_t utc_ns, const std::string& parent,
                                            const std::string& child) const;
  std::vector<Joint> joints(double step_s);
  void send_joints(std::int64_t utc_ns, const std::vector<Joint>& all);
  void send_frames(std::int64_t utc_ns, const Motion& motion, const std::vector<Joint>& all);
  void send_once(std::int64_t utc_ns);
  void send_diagnostics(std::int64_t utc_ns, std::uint8_t level, const std::string& text,
                        std::vector<diagnostic_msgs::DiagnosticStatus> more);
  void log(std::int64_t utc_ns, std::uint8_t level, const std::string& text);

  const cli::Vehicle& vehicle_;
  std::string vehicle_id_, name_, prefix_;
  Put put_;
  std::vector<Channel> channels_;
  std::map<Place, std::size_t> places_;
  const Face* face_;
  Model model_;
  std::optional<Fields> fields_;
  std::vector<Source> sources_;
  Odometer odometer_;
  UtcClock clock_;
  lss_Status status_{};
  std::int64_t last_ns_ = 0;  // of the telemetry
  std::string trouble_;
};

}  // namespace lss::ros
