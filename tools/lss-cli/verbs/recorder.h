#pragma once

// Records DDS topics of one vehicle, as they are on the wire, into an MCAP file: one reader for
// each topic, chunks of 0.1 s, and a count of lost messages. Main thread; every wait is bounded.

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "idl/topics.h"
#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-cli/recording/mcap_writer.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/session/waker.h"
#include "tools/lss-cli/show/options.h"
#include "tools/lss-ros/converter.h"

namespace lss::cli {

class Recorder {
 public:
  // A participant of its own, on the domain of the options. `topics` as in recording::names();
  // empty: all. `ros2`: also what lss-ros would send, made from the recorded topics.
  Recorder(const Options& options, const Vehicle& vehicle, std::string vehicle_id,
           recording::McapWriter& writer, const std::vector<std::string>& topics, bool ros2);

  // Waits until a message arrives, a chunk ends, or `until`; then takes all messages. True for
  // Ctrl-C.
  bool wait(Clock::time_point until);

  struct Source {
    std::string topic;
    std::uint64_t messages = 0;
    std::uint64_t gaps = 0;  // by the counter in the messages
    std::uint64_t lost = 0;  // from DDS
  };
  std::vector<Source> sources() const;
  std::uint64_t messages() const;
  std::uint64_t lost() const;  // gaps

 private:
  struct Reader {
    Source source;
    dds::Entity entity;
    std::size_t size = 0;  // of a sample in memory
    std::uint16_t channel = 0;
    std::int64_t known_ns = 0;  // earlier messages were in the file before
    recording::Types types;
    recording::Layout layout;
    const recording::Column* counter = nullptr;
    const recording::Column* index = nullptr;                  // of all keys together
    std::map<dds_instance_handle_t, std::uint64_t> last = {};  // of the counter, for each key
  };

  using Memory = std::vector<std::max_align_t>;

  void add(const dds::Topic& topic, std::string_view idl);
  void take();
  void take(Reader& reader);
  void put(Reader& reader, recording::Bytes data, const Memory& sample,
           const dds_sample_info_t& info);
  void open_ros2();
  void convert(const Reader& reader, recording::Bytes data, const Memory& sample);

  Waker waker_;  // before any entity
  dds::Participant participant_;
  const Vehicle& vehicle_;
  std::string vehicle_id_;
  recording::McapWriter& writer_;
  std::vector<std::unique_ptr<Reader>> readers_;
  // Of ROS.
  struct RosChannel {
    std::uint16_t number;
    std::uint32_t messages = 0;
  };
  std::vector<RosChannel> ros_channels_;
  std::optional<ros::Converter> converter_;
  Memory sample_, telemetry_;  // in memory: of the message that is converted, the newest telemetry
  std::int64_t published_ns_ = 0;  // of the message that is converted
  std::vector<std::byte> buffer_;
  std::int64_t begun_ns_, last_ns_ = 0;
  Clock::time_point chunk_ends_, sync_;
};

}  // namespace lss::cli
