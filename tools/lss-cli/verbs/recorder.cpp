#include "tools/lss-cli/verbs/recorder.h"

#include <dds/ddsi/ddsi_serdata.h>
#include <fmt/format.h>

#include <algorithm>
#include <numeric>

#include "idl/idl_text.h"
#include "idl/recording_reader.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

constexpr double kChunk_s = 0.1;  // a killed recorder loses this much
constexpr double kSync_s = 1;     // a power failure loses this much
constexpr std::size_t kChunkSize = 1024 * 1024;

const recording::Type& find_type(const recording::Types& types, const std::string& name) {
  const recording::Type* type = types.find(name);
  if (type == nullptr) throw Failure(ExitCode::internal, "the IDL does not have " + name);
  return *type;
}

}  // namespace

Recorder::Recorder(const Options& options, const Vehicle& vehicle, std::string vehicle_id,
                   recording::McapWriter& writer, const std::vector<std::string>& topics, bool ros2)
    : participant_(checked(
          dds::Participant::create({.domain = options.domain, .enclave = options.enclave}))),
      vehicle_(vehicle),
      vehicle_id_(std::move(vehicle_id)),
      writer_(writer),
      begun_ns_(dds_time()),
      chunk_ends_(Clock::now() + seconds(kChunk_s)),
      sync_(Clock::now() + seconds(kSync_s)) {
  using enum dds::Kind;
  const auto wanted = [&](const std::string& topic) {
    return topics.empty() || std::ranges::any_of(topics, [&](const std::string& name) {
             return recording::names(name, topic);
           });
  };
  for (const dds::Kind kind :
       {status, event, command, command_ack, parameters, heartbeat, timing_statistics, timing}) {
    const dds::Topic topic = dds::common_topic(kind);
    if (wanted(topic.name)) add(topic, idl_text("lss"));
  }
  if (ros2) open_ros2();
  if (vehicle.telemetry == nullptr) return;
  const dds::Topic topic = dds::telemetry_topic(vehicle.name, vehicle.telemetry);
  if (wanted(topic.name)) add(topic, vehicle.idl);
}

void Recorder::add(const dds::Topic& topic, std::string_view idl) {
  const std::string name = topic.descriptor->m_typename;
  recording::Types types(idl);
  const recording::Type& type = find_type(types, name);
  const std::uint16_t channel =
      writer_.channel(topic.name, {name, "omgidl", std::string(idl)}, "cdr",
                      {{"vehicle", std::string(vehicle_.name)}, {"vehicle_id", vehicle_id_}});
  const auto known = writer_.span(channel).published_ns;
  readers_.push_back(std::unique_ptr<Reader>(new Reader{{topic.name, 0, 0, 0},
                                                        {},
                                                        topic.descriptor->m_size,
                                                        channel,
                                                        known,
                                                        std::move(types),
                                                        recording::Layout(type),
                                                        nullptr,
                                                        {}}));
  Reader& reader = *readers_.back();
  reader.counter = recording::counter_of(reader.layout);
  reader.index = reader.layout.find("index");
  reader.entity =
      checked(dds::create_recording_reader(participant_.get(), topic, waker_.listener()));
}

namespace {

// As rosbag2 has it in the metadata of a channel, since its version 9.
std::string offered_qos(const ros::Qos& qos) {
  constexpr std::int64_t kSecond_ns = 1'000'000'000;
  return fmt::format(
      "- history: keep_last\n  depth: {}\n  reliability: reliable\n  durability: {}\n"
      "  deadline:\n    sec: 0\n    nsec: 0\n  lifespan:\n    sec: {}\n    nsec: {}\n"
      "  liveliness: automatic\n  liveliness_lease_duration:\n    sec: 0\n    nsec: 0\n"
      "  avoid_ros_namespace_conventions: false\n",
      qos.depth, qos.transient_local ? "transient_local" : "volatile", qos.lifespan_ns / kSecond_ns,
      qos.lifespan_ns % kSecond_ns);
}

}  // namespace

void Recorder::open_ros2() {
  converter_.emplace(vehicle_, vehicle_id_, [this](std::size_t index, const ros::Message& message) {
    RosChannel& channel = ros_channels_[index];
    writer_.write(
        {channel.number, ++channel.messages, last_ns_, published_ns_, ros::to_cdr(message)});
  });
  for (const ros::Channel& channel : converter_->channels()) {
    const std::uint16_t number = writer_.channel(
        channel.topic,
        {std::string(channel.type->name), "ros2msg", std::string(channel.type->text)}, "cdr",
        {{"offered_qos_profiles", offered_qos(channel.qos)},
         {"topic_type_hash", "RIHS01_" + std::string(channel.type->hash)}});
    const auto known = static_cast<std::uint32_t>(writer_.span(number).messages);
    ros_channels_.push_back({number, known});
  }
}

