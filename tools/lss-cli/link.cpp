#include "tools/lss-cli/link.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "tools/lss-cli/failure.h"
#include "tools/lss-cli/names.h"
#include "tools/lss-cli/vehicle.h"

namespace lss::cli {
namespace {

// That there is no second vehicle can only be told by listening for a while.
constexpr double kOthers_s = 0.1;
constexpr double kProbe_s = 0.25;

template <class T>
T checked(dds::Result<T> result) {
  if (!result) throw Failure(ExitCode::internal, result.error());
  return std::move(*result);
}

dds::ParticipantParameters parameters(const Options& options) {
  dds::ParticipantParameters result;
  result.short_lived = true;
  result.domain = options.domain;
  result.shared_memory = options.shared_memory;
  return result;
}

std::string join(const std::vector<std::string>& names) {
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

Link::Link(const Options& options)
    : options_(options), participant_(checked(dds::Participant::create(parameters(options)))) {
  status_reader_ = reader(dds::common_topic(dds::Kind::status));
  ack_reader_ = reader(dds::common_topic(dds::Kind::command_ack));
}

dds::Entity Link::reader(const dds::Topic& topic) {
  return checked(
      dds::create_reader(participant_.get(), topic, dds::Transport::best, waker_.listener()));
}

dds::Entity Link::writer(const dds::Topic& topic) {
  dds::Entity entity = checked(dds::create_writer(participant_.get(), topic));
  dds_set_listener(entity.get(), waker_.listener());
  return entity;
}

template <class Sample>
std::optional<Sample> Link::take(dds_entity_t reader) {
  Sample sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (reader > 0 && dds_take(reader, samples, &info, 1, 1) == 1) {
    if (info.valid_data && text(sample.vehicle_id) == vehicle_id_) return sample;
  }
  return std::nullopt;
}

void Link::take_status() {
  lss_Status sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (dds_take(status_reader_.get(), samples, &info, 1, 1) == 1) {
    const std::string id(text(sample.vehicle_id));
    Seen& seen = seen_[id];
    const bool ours = vehicle_ != nullptr && id == vehicle_id_;
    if (!info.valid_data) {
      seen.alive = info.instance_state == DDS_IST_ALIVE;
      if (ours && !seen.alive) left_ = true;
      continue;
    }
    seen.status = sample;
    seen.alive = true;
    auto* endpoint =
        dds_get_matched_publication_data(status_reader_.get(), info.publication_handle);
    if (endpoint != nullptr) {
      seen.participant = endpoint->participant_key;
      dds_builtintopic_free_endpoint(endpoint);
    }
    if (ours) {
      status_time_ = Clock::now();
      left_ = false;
    }
  }
}

Failure Link::unreachable() const {
  std::vector<std::string> others;
  for (const auto& [id, seen] : seen_) {
    if (seen.alive) others.push_back(id);
  }
  if (!others.empty()) {
    std::string advice = did_you_mean(options_.vehicle_id, others);
    if (advice.empty()) advice = "there are: " + join(others);
    return Failure(ExitCode::unknown_name,
                   fmt::format("there is no vehicle '{}' on DDS domain {}", options_.vehicle_id,
                               options_.domain),
                   advice);
  }
  return Failure(
      ExitCode::unreachable, fmt::format("no vehicle answers on DDS domain {}", options_.domain),
      "check that lssd runs (systemctl status lssd@NAME) and uses the same --domain / LSS_DOMAIN "
      "and network interface");
}

// The vehicles that may be meant, as far as is known by now.
std::vector<std::string> Link::candidates() const {
  std::vector<std::string> ids;
  for (const auto& [id, seen] : seen_) {
    if (seen.alive && (options_.vehicle_id.empty() || id == options_.vehicle_id)) ids.push_back(id);
  }
  return ids;
}

void Link::find_vehicle() {
  const Clock::time_point give_up = Clock::now() + seconds(options_.find_timeout_s());
  Clock::time_point until = give_up;
  while (Clock::now() < until) {
    if (waker_.wait(until).interrupted) throw Interrupted();
    take_status();
    if (candidates().empty()) continue;
    if (!options_.vehicle_id.empty()) break;
    if (until == give_up) until = std::min(give_up, Clock::now() + seconds(kOthers_s));
  }
  const std::vector<std::string> ids = candidates();
  if (ids.empty()) throw unreachable();
  if (ids.size() > 1) {
    throw Failure(ExitCode::usage, "several vehicles are on this domain: " + join(ids),
                  "name one with --vehicle");
  }
  vehicle_id_ = ids.front();
  status_time_ = Clock::now();
  const std::string_view name = text(seen_.at(vehicle_id_).status.vehicle);
  vehicle_ = cli::find_vehicle(name);
  if (vehicle_ == nullptr) {
    throw Failure(ExitCode::unknown_name,
                  fmt::format("{} is of the kind '{}', which this lss-cli was built without",
                              vehicle_id_, name));
  }
}

const lss_Status& Link::status() {
  take_status();
  return seen_.at(vehicle_id_).status;
}

Clock::duration Link::status_age() const { return Clock::now() - status_time_; }

bool Link::daemon_hears(dds_entity_t writer) const {
  std::array<dds_instance_handle_t, 16> readers{};
  const int count = dds_get_matched_subscriptions(writer, readers.data(), readers.size());
  for (int i = 0; i < std::min(count, static_cast<int>(readers.size())); ++i) {
    auto* endpoint =
        dds_get_matched_subscription_data(writer, readers[static_cast<std::size_t>(i)]);
    if (endpoint == nullptr) continue;
    const dds_guid_t& daemon = seen_.at(vehicle_id_).participant;
    const bool is_daemon = std::memcmp(&endpoint->participant_key, &daemon, sizeof daemon) == 0;
    dds_builtintopic_free_endpoint(endpoint);
    if (is_daemon) return true;
  }
  return false;
}

void Link::await_match(dds_entity_t writer, Clock::time_point until) {
  while (!daemon_hears(writer)) {
    if (Clock::now() >= until) {
      throw Failure(ExitCode::unreachable,
                    fmt::format("{} sends status but does not listen to commands", vehicle_id_),
                    "check the log of lssd; is another DDS configuration in CYCLONEDDS_URI?");
    }
    if (waker_.wait(until).interrupted) throw Interrupted();
    take_status();
  }
}

// That we see the daemon's reader does not mean that it sees ours yet, and what was acknowledged
// before is not told again. So ask for nothing (a dry run that anyone may do) until it is answered.
void Link::await_answer(Clock::time_point until) {
  const Invocation probe{
      &find_command(*vehicle_, static_cast<std::uint16_t>(CommandKind::request_data)), {}};
  std::vector<std::uint64_t> asked;
  while (Clock::now() < until) {
    asked.push_back(send(probe, kFlagDryRun));
    const Clock::time_point next = std::min(until, Clock::now() + seconds(kProbe_s));
    while (Clock::now() < next) {
      if (waker_.wait(next).interrupted) throw Interrupted();
      while (const std::optional<lss_CommandAck> ack = next_ack()) {
        if (std::ranges::count(asked, ack->seq) > 0) return;
      }
    }
  }
  throw Failure(ExitCode::unreachable, fmt::format("{} does not answer commands", vehicle_id_),
                "check the log of lssd");
}

void Link::open_writers(const std::string& source) {
  source_ = source;
  command_writer_ = writer(dds::common_topic(dds::Kind::command));
  heartbeat_writer_ = writer(dds::common_topic(dds::Kind::heartbeat));
}

void Link::open_commands(const std::string& source) {
  if (command_writer_) return;
  open_writers(source);
  const Clock::time_point until = Clock::now() + seconds(options_.find_timeout_s());
  await_match(command_writer_.get(), until);
  await_match(heartbeat_writer_.get(), until);
  await_answer(until);
}

void Link::open_emergency(const std::string& source) {
  if (command_writer_) return;
  open_writers(source);
  await_match(command_writer_.get(), Clock::now() + seconds(options_.find_timeout_s()));
}

void Link::open_events() { event_reader_ = reader(dds::common_topic(dds::Kind::event)); }
void Link::open_timing() { timing_reader_ = reader(dds::common_topic(dds::Kind::timing)); }
void Link::open_timing_statistics() {
  statistics_reader_ = reader(dds::common_topic(dds::Kind::timing_statistics));
}
void Link::open_parameters() {
  if (!parameter_reader_) parameter_reader_ = reader(dds::common_topic(dds::Kind::parameters));
}
void Link::open_telemetry() {
  if (telemetry_reader_) return;
  const std::size_t size = vehicle_->telemetry->m_size;
  sample_.resize((size + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
  telemetry_reader_ = reader(dds::telemetry_topic(vehicle_->name, vehicle_->telemetry));
}

std::optional<lss_CommandAck> Link::next_ack() {
  while (std::optional<lss_CommandAck> ack = take<lss_CommandAck>(ack_reader_.get())) {
    if (text(ack->source) == source_) return ack;
  }
  return std::nullopt;
}
std::optional<lss_Event> Link::next_event() { return take<lss_Event>(event_reader_.get()); }
std::optional<lss_Timing> Link::next_timing() { return take<lss_Timing>(timing_reader_.get()); }
std::optional<lss_TimingStatistics> Link::next_timing_statistics() {
  return take<lss_TimingStatistics>(statistics_reader_.get());
}

std::optional<lss_Parameters> Link::next_parameters() {
  return take<lss_Parameters>(parameter_reader_.get());
}

const void* Link::telemetry() {
  if (!telemetry_reader_) return nullptr;
  std::vector<std::max_align_t> buffer(sample_.size());
  void* samples[1] = {buffer.data()};
  dds_sample_info_t info{};
  while (dds_take(telemetry_reader_.get(), samples, &info, 1, 1) == 1) {
    char id[sizeof lss_Status::vehicle_id];  // the key is the first member of every type
    std::memcpy(id, buffer.data(), sizeof id);
    if (!info.valid_data || text(id) != vehicle_id_) continue;
    std::memcpy(sample_.data(), buffer.data(), sample_.size() * sizeof(std::max_align_t));
    ++telemetry_count_;
  }
  return telemetry_count_ == 0 ? nullptr : sample_.data();
}

std::uint64_t Link::send(const Invocation& command, std::uint16_t flags) {
  const lss_Command sample =
      to_dds(command, {vehicle_id_, source_, sequence_.next(), flags, options_.lease_ms});
  const dds_return_t result = dds_write(command_writer_.get(), &sample);
  if (result < 0)
    throw Failure(ExitCode::internal, fmt::format("cannot send: {}", dds_strretcode(result)));
  return sample.seq;
}

void Link::heartbeat() {
  const lss_Heartbeat sample = heartbeat_to_dds(vehicle_id_, source_, ++heartbeats_);
  dds_write(heartbeat_writer_.get(), &sample);
}

}  // namespace lss::cli
