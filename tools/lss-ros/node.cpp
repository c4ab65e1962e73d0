#include "tools/lss-ros/node.h"

#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>
#include <ros_types.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <list>

#include "tools/lss-cli/show/failure.h"

namespace lss::ros {
namespace {

using cli::ExitCode;
using cli::Failure;

// Memory of sequences in the structs of idlc, which point into it and into the message.
using Arena = std::list<std::vector<std::max_align_t>>;

template <class T>
requires std::is_arithmetic_v<T>
void to_c(const T& from, T& to, Arena&) { to = from; }
inline void to_c(const std::string& from, char*& to, Arena&) {
  to = const_cast<char*>(from.c_str());  // Cyclone only reads it
}
template <class T, std::size_t N>
void to_c(const std::array<T, N>& from, T (&to)[N], Arena&) {
  std::ranges::copy(from, to);
}
template <class T, class Sequence>
void to_c(const std::vector<T>& from, Sequence& to, Arena& arena);

#include <ros_to_c.inc>

template <class T, class Sequence>
void to_c(const std::vector<T>& from, Sequence& to, Arena& arena) {
  using Element = std::remove_pointer_t<decltype(to._buffer)>;
  const std::size_t size = from.size() * sizeof(Element);
  std::vector<std::max_align_t>& memory =
      arena.emplace_back((size + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
  to._maximum = to._length = static_cast<std::uint32_t>(from.size());
  to._buffer = reinterpret_cast<Element*>(memory.data());
  for (std::size_t i = 0; i < from.size(); ++i) to_c(from[i], to._buffer[i], arena);
}

template <class C, class Message>
void write_as(dds_entity_t writer, const Message& message) {
  C sample{};
  Arena arena;
  to_c(message, sample, arena);
  dds_write(writer, &sample);
}

const dds_topic_descriptor_t& descriptor_of(std::string_view name) {
  static const std::map<std::string_view, const dds_topic_descriptor_t*> kAll = {
#define LSS_ROS_TYPE(package, kind, name, hash, text) \
  {#package "/" #kind "/" #name, &package##_##kind##_dds__##name##__desc},
#include <ros_messages.inc>
#undef LSS_ROS_TYPE
  };
  return *kAll.at(name);
}

std::string hash_text(const Type& type) { return fmt::format("typehash=RIHS01_{};", type.hash); }

Guid guid_of(dds_entity_t entity) {
  dds_guid_t guid{};
  dds_get_guid(entity, &guid);
  Guid result;
  std::ranges::copy(guid.v, result.begin());
  return result;
}

std::string dotted(const Guid& guid) {
  std::string text;
  for (const std::uint8_t byte : guid) text += fmt::format("{}{:x}", text.empty() ? "" : ".", byte);
  return text;
}

template <class Gid>
Gid gid_of(dds_entity_t entity) {
  Gid gid{};
  std::ranges::copy(guid_of(entity), gid.data.begin());
  return gid;
}

Guid guid_in(const auto& gid) {
  Guid guid;
  std::copy_n(gid.data.begin(), guid.size(), guid.begin());
  return guid;
}

constexpr std::string_view kGraph = "rmw_dds_common/msg/ParticipantEntitiesInfo";

// Of Humble, under the name that it has there.
dds_topic_descriptor_t graph_descriptor(Distro distro) {
  dds_topic_descriptor_t descriptor = distro == Distro::humble
                                          ? humble_msg_dds__ParticipantEntitiesInfo__desc
                                          : descriptor_of(kGraph);
  descriptor.m_typename = type(kGraph).dds_name.data();
  return descriptor;
}

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};

}  // namespace

Node::Node(dds_entity_t participant, std::string space, std::string name, Distro distro)
    : participant_(participant),
      space_(std::move(space)),
      name_(std::move(name)),
      distro_(distro),
      news_fd_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)),
      listener_(dds_create_listener(&news_fd_)) {
  if (news_fd_ < 0) throw Failure(ExitCode::internal, "no file descriptors left");
  dds_lset_data_available(listener_, [](dds_entity_t, void* fd) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const ssize_t written = ::write(*static_cast<int*>(fd), &one, sizeof one);
  });
  const dds_topic_descriptor_t graph = graph_descriptor(distro);
  const std::string hash = distro == Distro::humble ? "" : hash_text(type(kGraph));
  const Qos once{.depth = 1, .transient_local = true};
  graph_writer_ = entity("ros_discovery_info", graph, once, true, true, hash);
  graph_reader_ =
      entity("ros_discovery_info", graph, {.depth = 0, .transient_local = true}, false, true, hash);
}

Node::~Node() {
  reader_.reset(), graph_reader_.reset(), services_.clear();
  dds_delete_listener(listener_);
  close(news_fd_);
}

void Node::take_news() {
  std::uint64_t news = 0;
  [[maybe_unused]] const ssize_t n = read(news_fd_, &news, sizeof news);
}

