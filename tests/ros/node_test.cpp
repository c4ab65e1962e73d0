// The node on DDS: the bytes that Cyclone sends are those of our CDR, and discovery data is ROS'.

#include "tools/lss-ros/node.h"

#include <dds/ddsi/ddsi_serdata.h>
#include <gtest/gtest.h>
#include <ros_types.h>

#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"

namespace lss::ros {
namespace {

using testing_support::eventually;
using testing_support::own_domain;

std::string user_data(const dds_qos_t* qos) {
  void* data = nullptr;
  std::size_t size = 0;
  if (!dds_qget_userdata(qos, &data, &size) || data == nullptr) return "";
  std::string text(static_cast<const char*>(data), size);
  dds_free(data);
  return text;
}

// Of every writer on the domain, by its topic.
std::map<std::string, std::string> user_data_of_writers(dds_entity_t participant) {
  const dds::Entity reader(
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPUBLICATION, nullptr, nullptr));
  std::map<std::string, std::string> all;
  void* sample[1] = {nullptr};
  dds_sample_info_t info{};
  while (dds_take(reader.get(), sample, &info, 1, 1) == 1) {
    const auto* endpoint = static_cast<const dds_builtintopic_endpoint_t*>(sample[0]);
    if (info.valid_data) all[endpoint->topic_name] = user_data(endpoint->qos);
    dds_return_loan(reader.get(), sample, 1);
  }
  return all;
}

TEST(Node, sends_the_bytes_that_recordings_have) {
  const auto ours = dds::Participant::create({.domain = own_domain()});
  ASSERT_TRUE(ours);
  const auto theirs = dds::Participant::create({.domain = own_domain()});
  Node node(ours->get(), "/a", "lss_ros", Distro::iron);
  const Qos once{.depth = 1, .transient_local = true};
  node.add_writer({"/x", &type("diagnostic_msgs/msg/DiagnosticArray"), once});
  node.add_service("/a/stop");
  node.announce();
  diagnostic_msgs::DiagnosticArray array{{{1, 2}, "frame"}, {}};
  array.status.push_back({2, "name", "", "id", {{"key", "value"}, {"a", ""}}});
  node.write(0, array);

  const dds::Entity topic(dds_create_topic(
      theirs->get(), &diagnostic_msgs_msg_dds__DiagnosticArray__desc, "rt/x", nullptr, nullptr));
  dds_qos_t* qos = dds_create_qos();
  dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, 0);
  const dds::Entity reader(dds_create_reader(theirs->get(), topic.get(), qos, nullptr));
  dds_delete_qos(qos);
  std::vector<std::byte> bytes;
  ASSERT_TRUE(eventually([&] {
    ddsi_serdata* sample = nullptr;
    dds_sample_info_t info{};
    if (dds_takecdr(reader.get(), &sample, 1, &info, DDS_ANY_STATE) != 1) return false;
    bytes.resize(ddsi_serdata_size(sample));
    ddsi_serdata_to_ser(sample, 0, bytes.size(), bytes.data());
    ddsi_serdata_unref(sample);
    return true;
  }));
  std::vector<std::byte> expected = to_cdr(array);
  expected[3] = bytes.at(3);  // options: how many bytes fill up the last word
  expected.resize((expected.size() + 3) / 4 * 4);
  bytes.resize(expected.size());
  EXPECT_EQ(bytes, expected);

  std::map<std::string, std::string> data;
  ASSERT_TRUE(eventually([&] {
    data = user_data_of_writers(theirs->get());
    return data.contains("rt/x") && data.contains("rr/a/stopReply");
  }));
  EXPECT_EQ(data["rt/x"],
            "typehash=RIHS01_5a8a36efb05fb25070fa0fb3810290c0e6cd4862b54a8fb975a1ee8dc55a333e;");
  EXPECT_TRUE(data["rr/a/stopReply"].starts_with("serviceid=")) << data["rr/a/stopReply"];
  EXPECT_TRUE(data["rr/a/stopReply"].ends_with(
      ";typehash=RIHS01_2d946c21e2fc3f1e9ca6986a8191d85fcc70097a8bb7771a053564bc47009cdf;"));
}

// Nodes of ROS warn of an endpoint without user data, and read any other text without a complaint.
TEST(Node, our_own_topics_have_user_data_too) {
  const auto ours = dds::Participant::create({.domain = own_domain()});
  ASSERT_TRUE(ours);
  const auto writer = dds::create_writer(ours->get(), dds::common_topic(dds::Kind::status));
  ASSERT_TRUE(writer);
  EXPECT_EQ(user_data_of_writers(ours->get())["lss/status"], "lss=1;");
}

TEST(Node, knows_which_node_a_writer_belongs_to) {
  for (const Distro distro : {Distro::iron, Distro::humble}) {
    const int domain = own_domain();
    const auto ours = dds::Participant::create({.domain = domain});
    const auto theirs = dds::Participant::create({.domain = domain});
    ASSERT_TRUE(ours && theirs);
    Node node(ours->get(), "/a", "lss_ros", distro);
    node.add_reader("/cmd_vel", "std_msgs/msg/String");
    Node other(theirs->get(), "", "teleop", distro);
    other.add_writer({"/cmd_vel", &type("std_msgs/msg/String"), {}});
    other.announce();
    std::optional<Node::Received> received;
    ASSERT_TRUE(eventually([&] {
      other.write(0, std_msgs::String{"hello"});
      node.take_graph();
      received = node.next();
      return received && node.node_of(received->writer) == "teleop";
    }));
    EXPECT_EQ(from_cdr<std_msgs::String>(received->cdr)->data, "hello");
  }
}

}  // namespace
}  // namespace lss::ros
