// A ROS 2 peer of another vendor's DDS (Fast DDS, types by fastddsgen from the same IDL):
// subscribes to all topics of a vehicle, publishes cmd_vel ten times a second, and calls services.
// On loopback.
//
//   ros_peer DOMAIN SPACE [ENCLAVE]     then lines: "drive AHEAD TURN", "silent", "call SERVICE"
//
// ENCLAVE: folder with the files of SROS2 for DDS Security.
// It prints JSON lines: what it discovered, and what it received.

#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <poll.h>
#include <unistd.h>

#include <cmath>
#include <fastdds/dds/domain/DomainParticipant.hpp>
#include <fastdds/dds/domain/DomainParticipantFactory.hpp>
#include <fastdds/dds/domain/DomainParticipantListener.hpp>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/publisher/Publisher.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/subscriber/DataReaderListener.hpp>
#include <fastdds/dds/subscriber/SampleInfo.hpp>
#include <fastdds/dds/subscriber/Subscriber.hpp>
#include <fastdds/dds/topic/TypeSupport.hpp>
#include <functional>
#include <iostream>
#include <memory>
#include <mutex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "ros_typesPubSubTypes.h"

using namespace eprosima::fastdds::dds;
using eprosima::fastrtps::rtps::ParticipantDiscoveryInfo;
using eprosima::fastrtps::rtps::ReaderDiscoveryInfo;
using eprosima::fastrtps::rtps::WriterDiscoveryInfo;

namespace {

std::mutex printing;

std::string quote(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    if (c >= ' ' && c <= '~') out += c;
    if (c == '\n') out += "\\n";
  }
  return out + "\"";
}

std::string number(double value) {
  std::ostringstream out;
  out.precision(17);
  out << value;
  return std::isfinite(value) ? out.str() : "null";
}

void say(const std::string& line) {
  const std::lock_guard<std::mutex> lock(printing);
  std::cout << "{" << line << "}" << std::endl;
}

template <class Bytes>
std::string text(const Bytes& bytes) {
  return std::string(bytes.begin(), bytes.end());
}

class Discovery : public DomainParticipantListener {
 public:
  void on_participant_discovery(DomainParticipant*, ParticipantDiscoveryInfo&& info) override {
    if (info.status == ParticipantDiscoveryInfo::DISCOVERED_PARTICIPANT ||
        info.status == ParticipantDiscoveryInfo::CHANGED_QOS_PARTICIPANT)
      say("\"participant\":" + quote(text(info.info.m_userData)));
  }
  void on_publisher_discovery(DomainParticipant*, WriterDiscoveryInfo&& info) override {
    const auto& qos = info.info.m_qos;
    endpoint("writer", info.info.topicName().to_string(), info.info.typeName().to_string(),
             text(qos.m_userData), qos.m_reliability.kind == RELIABLE_RELIABILITY_QOS,
             qos.m_durability.kind == TRANSIENT_LOCAL_DURABILITY_QOS);
  }
  void on_subscriber_discovery(DomainParticipant*, ReaderDiscoveryInfo&& info) override {
    const auto& qos = info.info.m_qos;
    endpoint("reader", info.info.topicName().to_string(), info.info.typeName().to_string(),
             text(qos.m_userData), qos.m_reliability.kind == RELIABLE_RELIABILITY_QOS,
             qos.m_durability.kind == TRANSIENT_LOCAL_DURABILITY_QOS);
  }

 private:
  static void endpoint(const char* kind, const std::string& topic, const std::string& type,
                       const std::string& data, bool reliable, bool kept) {
    say(std::string("\"") + kind + "\":" + quote(topic) + ",\"type\":" + quote(type) +
        ",\"user_data\":" + quote(data) + ",\"reliable\":" + (reliable ? "true" : "false") +
        ",\"transient_local\":" + (kept ? "true" : "false"));
  }
};

template <class Message>
class Ear : public DataReaderListener {
 public:
  Ear(std::string topic, std::function<std::string(const Message&)> shown)
      : topic_(std::move(topic)), shown_(std::move(shown)) {}
  void on_data_available(DataReader* reader) override {
    Message message;
    SampleInfo info;
    while (reader->take_next_sample(&message, &info) == ReturnCode_t::RETCODE_OK) {
      if (info.valid_data) say("\"topic\":" + quote(topic_) + "," + shown_(message));
    }
  }

 private:
  std::string topic_;
  std::function<std::string(const Message&)> shown_;
};

