#include "idl/topics.h"

#include <ifaddrs.h>
#include <net/if.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "idl/recording_reader.h"

namespace lss::dds {
namespace {

// A finite deadline keeps a topic off shared memory (measured 2026-11, Cyclone 0.10.2). The
// writer's deadline must not be longer than the reader's, so our readers ask for far more than any
// writer offers; a reader with default QoS has no deadline and matches. Nobody listens for misses,
// and a timer every ten seconds per vehicle costs nothing measurable.
constexpr dds_duration_t kOfferedDeadline_ns = DDS_SECS(10);
constexpr dds_duration_t kRequestedDeadline_ns = DDS_SECS(3600);
constexpr dds_duration_t kMaxBlocking_ns = DDS_MSECS(100);

// A RouDi that runs takes a message within a millisecond; a daemon that starts has to hold its
// vehicle soon.
constexpr std::chrono::milliseconds kRoudiAnswers{100};
constexpr int kCommandDepth = 16;
constexpr int kAckDepth = 64;
constexpr int kRecordingDepth = 4096;
constexpr int kDaemonReaderSamples = 256;
constexpr int kTimingDepth = 256;  // readers: a client gets every frame even when it wakes rarely

// User data of our readers and writers: a key without meaning. Nodes of ROS 2 warn of each endpoint
// on their domain whose user data is empty (docs/ros2.md).
constexpr std::string_view kEndpointMark = "lss=1;";

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using Qos = std::unique_ptr<dds_qos_t, QosDeleter>;

bool is_control(Kind kind) { return kind != Kind::timing && kind != Kind::telemetry; }

bool is_reliable(Kind kind) { return is_control(kind) && kind != Kind::heartbeat; }

int depth(Kind kind) {
  switch (kind) {
    case Kind::command:
    case Kind::stop: return kCommandDepth;
    case Kind::command_ack: return kAckDepth;
    case Kind::event: return kEventDepth;
    default: return 1;
  }
}

// QoS common to readers and writers.
Qos common_qos(Kind kind) {
  Qos qos{dds_create_qos()};
  if (is_reliable(kind)) {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_RELIABLE, kMaxBlocking_ns);
  } else {
    dds_qset_reliability(qos.get(), DDS_RELIABILITY_BEST_EFFORT, 0);
  }
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, depth(kind));
  dds_qset_userdata(qos.get(), kEndpointMark.data(), kEndpointMark.size());
  if (kind == Kind::status || kind == Kind::event || kind == Kind::timing_statistics ||
      kind == Kind::parameters || kind == Kind::dictionary) {
    dds_qset_durability(qos.get(), DDS_DURABILITY_TRANSIENT_LOCAL);
    // A late reader gets samples by this history, not by the other one.
    dds_qset_durability_service(qos.get(), 0, DDS_HISTORY_KEEP_LAST,
                                kind == Kind::event ? kEventsKept : depth(kind),
                                DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED, DDS_LENGTH_UNLIMITED);
  } else {
    dds_qset_durability(qos.get(), DDS_DURABILITY_VOLATILE);
  }
  return qos;
}

Qos writer_qos(Kind kind, Transport transport) {
  Qos qos = common_qos(kind);
  if (is_control(kind) || transport == Transport::network) {
    dds_qset_deadline(qos.get(), kOfferedDeadline_ns);
  }
  if (kind == Kind::command || kind == Kind::stop)
    dds_qset_lifespan(qos.get(), kCommandLifespan_ns);
  return qos;
}

Qos reader_qos(Kind kind, Transport transport) {
  Qos qos = common_qos(kind);
  if (is_control(kind)) {
    dds_qset_deadline(qos.get(), kRequestedDeadline_ns);
  } else if (kind == Kind::timing) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kTimingDepth);
  }
  // Not by a deadline: a shared-memory writer offers none and would not match.
  if (!is_control(kind) && transport == Transport::network) {
    dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  }
  return qos;
}

// Keep-all also stays off shared memory, and needs no deadline that a foreign writer had to offer.
// The listener takes every sample at once, so the limit matters only until another thread of
// Cyclone has taken it.
Qos daemon_reader_qos(Kind kind) {
  Qos qos = common_qos(kind);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_ALL, 0);
  dds_qset_resource_limits(qos.get(), kDaemonReaderSamples, DDS_LENGTH_UNLIMITED,
                           kDaemonReaderSamples);
  dds_qset_ignorelocal(qos.get(), DDS_IGNORELOCAL_PARTICIPANT);
  return qos;
}