void Recorder::convert(const Reader& reader, recording::Bytes data, const Memory& sample) {
  const std::string& type = reader.layout.type().name;
  if (type == "lss::Status") {
    converter_->status(*reinterpret_cast<const lss_Status*>(sample.data()),
                       telemetry_.empty() ? nullptr : telemetry_.data());
  } else if (type == "lss::Event") {
    converter_->event(*reinterpret_cast<const lss_Event*>(sample.data()));
  } else if (reader.source.topic.starts_with("lss/telemetry/")) {
    telemetry_ = sample;
    converter_->telemetry(data);
  }
}

bool Recorder::wait(Clock::time_point until) {
  const Waker::Result woken = waker_.wait(std::min(until, chunk_ends_));
  take();
  return woken.interrupted;
}

void Recorder::take() {
  for (const auto& reader : readers_) take(*reader);
  const Clock::time_point now = Clock::now();
  if (now >= chunk_ends_ || writer_.open_chunk_size() > kChunkSize) {
    writer_.end_chunk();
    chunk_ends_ = now + seconds(kChunk_s);
  }
  if (now >= sync_) {
    writer_.sync();
    sync_ = Clock::now() + seconds(kSync_s);
  }
}

void Recorder::take(Reader& reader) {
  // DDS hands out samples that it stores for late readers grouped by their keys.
  struct Taken {
    dds_sample_info_t info;
    std::vector<std::byte> data;
    Memory sample;
  };
  std::multimap<std::uint64_t, Taken> ordered;
  ddsi_serdata* sample = nullptr;
  dds_sample_info_t info{};
  while (dds_takecdr(reader.entity.get(), &sample, 1, &info, DDS_ANY_STATE) == 1) {
    if (info.valid_data) {
      buffer_.resize(ddsi_serdata_size(sample));
      ddsi_serdata_to_ser(sample, 0, buffer_.size(), buffer_.data());
      if (converter_) {  // all types are of fixed size
        sample_.resize(reader.size / sizeof(std::max_align_t) + 1);
        ddsi_serdata_to_sample(sample, sample_.data(), nullptr, nullptr);
      }
    }
    ddsi_serdata_unref(sample);
    if (info.valid_data && reader.index != nullptr)
      ordered.emplace(reader.layout.json(*reader.index, buffer_).get<std::uint64_t>(),
                      Taken{info, {buffer_.begin(), buffer_.end()}, sample_});
    else if (info.valid_data)
      put(reader, buffer_, sample_, info);
  }
  for (const auto& [index, taken] : ordered) put(reader, taken.data, taken.sample, taken.info);
  dds_sample_lost_status_t lost{};
  if (dds_get_sample_lost_status(reader.entity.get(), &lost) == DDS_RETCODE_OK)
    reader.source.lost = lost.total_count;
}

void Recorder::put(Reader& reader, recording::Bytes data, const Memory& sample,
                   const dds_sample_info_t& info) {
  reader.layout.check(data);
  const recording::Column& key = reader.layout.columns().front();  // vehicle_id, of every type
  if (reader.layout.text(key, data) != vehicle_id_) return;
  // Samples that a topic stores for late readers may be in the continued file already.
  if (info.source_timestamp < begun_ns_ && info.source_timestamp <= reader.known_ns) return;
  std::uint64_t count = reader.source.messages + 1;
  if (reader.counter != nullptr) {
    count = reader.layout.json(*reader.counter, data).get<std::uint64_t>();
    const auto [last, first] = reader.last.try_emplace(info.instance_handle, count);
    if (!first && count > last->second) reader.source.gaps += count - last->second - 1;
    last->second = count;
  }
  if (reader.index != nullptr) count = reader.layout.json(*reader.index, data).get<std::uint64_t>();
  ++reader.source.messages;
  last_ns_ =
      std::max<std::int64_t>(last_ns_, dds_time());  // never backwards, even when the clock is set
  writer_.write(
      {reader.channel, static_cast<std::uint32_t>(count), last_ns_, info.source_timestamp, data});
  if (!converter_) return;
  published_ns_ = info.source_timestamp;
  convert(reader, data, sample);
}

std::vector<Recorder::Source> Recorder::sources() const {
  std::vector<Source> list;
  for (const auto& reader : readers_) list.push_back(reader->source);
  return list;
}

std::uint64_t Recorder::messages() const {
  return std::accumulate(readers_.begin(), readers_.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& r) { return sum + r->source.messages; });
}

std::uint64_t Recorder::lost() const {
  return std::accumulate(readers_.begin(), readers_.end(), std::uint64_t{0},
                         [](std::uint64_t sum, const auto& r) { return sum + r->source.gaps; });
}

}  // namespace lss::cli