// Depth 0: keep all.
dds::Entity Node::entity(const std::string& name, const dds_topic_descriptor_t& descriptor,
                         const Qos& wanted, bool writes, bool reliable, const std::string& data) {
  const std::unique_ptr<dds_qos_t, QosDeleter> qos(dds_create_qos());
  const dds_history_kind_t kind = wanted.depth == 0 ? DDS_HISTORY_KEEP_ALL : DDS_HISTORY_KEEP_LAST;
  dds_qset_writer_data_lifecycle(qos.get(), false);
  dds_qset_history(qos.get(), kind, wanted.depth);
  // rmw blocks without end; here a reader that is stuck delays no command, and loses messages.
  dds_qset_reliability(qos.get(), reliable ? DDS_RELIABILITY_RELIABLE : DDS_RELIABILITY_BEST_EFFORT,
                       DDS_MSECS(1));
  if (wanted.transient_local) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    dds_qset_durability_service(qos.get(), 0, kind, wanted.depth, DDS_LENGTH_UNLIMITED,
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  }
  if (wanted.lifespan_ns > 0 && writes) dds_qset_lifespan(qos.get(), wanted.lifespan_ns);
  if (!writes) dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  const dds_data_representation_id_t xcdr1 = DDS_DATA_REPRESENTATION_XCDR1;
  dds_qset_data_representation(qos.get(), 1, &xcdr1);
  dds_qset_userdata(qos.get(), data.data(), data.size());
  const dds::Entity topic(
      dds_create_topic(participant_, &descriptor, name.c_str(), nullptr, nullptr));
  const dds_entity_t made =
      !topic   ? topic.get()
      : writes ? dds_create_writer(participant_, topic.get(), qos.get(), nullptr)
               : dds_create_reader(participant_, topic.get(), qos.get(), listener_);
  if (made == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY)
    throw Failure(ExitCode::usage,
                  fmt::format("the permissions of the enclave do not allow DDS topic {}", name),
                  "take an enclave of the role bridge: docs/security.md");
  if (made < 0)
    throw Failure(ExitCode::internal,
                  fmt::format("cannot create DDS topic {}: {}", name, dds_strretcode(made)));
  return dds::Entity(made);
}

dds::Entity Node::writer_of_type(const std::string& topic, const Type& type, const Qos& qos) {
  return entity("rt" + topic, descriptor_of(type.name), qos, true, true,
                distro_ == Distro::humble ? "" : hash_text(type));
}

std::size_t Node::add_writer(const Channel& channel) {
  writers_.push_back(writer_of_type(channel.topic, *channel.type, channel.qos));
  return writers_.size() - 1;
}

void Node::write(std::size_t channel, const Message& message) {
  const dds_entity_t writer = writers_[channel].get();
  std::visit([&](const auto& one) { write_as<decltype(c_struct_of(one))>(writer, one); }, message);
}

void Node::add_reader(const std::string& topic, std::string_view type_name) {
  const Type& kind = type(type_name);
  reader_ = entity("rt" + topic, descriptor_of(kind.name), {.depth = 1}, false, false,
                   distro_ == Distro::humble ? "" : hash_text(kind));
}

std::vector<std::byte> take_cdr(const dds::Entity& reader, dds_sample_info_t& info) {
  ddsi_serdata* sample = nullptr;
  std::vector<std::byte> cdr;
  while (cdr.empty() && reader &&
         dds_takecdr(reader.get(), &sample, 1, &info, DDS_ANY_STATE) == 1) {
    if (info.valid_data) {
      cdr.resize(ddsi_serdata_size(sample));
      ddsi_serdata_to_ser(sample, 0, cdr.size(), cdr.data());
    }
    ddsi_serdata_unref(sample);
  }
  return cdr;
}

std::optional<Node::Received> Node::next() {
  dds_sample_info_t info{};
  std::vector<std::byte> cdr = take_cdr(reader_, info);
  if (cdr.empty()) return std::nullopt;
  Received received{{}, std::move(cdr)};
  if (auto* writer = dds_get_matched_publication_data(reader_.get(), info.publication_handle)) {
    std::ranges::copy(writer->key.v, received.writer.begin());
    dds_builtintopic_free_endpoint(writer);
  }
  return received;
}

void Node::add_service(const std::string& name) {
  const Type& request = type("std_srvs/srv/Trigger_Request");
  const Type& response = type("std_srvs/srv/Trigger_Response");
  // As rmw: the id of the participant, and a number.
  Guid id = guid_of(participant_);
  id[12] = id[13] = id[14] = 0;
  id[15] = static_cast<std::uint8_t>(services_.size() + 1);
  const auto data = [&](const Type& type) {
    return "serviceid=" + dotted(id) + ";" + (distro_ == Distro::humble ? "" : hash_text(type));
  };
  Service& service = services_.emplace_back();
  service.writer =
      entity("rr" + name + "Reply", descriptor_of(response.name), {}, true, true, data(response));
  service.reader =
      entity("rq" + name + "Request", descriptor_of(request.name), {}, false, true, data(request));
}