// A recorder is late at times, so samples are kept, but up to a limit.
Qos recording_reader_qos(Kind kind) {
  Qos qos = common_qos(kind);
  dds_qset_history(qos.get(), DDS_HISTORY_KEEP_LAST, kRecordingDepth);
  return qos;
}

std::string configuration(const ParticipantParameters& parameters, bool shared_memory,
                          const std::vector<std::string>& missing) {
  const char* uri = std::getenv("CYCLONEDDS_URI");
  const std::string user = uri != nullptr ? uri : "";
  std::vector<std::string> names = parameters.interfaces;
  std::erase_if(names, [&](const std::string& name) { return std::ranges::count(missing, name); });
  if (names.empty() && !missing.empty()) names = {"lo"};
  std::string interfaces;
  for (const std::string& name : names) {
    if (user.find("name=\"" + name + "\"") != user.npos) continue;  // Cyclone takes none twice
    interfaces += "<NetworkInterface name=\"" + name + "\"" +
                  (name == "lo" ? " multicast=\"true\"" : "") + "/>";
  }
  const std::string memory = std::string("<SharedMemory><Enable>") +
                             (shared_memory ? "true" : "false") +
                             "</Enable><LogLevel>warn</LogLevel></SharedMemory>";
  std::string text = memory;
  if (!interfaces.empty())
    text = "<General><Interfaces>" + interfaces + "</Interfaces></General>" + memory;
  if (parameters.short_lived) {
    text +=
        "<Internal><HeartbeatInterval min=\"2 ms\" minsched=\"2 ms\" max=\"8 s\">4 ms"
        "</HeartbeatInterval></Internal>";
  }
  if (!user.empty()) {
    text += "," + user;
    // The user's configuration may ask for shared memory too; without RouDi that would abort the
    // process.
    if (!shared_memory) text += "," + memory;
  }
  return text;
}

constexpr std::string_view kNotPermitted =
    ": the permissions of the enclave do not allow it; lss-cli keystore list shows its role, "
    "docs/security.md what each may";

std::string failure(const std::string& what, dds_return_t code) {
  if (code == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY)
    return "cannot create " + what + std::string(kNotPermitted);
  return "cannot create " + what + ": " + dds_strretcode(code);
}

// When Cyclone takes no domain with these parameters; it logs details on stderr.
std::string domain_advice(const ParticipantParameters& parameters) {
  std::string missing;
  for (const std::string& name : missing_interfaces(parameters.interfaces)) missing += " " + name;
  if (!missing.empty() && !parameters.without_missing)
    return "bring up" + missing + ", or name other interfaces, of: ip -brief -4 address";
  const char* uri = std::getenv("CYCLONEDDS_URI");
  if (uri != nullptr && *uri != '\0')
    return "correct or unset CYCLONEDDS_URI: it has an error, or names an interface that is not up";
  return "bring up the loopback interface: ip link set lo up";
}

// Writers and readers keep the topic alive, so our own handle of it can be deleted at once.
Result<Entity> create_topic(dds_entity_t participant, const Topic& topic) {
  const dds_entity_t handle =
      dds_create_topic(participant, topic.descriptor, topic.name.c_str(), nullptr, nullptr);
  if (handle < 0) return tl::unexpected(failure("DDS topic " + topic.name, handle));
  return Entity(handle);
}

// vehicle_id is the first member of every type. Cyclone calls this before it keeps a sample.
bool is_for(const void* sample, void* vehicle_id) {
  char text[sizeof lss_Command::vehicle_id];
  std::memcpy(text, sample, sizeof text);
  const std::string_view id(text, ::strnlen(text, sizeof text));
  return id == *static_cast<const std::string*>(vehicle_id) || id == kEveryVehicle;
}

