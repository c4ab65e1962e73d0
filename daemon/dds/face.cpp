#include "daemon/dds/face.h"

#include <algorithm>
#include <array>
#include <mutex>
#include <utility>

#include "daemon/core/clock.h"
#include "daemon/dds/convert.h"
#include "daemon/dds/telemetry_plane.h"
#include "daemon/dds/telemetry_topic.h"
#include "idl/topics.h"

namespace lss {

// The order of the members is the order of construction, and the reverse one that of the end:
// readers, and with them the calls of the sink, go first, the participant last.
struct Face::Impl {
  Impl(const FaceParameters& p, RequestSink s, dds::Participant domain_participant,
       const TelemetryTopic& topic)
      : parameters(p),
        same_clock(p.interfaces == std::vector<std::string>{"lo"}),
        sink(std::move(s)),
        participant(std::move(domain_participant)),
        plane(participant, topic, p.vehicle_id, p.shared_memory) {}

  dds::Result<void> open_writers();
  dds::Result<void> open_readers();
  template <class Sample>
  void take(dds_entity_t reader);
  bool is_ours(const lss_Command& command) const { return is_our_id(command.vehicle_id); }
  // Another daemon of our name is nobody's sign of life.
  bool is_ours(const lss_Heartbeat& beat) const {
    return is_our_id(beat.vehicle_id) && dds::read_text(beat.source) != dds::kDaemonSource;
  }
  bool is_our_id(const char (&id)[16]) const { return dds::read_text(id) == parameters.vehicle_id; }
  bool is_stale(const Request& request, dds_time_t sent_utc_ns) const;

  const FaceParameters parameters;
  const bool same_clock;  // who writes to us is on this machine
  const RequestSink sink;
  std::mutex sink_mutex;
  std::uint64_t events = 0;
  std::uint64_t heartbeats = 0;