void secure(DomainParticipantQos& qos, const std::string& enclave) {
  const std::string authentication = "dds.sec.auth.builtin.PKI-DH.",
                    access = "dds.sec.access.builtin.Access-Permissions.",
                    files = "file://" + enclave + "/";
  for (const auto& [name, value] : std::vector<std::pair<std::string, std::string>>{
           {"dds.sec.auth.plugin", "builtin.PKI-DH"},
           {authentication + "identity_ca", files + "identity_ca.cert.pem"},
           {authentication + "identity_certificate", files + "cert.pem"},
           {authentication + "private_key", files + "key.pem"},
           {"dds.sec.crypto.plugin", "builtin.AES-GCM-GMAC"},
           {"dds.sec.access.plugin", "builtin.Access-Permissions"},
           {access + "permissions_ca", files + "permissions_ca.cert.pem"},
           {access + "governance", files + "governance.p7s"},
           {access + "permissions", files + "permissions.p7s"}})
    qos.properties().properties().emplace_back(name, value);
}

class Peer {
 public:
  Peer(int domain, std::string space, const std::string& secured) : space_(std::move(space)) {
    auto loopback = std::make_shared<eprosima::fastdds::rtps::UDPv4TransportDescriptor>();
    loopback->interfaceWhiteList = {"127.0.0.1"};
    DomainParticipantQos qos = PARTICIPANT_QOS_DEFAULT;
    qos.transport().use_builtin_transports = false;
    qos.transport().user_transports.push_back(loopback);
    const std::string enclave = "enclave=/;";
    qos.user_data().setValue({enclave.begin(), enclave.end()});
    if (!secured.empty()) secure(qos, secured);
    participant_ = DomainParticipantFactory::get_instance()->create_participant(
        static_cast<DomainId_t>(domain), qos, &discovery_, StatusMask::none());
    if (participant_ == nullptr) throw std::runtime_error("no participant: see its log");
    publisher_ = participant_->create_publisher(PUBLISHER_QOS_DEFAULT);
    subscriber_ = participant_->create_subscriber(SUBSCRIBER_QOS_DEFAULT);
  }

  template <class Support, class Message>
  void hear(const std::string& name, bool kept, std::function<std::string(const Message&)> shown) {
    DataReaderQos qos = DATAREADER_QOS_DEFAULT;
    qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = kept ? TRANSIENT_LOCAL_DURABILITY_QOS : VOLATILE_DURABILITY_QOS;
    qos.history().depth = 100;
    subscriber_->create_datareader(topic<Support>(name), qos,
                                   new Ear<Message>(name, std::move(shown)));
  }
  template <class Support>
  DataWriter* writer(const std::string& name) {
    DataWriterQos qos = DATAWRITER_QOS_DEFAULT;
    qos.reliability().kind = RELIABLE_RELIABILITY_QOS;
    qos.durability().kind = VOLATILE_DURABILITY_QOS;
    return publisher_->create_datawriter(topic<Support>(name), qos);
  }
  std::string full(const std::string& name) const { return space_ + "/" + name; }

 private:
  template <class Support>
  Topic* topic(const std::string& name) {
    TypeSupport type(new Support);
    type.register_type(participant_);
    return participant_->create_topic(name, type.get_type_name(), TOPIC_QOS_DEFAULT);
  }

  std::string space_;
  Discovery discovery_;
  DomainParticipant* participant_;
  Publisher* publisher_;
  Subscriber* subscriber_;
};