Result<Entity> create_reader_with(const Qos& qos, dds_entity_t participant, const Topic& topic,
                                  const dds_listener_t* listener,
                                  const std::string* vehicle_id = nullptr) {
  const Result<Entity> type = create_topic(participant, topic);
  if (!type) return tl::unexpected(type.error());
  if (vehicle_id != nullptr) {
    dds_topic_filter filter{};
    filter.mode = DDS_TOPIC_FILTER_SAMPLE_ARG;
    filter.f.sample_arg = is_for;
    filter.arg = const_cast<std::string*>(vehicle_id);  // Cyclone passes it on as it is
    if (const dds_return_t set = dds_set_topic_filter_extended(type->get(), &filter); set < 0)
      return tl::unexpected(failure("filter of DDS topic " + topic.name, set));
  }
  const dds_entity_t handle = dds_create_reader(participant, type->get(), qos.get(), listener);
  if (handle < 0) return tl::unexpected(failure("DDS reader of " + topic.name, handle));
  return Entity(handle);
}

}  // namespace

Refusal refusal_of(std::string error) {
  const bool role = error.ends_with(kNotPermitted);
  return {std::move(error), role ? Cure::change : Cure::unknown};
}

std::vector<std::string> missing_interfaces(const std::vector<std::string>& names) {
  ifaddrs* all = nullptr;
  if (::getifaddrs(&all) != 0) return names;
  const std::unique_ptr<ifaddrs, void (*)(ifaddrs*)> owner(all, ::freeifaddrs);
  std::vector<std::string> missing = names;
  for (const ifaddrs* one = all; one != nullptr; one = one->ifa_next) {
    const bool usable = one->ifa_addr != nullptr && one->ifa_addr->sa_family == AF_INET &&
                        (one->ifa_flags & IFF_UP) != 0;
    if (usable) std::erase(missing, one->ifa_name);
  }
  return missing;
}

tl::expected<Participant, Refusal> Participant::create(const ParticipantParameters& parameters) {
  const auto refuse = [](std::string why, Cure cure) {
    return tl::unexpected(Refusal{std::move(why), cure});
  };
  if (parameters.domain < 0 || parameters.domain > 230) {
    return refuse("DDS domain " + std::to_string(parameters.domain) +
                      " is out of range: choose one of 0 to 230",
                  Cure::change);
  }
  Participant result;
  bool clock_may_cure = false;
  const auto domain = static_cast<dds_domainid_t>(parameters.domain);
  if (!parameters.enclave.empty()) {
    auto enclave = read_enclave(parameters.enclave, parameters.clock_slack, &clock_may_cure);
    if (!enclave) return refuse(enclave.error(), clock_may_cure ? Cure::time : Cure::change);
    result.enclave_ = std::move(*enclave);
  }
  if (parameters.shared_memory && !result.enclave_) result.roudi_ = find_roudi();
  // It may have ended meanwhile, too.
  if (result.roudi_ && (!roudi_answers(kRoudiAnswers) || find_roudi() != result.roudi_)) {
    result.roudi_.reset();
    result.roudi_hangs_ = true;
  }
  if (parameters.without_missing) result.missing_ = missing_interfaces(parameters.interfaces);
  const dds_entity_t handle = dds_create_domain(
      domain, configuration(parameters, result.roudi_.has_value(), result.missing_).c_str());
  if (handle > 0) {
    result.domain_ = Entity(handle);
  } else if (handle != DDS_RETCODE_PRECONDITION_NOT_MET) {  // this one: it stands already
    return refuse(failure("DDS domain", handle) + "; " + domain_advice(parameters), Cure::time);
  }
  const Qos qos{dds_create_qos()};
  if (parameters.daemon) dds_qset_userdata(qos.get(), kDaemonMark.data(), kDaemonMark.size());
  if (result.enclave_) {
    if (auto used = use_enclave(qos.get(), *result.enclave_); !used)
      return refuse(used.error(), Cure::change);
  }
  const dds_entity_t participant = dds_create_participant(domain, qos.get(), nullptr);
  // Permissions have a beginning, too.
  const bool refused = participant == DDS_RETCODE_NOT_ALLOWED_BY_SECURITY ||
                       (result.enclave_ && participant == DDS_RETCODE_ERROR);
  if (refused)
    return refuse("the plugins of DDS Security refuse the enclave " + parameters.enclave.string() +
                      ": take its files from the keystore again",
                  clock_may_cure ? Cure::time : Cure::change);
  if (participant < 0) return refuse(failure("DDS participant", participant), Cure::unknown);
  result.participant_ = Entity(participant);
  return result;
}

std::optional<Guid> owner_of(dds_entity_t reader, dds_instance_handle_t writer) {
  dds_builtintopic_endpoint_t* endpoint = dds_get_matched_publication_data(reader, writer);
  if (endpoint == nullptr) return std::nullopt;
  const Guid guid = std::to_array(endpoint->participant_key.v);
  dds_builtintopic_free_endpoint(endpoint);
  return guid;
}

