#include "daemon/publish/face.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <map>
#include <mutex>
#include <optional>
#include <utility>

#include "daemon/cycle/common_commands.h"
#include "daemon/publish/convert.h"
#include "daemon/publish/instance.h"
#include "daemon/publish/telemetry_plane.h"
#include "daemon/publish/telemetry_topic.h"
#include "daemon/runtime/clock.h"
#include "idl/other_daemons.h"
#include "idl/topics.h"

namespace lss {

// Members are destroyed in reverse order: first the readers, and with them the calls of the sink,
// last the participant.
struct Face::Impl {
  Impl(const FaceParameters& p, RequestSink s, dds::Participant domain_participant,
       const TelemetryTopic& topic)
      : parameters(p),
        same_clock(p.interfaces == std::vector<std::string>{"lo"}),
        sink(std::move(s)),
        participant(std::move(domain_participant)),
        plane(participant, topic, p.vehicle_id, p.shared_memory),
        others(participant) {}

  dds::Result<void> open_writers();
  dds::Result<void> open_readers();
  void say_dictionary();
  template <class Sample>
  void take(dds_entity_t reader);
  std::optional<Request> request_of(const lss_Command& command, dds_time_t sent_utc_ns) const;
  std::optional<Request> request_of(const lss_Heartbeat& beat, dds_time_t sent_utc_ns) const;
  bool may(const lss_Command& command, dds_entity_t reader, const dds_sample_info_t& info) const;
  bool may(const lss_Heartbeat& beat, dds_entity_t reader, const dds_sample_info_t& info) const;

  const FaceParameters parameters;
  const bool same_clock;  // writers are on this machine
  const RequestSink sink;
  std::mutex sink_mutex;
  std::uint64_t events = 0;
  std::map<std::pair<std::uint16_t, std::uint16_t>, std::uint64_t> events_of;  // id and subject
  std::uint64_t heartbeats = 0;