  dds::Participant participant;
  dds::TelemetryPlane plane;
  dds::Entity ack_writer, event_writer, status_writer, statistics_writer, parameter_writer,
      heartbeat_writer;
  dds::Entity command_reader, heartbeat_reader;
};

// Lifespan counts from the arrival at the reader (Cyclone 0.10.2), so commands that waited in the
// socket while the process stood still would be obeyed late. An emergency stop is good at any age.
bool Face::Impl::is_stale(const Request& request, dds_time_t sent_utc_ns) const {
  return same_clock && request.kind != static_cast<std::uint16_t>(CommandKind::emergency_stop) &&
         utc_ns() - sent_utc_ns > dds::kCommandLifespan_ns;
}

template <class Sample>
void Face::Impl::take(dds_entity_t reader) {
  constexpr std::size_t kBatch = 8;
  std::array<Sample, kBatch> samples;
  std::array<void*, kBatch> pointers;
  std::array<dds_sample_info_t, kBatch> infos;
  std::transform(samples.begin(), samples.end(), pointers.begin(), [](Sample& s) { return &s; });
  dds_return_t count = 0;
  do {
    count = dds_take(reader, pointers.data(), infos.data(), kBatch, kBatch);
    for (std::size_t i = 0; count > 0 && i < static_cast<std::size_t>(count); ++i) {
      if (!infos[i].valid_data || !is_ours(samples[i])) continue;
      const Request request = dds::to_request(samples[i], now_ns());
      if (!is_stale(request, infos[i].source_timestamp)) sink(request);
    }
  } while (count == kBatch);
}

dds::Result<void> Face::Impl::open_writers() {
  if (auto opened = plane.open(); !opened) return opened;
  for (const auto& [kind, writer] : {std::pair{dds::Kind::command_ack, &ack_writer},
                                     {dds::Kind::event, &event_writer},
                                     {dds::Kind::status, &status_writer},
                                     {dds::Kind::timing_statistics, &statistics_writer},
                                     {dds::Kind::parameters, &parameter_writer},
                                     {dds::Kind::heartbeat, &heartbeat_writer}}) {
    auto created = dds::create_writer(participant.get(), dds::common_topic(kind));
    if (!created) return tl::unexpected(created.error());
    *writer = std::move(*created);
  }
  return {};
}

// Served in the listener: handing over to a thread of our own costs another 24 us (measured
// 2026-11). The mutex is there because Cyclone may call for the two readers from different threads;
// taking inside it keeps the order of what one reader gets.
dds::Result<void> Face::Impl::open_readers() {
  struct ListenerDeleter {
    void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
  };
  const std::unique_ptr<dds_listener_t, ListenerDeleter> listener{dds_create_listener(this)};
  const auto open = [&](dds::Kind kind, dds::Entity& reader,
                        dds_on_data_available_fn on_data) -> dds::Result<void> {
    dds_lset_data_available(listener.get(), on_data);
    auto created =
        dds::create_daemon_reader(participant.get(), dds::common_topic(kind), listener.get());
    if (!created) return tl::unexpected(created.error());
    reader = std::move(*created);
    return {};
  };
  if (auto opened = open(dds::Kind::heartbeat, heartbeat_reader,
                         [](dds_entity_t reader, void* impl) {
                           auto& self = *static_cast<Impl*>(impl);
                           const std::lock_guard lock(self.sink_mutex);
                           self.take<lss_Heartbeat>(reader);
                         });
      !opened) {
    return opened;
  }
  return open(dds::Kind::command, command_reader, [](dds_entity_t reader, void* impl) {
    auto& self = *static_cast<Impl*>(impl);
    const std::lock_guard lock(self.sink_mutex);
    self.take<lss_Command>(reader);
  });
}

tl::expected<std::unique_ptr<Face>, std::string> Face::create(const FaceParameters& parameters,
                                                              RequestSink sink) {
  if (parameters.vehicle_id.empty() ||
      parameters.vehicle_id.size() >= sizeof(lss_Command::vehicle_id)) {
    return tl::unexpected("vehicle_id \"" + parameters.vehicle_id +
                          "\": give it 1 to 15 characters");
  }
  const TelemetryTopic* topic = find_telemetry_topic(parameters.vehicle);
  if (topic == nullptr) {
    return tl::unexpected("vehicle \"" + parameters.vehicle +
                          "\" is not part of this build: build it with -DLSS_VEHICLES");
  }
  auto participant = dds::Participant::create(
      {parameters.domain, parameters.interfaces, parameters.shared_memory});
  if (!participant) return tl::unexpected(participant.error());
  auto impl = std::make_unique<Impl>(parameters, std::move(sink), std::move(*participant), *topic);
  if (auto opened = impl->open_writers(); !opened) return tl::unexpected(opened.error());
  if (auto opened = impl->open_readers(); !opened) return tl::unexpected(opened.error());
  return std::unique_ptr<Face>(new Face(std::move(impl)));
}

Face::Face(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Face::~Face() = default;

void Face::acknowledge(const Ack& ack) {
  const lss_CommandAck sample = dds::to_dds(
      ack, impl_->parameters.vehicle_id, {impl_->parameters.modules, impl_->parameters.tunables});
  dds_write(impl_->ack_writer.get(), &sample);
}

void Face::event(const EventRecord& record, std::string_view text) {
  const lss_Event sample = dds::to_dds(record, text, impl_->parameters.vehicle_id, ++impl_->events);
  dds_write(impl_->event_writer.get(), &sample);
}

void Face::status(const StatusReport& report) {
  lss_Status sample = dds::to_dds(report, impl_->parameters.vehicle_id);
  dds::copy_text(impl_->parameters.vehicle, sample.vehicle);
  dds::copy_text(impl_->parameters.version, sample.version);
  sample.events = impl_->events;
  sample.telemetry_dropped += impl_->plane.dropped();
  sample.shared_memory = static_cast<lss_SharedMemory>(impl_->plane.state());
  dds::copy_text(impl_->plane.text(), sample.shared_memory_text);
  dds_write(impl_->status_writer.get(), &sample);
}

void Face::timing(const TimingPoints& points) { impl_->plane.timing(points, now_ns()); }

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
  sample.state = static_cast<lss_State>(state);
  dds_write(impl_->heartbeat_writer.get(), &sample);
}

void Face::telemetry(const void* vehicle_telemetry) {
  impl_->plane.telemetry(vehicle_telemetry, now_ns());
}

bool Face::watch_shared_memory() { return impl_->plane.watch(now_ns()); }

SharedMemory Face::shared_memory() const { return impl_->plane.state(); }

bool Face::shared_memory_could_return() const { return impl_->plane.could_return(); }

}  // namespace lss