std::optional<Node::Request> Node::next_request() {
  for (std::size_t i = 0; i < services_.size(); ++i) {
    dds_sample_info_t info{};
    const std::vector<std::byte> cdr = take_cdr(services_[i].reader, info);
    Request request{.service = i};
    CdrReader reader(cdr);
    if (reader.get(request.client) && reader.get(request.sequence)) return request;
  }
  return std::nullopt;
}

void Node::reply(const Request& request, bool success, const std::string& text) {
  std_srvs_srv_dds__Trigger_Response_ sample{};
  Arena arena;
  const std_srvs::Trigger_Response response{success, text};
  to_c(response, sample, arena);
  sample.rmw_client = request.client;
  sample.rmw_sequence = request.sequence;
  dds_write(services_[request.service].writer.get(), &sample);
}

namespace {

template <class Info, class NodeInfo>
Info info_of(dds_entity_t participant, const std::string& space, const std::string& name,
             const std::vector<dds_entity_t>& readers, const std::vector<dds_entity_t>& writers) {
  Info info;
  using Gid = decltype(info.gid);
  info.gid = gid_of<Gid>(participant);
  NodeInfo node{space, name, {}, {}};
  for (const dds_entity_t one : readers) node.reader_gid_seq.push_back(gid_of<Gid>(one));
  for (const dds_entity_t one : writers) node.writer_gid_seq.push_back(gid_of<Gid>(one));
  info.node_entities_info_seq.push_back(std::move(node));
  return info;
}

}  // namespace

void Node::announce() {
  std::vector<dds_entity_t> readers, writers;
  if (reader_) readers.push_back(reader_.get());
  for (const dds::Entity& writer : writers_) writers.push_back(writer.get());
  for (const Service& service : services_) {
    readers.push_back(service.reader.get());
    writers.push_back(service.writer.get());
  }
  if (distro_ == Distro::humble)
    write_as<humble_msg_dds__ParticipantEntitiesInfo_>(
        graph_writer_.get(), info_of<humble::ParticipantEntitiesInfo, humble::NodeEntitiesInfo>(
                                 participant_, space_, name_, readers, writers));
  else
    write_as<rmw_dds_common_msg_dds__ParticipantEntitiesInfo_>(
        graph_writer_.get(),
        info_of<rmw_dds_common::ParticipantEntitiesInfo, rmw_dds_common::NodeEntitiesInfo>(
            participant_, space_, name_, readers, writers));
}

void Node::take_graph() {
  constexpr std::size_t kParticipants = 500, kWriters = 1000;  // of a participant
  dds_sample_info_t info{};
  const auto forget = [&] {  // participants that are gone
    std::vector<dds_instance_handle_t> matched(2 * kParticipants);
    const int count =
        dds_get_matched_publications(graph_reader_.get(), matched.data(), matched.size());
    std::vector<Guid> keys;
    for (int i = 0; i < std::min(count, static_cast<int>(matched.size())); ++i) {
      auto* writer = dds_get_matched_publication_data(graph_reader_.get(),
                                                      matched[static_cast<std::size_t>(i)]);
      if (writer == nullptr) continue;
      Guid& key = keys.emplace_back();
      std::ranges::copy(writer->participant_key.v, key.begin());
      dds_builtintopic_free_endpoint(writer);
    }
    std::erase_if(nodes_,
                  [&](const auto& one) { return std::ranges::count(keys, one.first) == 0; });
  };
  const auto keep = [&](const auto& all) {
    const Guid participant = guid_in(all.gid);
    if (nodes_.size() >= kParticipants) forget();
    if (nodes_.size() >= kParticipants && !nodes_.contains(participant)) return;
    std::map<Guid, std::string>& writers = nodes_[participant];
    writers.clear();
    for (const auto& node : all.node_entities_info_seq) {
      for (const auto& gid : node.writer_gid_seq) {
        if (writers.size() < kWriters) writers[guid_in(gid)] = node.node_name;
      }
    }
  };
  while (true) {
    const std::vector<std::byte> cdr = take_cdr(graph_reader_, info);
    if (cdr.empty()) return;
    if (distro_ == Distro::humble) {
      if (const auto all = from_cdr<humble::ParticipantEntitiesInfo>(cdr)) keep(*all);
    } else if (const auto all = from_cdr<rmw_dds_common::ParticipantEntitiesInfo>(cdr)) {
      keep(*all);
    }
  }
}

std::string Node::node_of(const Guid& writer) const {
  for (const auto& [participant, writers] : nodes_) {
    if (const auto found = writers.find(writer); found != writers.end()) return found->second;
  }
  return "";
}

}  // namespace lss::ros