  const lss_Instance instance = dds::this_instance();
  dds::Participant participant;
  dds::TelemetryPlane plane;
  dds::OtherDaemons others;
  dds::Entity ack_writer, event_writer, status_writer, statistics_writer, parameter_writer,
      heartbeat_writer, dictionary_writer;
  dds::Entity command_reader, heartbeat_reader;
  dds::Entity stop_reader;  // with DDS Security
  std::atomic<std::uint64_t> foreign{0};
};

namespace {

// In simulated time the sender waits for it.
void took(const lss_Command& command) {
  lockstep::took_command(dds::read_text(command.source).value_or(""), command.seq);
}
void took(const lss_Heartbeat& beat) {
  lockstep::took_heartbeat(dds::read_text(beat.source).value_or(""), beat.counter);
}

}  // namespace

// Lifespan counts from the arrival at the reader (Cyclone 0.10.2), so commands that waited in the
// socket while the process stood still would be obeyed late. An emergency stop is valid at any age,
// and is the only command that may address every vehicle.
std::optional<Request> Face::Impl::request_of(const lss_Command& command,
                                              dds_time_t sent_utc_ns) const {
  const Request request = dds::to_request(command, now_ns());
  if (is_emergency_stop(request)) return request;
  const auto id = dds::read_text(command.vehicle_id);
  // In simulated time nothing is late: the sender holds time until it was taken.
  const bool stale =
      same_clock && !lockstep::on() && utc_ns() - sent_utc_ns > dds::kCommandLifespan_ns;
  if (id != parameters.vehicle_id || stale) return {};
  return request;
}

// Heartbeats are valid at arrival: they only say that a client is present now.
std::optional<Request> Face::Impl::request_of(const lss_Heartbeat& beat, dds_time_t) const {
  if (dds::read_text(beat.vehicle_id) != parameters.vehicle_id) return {};
  // In simulated time a client repeats what was lost, and the result is that of one.
  if (lockstep::has_heartbeat(dds::read_text(beat.source).value_or(""), beat.counter)) return {};
  Request request = dds::to_request(beat, now_ns());
  if (dds::read_text(beat.source) == dds::kDaemonSource) {
    if (dds::is_same(beat.instance, instance)) return {};
    request.flags = kFlagAnotherDaemon;
  }
  return request;
}

// An emergency stop is anyone's who may write it. On lss/stop only that which anyone may.
bool Face::Impl::may(const lss_Command& command, dds_entity_t reader,
                     const dds_sample_info_t& info) const {
  if (!participant.enclave() || command.kind == kind_of(CommandKind::emergency_stop)) return true;
  if (reader == stop_reader.get()) {
    const CommandInfo* kind = find_command(parameters.commands, command.kind);
    if (kind == nullptr || kind->access != Access::anyone) return false;
  }
  const std::string_view source = dds::read_text(command.source).value_or("");
  return participant.is_by({dds::name_of_source(source)}, reader, info);
}

bool Face::Impl::may(const lss_Heartbeat& beat, dds_entity_t reader,
                     const dds_sample_info_t& info) const {
  const std::string_view source = dds::read_text(beat.source).value_or("");
  if (source == dds::kDaemonSource)
    return participant.is_by_vehicle(parameters.vehicle_id, reader, info);
  return participant.is_by({dds::name_of_source(source)}, reader, info);
}

// Emergency stops first; the others in the order of `arrival_ns`.
template <class Sample>
void Face::Impl::take(dds_entity_t reader) {
  constexpr std::size_t kBatch = 8;
  std::array<Sample, kBatch> samples;
  std::array<void*, kBatch> pointers;
  std::array<dds_sample_info_t, kBatch> infos;
  std::array<std::optional<Request>, kBatch> requests;
  std::transform(samples.begin(), samples.end(), pointers.begin(), [](Sample& s) { return &s; });
  for (std::size_t count = kBatch; count == kBatch;) {
    const std::lock_guard lock(sink_mutex);
    const dds_return_t taken = dds_take(reader, pointers.data(), infos.data(), kBatch, kBatch);
    count = taken > 0 ? static_cast<std::size_t>(taken) : 0;
    for (std::size_t i = 0; i < count; ++i) {
      requests[i].reset();
      if (!infos[i].valid_data) continue;
      if (may(samples[i], reader, infos[i])) {
        requests[i] = request_of(samples[i], infos[i].source_timestamp);
      } else {
        foreign.fetch_add(1, std::memory_order_relaxed);
      }
    }
    for (const bool stops : {true, false}) {
      for (std::size_t i = 0; i < count; ++i) {
        if (requests[i] && is_emergency_stop(*requests[i]) == stops)
          sink(*requests[i], infos[i].publication_handle);
      }
    }
    for (std::size_t i = 0; i < count && lockstep::on(); ++i)
      if (infos[i].valid_data) took(samples[i]);
  }
}

dds::Result<void> Face::Impl::open_writers() {
  if (auto opened = plane.open(); !opened) return opened;
  for (const auto& [kind, writer] : {std::pair{dds::Kind::command_ack, &ack_writer},
                                     {dds::Kind::event, &event_writer},
                                     {dds::Kind::status, &status_writer},
                                     {dds::Kind::timing_statistics, &statistics_writer},
                                     {dds::Kind::parameters, &parameter_writer},
                                     {dds::Kind::heartbeat, &heartbeat_writer},
                                     {dds::Kind::dictionary, &dictionary_writer}}) {
    auto created = dds::create_writer(participant.get(), dds::common_topic(kind));
    if (!created) return tl::unexpected(created.error());
    *writer = std::move(*created);
  }
  return {};
}

void Face::Impl::say_dictionary() {
  if (parameters.dictionary.empty()) return;
  lss_Dictionary sample{};
  dds::copy_text(parameters.vehicle_id, sample.vehicle_id);
  std::string text = parameters.dictionary;  // Cyclone's type is not const
  sample.json = text.data();
  dds_write(dictionary_writer.get(), &sample);
}

// Served in the listener: a hand-over to another thread costs another 24 us (measured 2026-11). The
// mutex is needed because Cyclone may call for the two readers from different threads; taking
// inside it keeps the order of one reader's samples. It is locked for a few samples at a time.
dds::Result<void> Face::Impl::open_readers() {
  struct ListenerDeleter {
    void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
  };
  const std::unique_ptr<dds_listener_t, ListenerDeleter> listener{dds_create_listener(this)};
  const auto open = [&](dds::Kind kind, dds::Entity& reader,
                        dds_on_data_available_fn on_data) -> dds::Result<void> {
    dds_lset_data_available(listener.get(), on_data);
    auto created = dds::create_daemon_reader(participant.get(), dds::common_topic(kind),
                                             parameters.vehicle_id, listener.get());
    if (!created) return tl::unexpected(created.error());
    reader = std::move(*created);
    return {};
  };
  if (auto opened = open(dds::Kind::heartbeat, heartbeat_reader,
                         [](dds_entity_t reader, void* impl) {
                           static_cast<Impl*>(impl)->take<lss_Heartbeat>(reader);
                         });
      !opened) {
    return opened;
  }
  const auto on_command = [](dds_entity_t reader, void* impl) {
    static_cast<Impl*>(impl)->take<lss_Command>(reader);
  };
  if (participant.enclave()) {
    if (auto opened = open(dds::Kind::stop, stop_reader, on_command); !opened) return opened;
  }
  return open(dds::Kind::command, command_reader, on_command);
}

tl::expected<std::unique_ptr<Face>, Refusal> Face::create(const FaceParameters& parameters,
                                                          RequestSink sink) {
  const auto wrong = [](const std::string& why) {
    return tl::unexpected(Refusal{why, Cure::change});
  };
  if (parameters.vehicle_id.empty() ||
      parameters.vehicle_id.size() >= sizeof(lss_Command::vehicle_id)) {
    return wrong("vehicle_id \"" + parameters.vehicle_id + "\": give it 1 to 15 characters");
  }
  const TelemetryTopic* topic = find_telemetry_topic(parameters.vehicle);
  if (topic == nullptr) {
    return wrong("vehicle \"" + parameters.vehicle +
                 "\" is not part of this build: build it with -DLSS_VEHICLES");
  }
  auto participant = dds::Participant::create({.domain = parameters.domain,
                                               .interfaces = parameters.interfaces,
                                               .shared_memory = parameters.shared_memory,
                                               .without_missing = true,
                                               .daemon = true,
                                               .enclave = parameters.enclave,
                                               .clock_slack = parameters.clock_slack});
  if (!participant) return tl::unexpected(participant.error());
  if (const auto& enclave = participant->enclave();
      enclave && !dds::is_of_vehicle(enclave->name, parameters.vehicle_id)) {
    return wrong("the enclave " + parameters.enclave.string() + " is of '" + enclave->name +
                 "', not of " + parameters.vehicle_id +
                 ", so no client would believe this vehicle: take one of its vehicle_id (lss-cli "
                 "keystore add KEYSTORE " +
                 parameters.vehicle_id + " --role vehicle)");
  }
  auto impl = std::make_unique<Impl>(parameters, std::move(sink), std::move(*participant), *topic);
  if (auto opened = impl->open_writers(); !opened)
    return tl::unexpected(dds::refusal_of(opened.error()));
  impl->say_dictionary();
  if (auto opened = impl->open_readers(); !opened)
    return tl::unexpected(dds::refusal_of(opened.error()));
  return std::unique_ptr<Face>(new Face(std::move(impl)));
}

Face::Face(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Face::~Face() = default;

void Face::acknowledge(const Ack& ack, std::string_view name) {
  const lss_CommandAck sample = dds::to_dds(
      ack, impl_->parameters.vehicle_id,
      {impl_->parameters.modules, impl_->parameters.tunables, impl_->parameters.commands, name});
  dds_write(impl_->ack_writer.get(), &sample);
  if (lockstep::on()) lockstep::answered(dds::read_text(sample.source).value_or(""), sample.seq);
}

void Face::event(const EventRecord& record, std::string_view text) {
  lss_Event sample = dds::to_dds(record, text, impl_->parameters.vehicle_id, ++impl_->events);
  sample.number = ++impl_->events_of[{record.id, record.subject}];
  dds_write(impl_->event_writer.get(), &sample);
}

void Face::status(const StatusReport& report) {
  lss_Status sample = dds::to_dds(report, impl_->parameters.vehicle_id);
  dds::copy_text(impl_->parameters.vehicle, sample.vehicle);
  dds::copy_text(impl_->parameters.version, sample.version);
  sample.instance = impl_->instance;
  sample.events = impl_->events;
  sample.telemetry_dropped += impl_->plane.dropped();
  sample.shared_memory = static_cast<lss_SharedMemory>(impl_->plane.state());
  dds::copy_text(impl_->plane.text(), sample.shared_memory_text);
  dds_write(impl_->status_writer.get(), &sample);
  if (lockstep::on()) lockstep::said_status(sample.time_ns);
}

void Face::timing(const TimingPoints& points) { impl_->plane.timing(points); }

void Face::timing(const TimingStatistics& statistics) {
  lss_TimingStatistics sample{};
  dds::to_dds(statistics, impl_->parameters.vehicle_id, sample);
  dds_write(impl_->statistics_writer.get(), &sample);
}

void Face::parameters(const ParameterReport& report) {
  lss_Parameters sample{};
  dds::to_dds(report, impl_->parameters.vehicle_id, sample);
  dds_write(impl_->parameter_writer.get(), &sample);
}

void Face::heartbeat(State state) {
  lss_Heartbeat sample{};
  dds::copy_text(impl_->parameters.vehicle_id, sample.vehicle_id);
  dds::copy_text(dds::kDaemonSource, sample.source);
  sample.counter = ++impl_->heartbeats;
  sample.instance = impl_->instance;
  sample.state = static_cast<lss_State>(state);
  dds_write(impl_->heartbeat_writer.get(), &sample);
}

void Face::telemetry(const void* vehicle_telemetry) { impl_->plane.telemetry(vehicle_telemetry); }

bool Face::other_interface() {
  dds_requested_incompatible_qos_status_t status{};
  return dds_get_requested_incompatible_qos_status(impl_->command_reader.get(), &status) ==
             DDS_RETCODE_OK &&
         status.total_count_change > 0 &&
         status.last_policy_id == DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID;
}

std::uint64_t Face::foreign() const { return impl_->foreign.load(std::memory_order_relaxed); }

std::span<const std::string> Face::warnings() const { return impl_->participant.warnings(); }

std::int64_t Face::expires_utc_s() const {
  const std::optional<dds::Enclave>& enclave = impl_->participant.enclave();
  return enclave ? enclave->not_after_utc_s : INT64_MAX;
}

const std::vector<std::string>& Face::missing_interfaces() const {
  return impl_->participant.missing();
}

bool Face::interfaces_could_return() const {
  return dds::missing_interfaces(missing_interfaces()).size() < missing_interfaces().size();
}

void Face::look_for_others() { impl_->others.look(); }

bool Face::watch_shared_memory() { return impl_->plane.watch(); }

SharedMemory Face::shared_memory() const { return impl_->plane.state(); }

bool Face::shared_memory_could_return() { return impl_->plane.could_return(); }

}  // namespace lss