void hear_all(Peer& peer) {
  peer.hear<sensor_msgs::msg::dds_::Imu_PubSubType, sensor_msgs::msg::dds_::Imu_>(
      "rt" + peer.full("imu/data"), false, [](const auto& m) {
        return "\"turn\":" + number(m.angular_velocity().z()) +
               ",\"acceleration_covariance\":" + number(m.linear_acceleration_covariance()[0]);
      });
  peer.hear<sensor_msgs::msg::dds_::JointState_PubSubType, sensor_msgs::msg::dds_::JointState_>(
      "rt" + peer.full("joint_states"), false, [](const auto& m) {
        std::string names;
        for (const std::string& name : m.name()) names += (names.empty() ? "" : ",") + quote(name);
        return "\"names\":[" + names + "],\"positions\":" + number(double(m.position().size()));
      });
  peer.hear<nav_msgs::msg::dds_::Odometry_PubSubType, nav_msgs::msg::dds_::Odometry_>(
      "rt" + peer.full("odom"), false, [](const auto& m) {
        return "\"frame\":" + quote(m.header().frame_id()) +
               ",\"child\":" + quote(m.child_frame_id()) +
               ",\"sec\":" + number(m.header().stamp().sec()) +
               ",\"x\":" + number(m.pose().pose().position().x()) +
               ",\"y\":" + number(m.pose().pose().position().y()) +
               ",\"yaw\":" + number(2 * std::asin(m.pose().pose().orientation().z())) +
               ",\"speed\":" + number(m.twist().twist().linear().x());
      });
  for (const bool fixed : {false, true})
    peer.hear<tf2_msgs::msg::dds_::TFMessage_PubSubType, tf2_msgs::msg::dds_::TFMessage_>(
        fixed ? "rt/tf_static" : "rt/tf", fixed, [](const auto& m) {
          std::string frames;
          for (const auto& one : m.transforms())
            frames += (frames.empty() ? "" : ",") + quote(one.child_frame_id());
          return "\"children\":[" + frames + "]";
        });
  peer.hear<diagnostic_msgs::msg::dds_::DiagnosticArray_PubSubType,
            diagnostic_msgs::msg::dds_::DiagnosticArray_>(
      "rt/diagnostics", false, [](const auto& m) {
        std::string all;
        for (const auto& one : m.status())
          all += (all.empty() ? "" : ",") +
                 ("[" + quote(one.name()) + "," + quote(one.message()) + "]");
        return "\"status\":[" + all + "]";
      });
  peer.hear<std_msgs::msg::dds_::String_PubSubType, std_msgs::msg::dds_::String_>(
      "rt" + peer.full("robot_description"), true,
      [](const auto& m) { return "\"text\":" + quote(m.data()); });
  peer.hear<rcl_interfaces::msg::dds_::Log_PubSubType, rcl_interfaces::msg::dds_::Log_>(
      "rt/rosout", true, [](const auto& m) {
        return "\"level\":" + number(m.level()) + ",\"text\":" + quote(m.msg());
      });
  peer.hear<rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_PubSubType,
            rmw_dds_common::msg::dds_::ParticipantEntitiesInfo_>(
      "ros_discovery_info", true, [](const auto& m) {
        const auto& node = m.node_entities_info_seq().at(0);
        return "\"node\":" + quote(node.node_namespace() + "/" + node.node_name()) +
               ",\"writers\":" + number(double(node.writer_gid_seq().size())) +
               ",\"readers\":" + number(double(node.reader_gid_seq().size()));
      });
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3 || argc > 4) return 2;
  Peer peer(std::stoi(argv[1]), argv[2], argc == 4 ? argv[3] : "");
  hear_all(peer);
  DataWriter* velocity =
      peer.writer<geometry_msgs::msg::dds_::Twist_PubSubType>("rt" + peer.full("cmd_vel"));
  std::map<std::string, DataWriter*> calls;
  for (const char* name : {"stop", "estop", "solve", "start"}) {
    calls[name] = peer.writer<std_srvs::srv::dds_::Trigger_Request_PubSubType>(
        "rq" + peer.full(name) + "Request");
    peer.hear<std_srvs::srv::dds_::Trigger_Response_PubSubType,
              std_srvs::srv::dds_::Trigger_Response_>(
        "rr" + peer.full(name) + "Reply", false, [](const auto& m) {
          return "\"client\":" + number(double(m.rmw_client())) +
                 ",\"sequence\":" + number(double(m.rmw_sequence())) +
                 ",\"success\":" + (m.success() ? "true" : "false") +
                 ",\"text\":" + quote(m.message());
        });
  }
  geometry_msgs::msg::dds_::Twist_ twist;
  bool drives = false;
  long sequence = 0;
  std::string typed;  // of which the last line may not be complete
  while (true) {
    pollfd input{0, POLLIN, 0};
    if (poll(&input, 1, 100) == 1) {
      char more[4096];
      const ssize_t size = read(0, more, sizeof more);
      if (size <= 0) return 0;
      typed.append(more, static_cast<std::size_t>(size));
    }
    for (std::size_t end; (end = typed.find('\n')) != std::string::npos; typed.erase(0, end + 1)) {
      std::istringstream words(typed.substr(0, end));
      std::string word;
      words >> word;
      if (word == "drive") {
        std::string ahead, turn;  // "nan", too
        words >> ahead >> turn;
        twist.linear().x(std::stod(ahead));
        twist.angular().z(std::stod(turn));
      }
      drives = word == "drive" || (word == "call" && drives);
      if (word == "call") {
        words >> word;
        std_srvs::srv::dds_::Trigger_Request_ request;
        request.rmw_client(42);
        request.rmw_sequence(++sequence);
        calls.at(word)->write(&request);
      }
    }
    if (drives) velocity->write(&twist);
  }
}
