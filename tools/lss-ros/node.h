#pragma once

// A ROS 2 node on DDS, as rmw_cyclonedds makes one: names, types, QoS and the texts in discovery
// data (docs/ros2.md). One thread.

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "idl/topics.h"
#include "tools/lss-ros/converter.h"

namespace lss::ros {

enum class Distro { humble, iron };  // iron: and later

using Guid = std::array<std::uint8_t, 16>;

// The next sample of a reader, as CDR; empty: there is none.
std::vector<std::byte> take_cdr(const dds::Entity& reader, dds_sample_info_t& info);

class Node {
 public:
  // The participant must outlive it.
  Node(dds_entity_t participant, std::string space, std::string name, Distro distro);
  ~Node();
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  // Readable when there may be something to take.
  int news_fd() const { return news_fd_; }
  void take_news();
  const dds_listener_t* listener() const { return listener_; }  // makes it so

  // The number of the channel, from 0 on.
  std::size_t add_writer(const Channel& channel);
  void write(std::size_t channel, const Message& message);
  // Best effort, so that it matches every writer.
  void add_reader(const std::string& topic, std::string_view type);
  struct Received {
    Guid writer;
    std::vector<std::byte> cdr;
  };
  std::optional<Received> next();  // of that reader

  // Of std_srvs/srv/Trigger.
  void add_service(const std::string& name);
  struct Request {
    std::size_t service;  // from 0 on
    std::uint64_t client = 0;
    std::int64_t sequence = 0;
  };
  std::optional<Request> next_request();
  void reply(const Request& request, bool success, const std::string& text);

  // Says what the node has. Call when all of it was added.
  void announce();
  // Takes what other nodes say they have.
  void take_graph();
  // The name of the node that has this writer; empty: unknown.
  std::string node_of(const Guid& writer) const;

 private:
  struct Service {
    dds::Entity reader, writer;
  };

  dds::Entity entity(const std::string& name, const dds_topic_descriptor_t& descriptor,
                     const Qos& qos, bool writes, bool reliable, const std::string& more);
  dds::Entity writer_of_type(const std::string& topic, const Type& type, const Qos& qos);

  dds_entity_t participant_;
  std::string space_, name_;
  Distro distro_;
  int news_fd_;
  dds_listener_t* listener_;
  std::vector<dds::Entity> writers_;
  dds::Entity reader_, graph_writer_, graph_reader_;
  std::vector<Service> services_;
  std::map<Guid, std::map<Guid, std::string>> nodes_;  // of a participant: name of each writer
};

}  // namespace lss::ros