// Of a writer that the reader is, or was, matched with.
std::optional<Guid> Participant::remembered_owner(dds_entity_t reader,
                                                  dds_instance_handle_t writer) const {
  constexpr std::size_t kMost = 4096;
  {
    const std::lock_guard lock(writers_->mutex);
    if (const auto known = writers_->owners.find(writer); known != writers_->owners.end())
      return known->second;
  }
  const std::optional<Guid> guid = owner_of(reader, writer);
  if (!guid) return std::nullopt;
  const std::lock_guard lock(writers_->mutex);
  if (writers_->owners.size() >= kMost) writers_->owners.clear();
  writers_->owners.emplace(writer, *guid);
  return guid;
}

bool Participant::is_by(std::initializer_list<std::string_view> names, dds_entity_t reader,
                        const dds_sample_info_t& info) const {
  if (!enclave_) return true;
  const std::optional<Guid> owner = remembered_owner(reader, info.publication_handle);
  return owner && std::ranges::any_of(
                      names, [&](std::string_view name) { return is_name_of(name, *owner); });
}

bool Participant::is_by_vehicle(std::string_view vehicle_id, dds_entity_t reader,
                                const dds_sample_info_t& info) const {
  return !enclave_ || is_by({vehicle_id, "/" + std::string(vehicle_id)}, reader, info);
}

Topic common_topic(Kind kind) {
  switch (kind) {
    case Kind::command: return {kind, "lss/command", &lss_Command_desc};
    case Kind::stop: return {kind, "lss/stop", &lss_Command_desc};
    case Kind::command_ack: return {kind, "lss/command_ack", &lss_CommandAck_desc};
    case Kind::heartbeat: return {kind, "lss/heartbeat", &lss_Heartbeat_desc};
    case Kind::status: return {kind, "lss/status", &lss_Status_desc};
    case Kind::event: return {kind, "lss/event", &lss_Event_desc};
    case Kind::timing_statistics:
      return {kind, "lss/timing_statistics", &lss_TimingStatistics_desc};
    case Kind::parameters: return {kind, "lss/parameters", &lss_Parameters_desc};
    case Kind::dictionary: return {kind, "lss/dictionary", &lss_Dictionary_desc};
    case Kind::timing: return {kind, "lss/timing", &lss_Timing_desc};
    case Kind::telemetry: break;  // each vehicle has its own
  }
  return {kind, "", nullptr};
}

Topic telemetry_topic(std::string_view vehicle, const dds_topic_descriptor_t* descriptor) {
  return {Kind::telemetry, "lss/telemetry/" + std::string(vehicle), descriptor};
}

Result<Entity> create_writer(dds_entity_t participant, const Topic& topic, Transport transport) {
  const Result<Entity> type = create_topic(participant, topic);
  if (!type) return tl::unexpected(type.error());
  const Qos qos = writer_qos(topic.kind, transport);
  const dds_entity_t handle = dds_create_writer(participant, type->get(), qos.get(), nullptr);
  if (handle < 0) return tl::unexpected(failure("DDS writer of " + topic.name, handle));
  return Entity(handle);
}

Result<Entity> create_reader(dds_entity_t participant, const Topic& topic, Transport transport,
                             const dds_listener_t* listener) {
  return create_reader_with(reader_qos(topic.kind, transport), participant, topic, listener);
}

Result<Entity> create_daemon_reader(dds_entity_t participant, const Topic& topic,
                                    const std::string& vehicle_id, const dds_listener_t* listener) {
  return create_reader_with(daemon_reader_qos(topic.kind), participant, topic, listener,
                            &vehicle_id);
}

Result<Entity> create_recording_reader(dds_entity_t participant, const Topic& topic,
                                       const dds_listener_t* listener) {
  return create_reader_with(recording_reader_qos(topic.kind), participant, topic, listener);
}

}  // namespace lss::dds

#if defined(__SANITIZE_THREAD__)
// The thread sanitizer does not see the atomics inside these libraries, which are not instrumented,
// and reports what they order as races. It does see their mutexes, so data that passes through them
// to another thread is still checked.
extern "C" const char* __tsan_default_suppressions() {
  return "race:libddsc.so\nrace:libiceoryx_\n";
}
#endif
