#include "tools/lss-cli/session/link.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>

#include "tools/lss-cli/session/answer.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/names.h"

namespace lss::cli {
namespace {

// Without a named vehicle, the search for others continues this long after the first was found.
constexpr double kOthers_s = 2;
// A daemon sends heartbeats once a second at least. One that is silent for this long does not count
// as a second one of the same name. DDS still reports a killed daemon for 10 s.
constexpr double kSpeaks_s = 2.5;
constexpr double kProbe_s = 0.25;
constexpr double kDictionary_s = 5;  // a large sample, on a busy machine
// In simulated time, of wall time: until a message was taken, and until a heartbeat is sent again.
// Heartbeats have no reliability, and the first is lost where the daemon does not know the writer
// yet.
constexpr TimeNs kTaken = 10 * kSecond, kAgain = 100 * kMillisecond;

Failure not_taken() {
  return Failure(ExitCode::unreachable, "the daemon does not take what was sent",
                 "is it lssd --lockstep of this simulation?");
}

}  // namespace

Link::Link(const Options& options, std::shared_ptr<const dds::Participant> participant)
    : options_(options),
      participant_(participant
                       ? std::move(participant)
                       : std::make_shared<const dds::Participant>(own_participant(options))),
      daemons_(*participant_, waker_.listener()) {
  ack_reader_ = reader(dds::common_topic(dds::Kind::command_ack));
}

dds::Entity Link::reader(const dds::Topic& topic) {
  return checked(
      dds::create_reader(participant_->get(), topic, dds::Transport::best, waker_.listener()));
}

dds::Entity Link::writer(const dds::Topic& topic) {
  dds::Entity entity = checked(dds::create_writer(participant_->get(), topic));
  dds_set_listener(entity.get(), waker_.listener());
  return entity;
}

template <class Sample>
std::optional<Sample> Link::take(dds_entity_t reader) {
  Sample sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (reader > 0 && dds_take(reader, samples, &info, 1, 1) == 1) {
    if (info.valid_data && is_ours(text(sample.vehicle_id), reader, info)) return sample;
  }
  return std::nullopt;
}

bool Link::is_ours(std::string_view id, dds_entity_t reader, const dds_sample_info_t& info) const {
  return id == vehicle_id_ && participant_->is_by_vehicle(id, reader, info);
}

bool Link::take() {
  const bool news = daemons_.take();
  if (vehicle_ == nullptr) return news;
  const std::vector<const Daemon*> ours = daemons_.named(vehicle_id_);
  left_ = ours.empty();
  if (!left_ && *ours.front()->heard >= status_time_) {
    status_ = ours.front()->status;
    status_time_ = *ours.front()->heard;
  }
  for (const Daemon* daemon : ours) spoke_ = std::max(spoke_, daemon->spoke);
  return news;
}

// Of the vehicles that sent a status.
std::vector<std::string> Link::names() const {
  std::vector<std::string> names;
  for (const auto& [guid, daemon] : daemons_.all()) {
    if (daemon.heard) names.emplace_back(text(daemon.status.vehicle_id));
  }
  std::ranges::sort(names);
  names.erase(std::ranges::unique(names).begin(), names.end());
  return names;
}

Failure Link::unreachable(const std::string& vehicle_id) const {
  const std::vector<std::string> others = names();
  if (!others.empty() && !vehicle_id.empty()) {
    std::string advice = did_you_mean(vehicle_id, others);
    if (advice.empty()) advice = fmt::format("there are: {}", fmt::join(others, ", "));
    return Failure(
        ExitCode::unknown_name,
        fmt::format("there is no vehicle '{}' on DDS domain {}", vehicle_id, options_.domain),
        advice);
  }
  return Failure(
      ExitCode::unreachable, fmt::format("no vehicle answers on DDS domain {}", options_.domain),
      "check that lssd runs (systemctl status lssd@NAME) and uses the same --domain / LSS_DOMAIN, "
      "network interface and keystore (--enclave / LSS_ENCLAVE, or none)");
}

Failure Link::several() const {
  return Failure(ExitCode::usage,
                 fmt::format("several vehicles are on this domain: {}", fmt::join(names(), ", ")),
                 "name one with --vehicle, or LSS_VEHICLE in the environment");
}

bool Link::is_found() const {
  if (!options_.vehicle_id.empty()) return !daemons_.named(options_.vehicle_id).empty();
  return !names().empty();
}

void Link::look(const std::function<bool(bool all_heard, bool lull)>& is_enough) {
  const Clock::time_point until = Clock::now() + seconds(options_.find_timeout_s());
  for (Lull lull; Clock::now() < until;) {
    const Clock::time_point next = lull.step(take(), Clock::now());
    if (is_enough(daemons_.all_heard(), lull.is_over())) return;
    if (waker_.wait(std::min(next, until)).interrupted) throw Interrupted();
  }
}

void Link::find_vehicle() {
  const bool named = !options_.vehicle_id.empty();
  look([&](bool all_heard, bool lull) {
    return is_found() && (named ? all_heard || lull : all_heard && lull);
  });
  if (!is_found()) throw unreachable(options_.vehicle_id);
  if (!named && names().size() > 1) throw several();
  if (!named && !daemons_.all_heard()) {
    const char* why = daemons_.missing() == 0
                          ? "another daemon did not say its name"
                          : "it knows another daemon, which is not heard here (on another network, "
                            "or killed within the last 10 s)";
    throw Failure(ExitCode::usage,
                  fmt::format("{} is not alone on this domain: {}", names().front(), why),
                  "name the vehicle with --vehicle, or LSS_VEHICLE in the environment");
  }
  const std::string id = named ? options_.vehicle_id : names().front();
  const Daemon& daemon = *daemons_.named(id).front();
  vehicle_id_ = id;
  status_ = daemon.status;
  vehicle_ = &describe();
  status_time_ = spoke_ = found_ = Clock::now();
}

const Vehicle& Link::describe() {
  try {
    described_ = std::make_unique<DescribedVehicle>(dictionary());
  } catch (const Failure& e) {
    throw Failure(
        ExitCode::unknown_name,
        fmt::format("{} is of the type '{}', and {}", vehicle_id_, text(status_.vehicle), e.what()),
        e.advice());
  }
  return described_->vehicle();
}

bool Link::is_described() const {
  return described_ != nullptr && cli::find_vehicle(described_->vehicle().name) == nullptr;
}

bool Link::may_be_described() {
  look([&](bool all_heard, bool lull) { return is_found() && all_heard && lull; });
  return std::ranges::any_of(daemons_.all(), [&](const auto& one) {
    const auto& [guid, daemon] = one;
    const bool meant =
        options_.vehicle_id.empty() || options_.vehicle_id == text(daemon.status.vehicle_id);
    return daemon.heard && meant && cli::find_vehicle(text(daemon.status.vehicle)) == nullptr;
  });
}

void Link::listen() {
  look([](bool all_heard, bool lull) { return all_heard && lull; });
}

void Link::check_meant() {
  take();
  if (options_.vehicle_id.empty() && Clock::now() < found_ + seconds(kOthers_s) &&
      names().size() > 1)
    throw several();
}

const lss_Status& Link::status() {
  take();
  return status_;
}

bool Link::daemon_lost() const {
  return left_ || (Clock::now() - spoke_ >= kDaemonLost && !status_.simulated_time);
}

std::vector<lss_Instance> Link::instances() const {
  std::vector<lss_Instance> list;
  for (const Daemon* daemon : daemons_.named(vehicle_id_)) {
    if (Clock::now() - daemon->spoke < seconds(kSpeaks_s)) list.push_back(daemon->status.instance);
  }
  return list;
}

std::vector<dds_instance_handle_t> Link::hearers() const {
  std::vector<dds_instance_handle_t> readers(64);
  const int count =
      dds_get_matched_subscriptions(command_writer_.get(), readers.data(), readers.size());
  readers.resize(std::min(static_cast<std::size_t>(std::max(count, 0)), readers.size()));
  return readers;
}

bool Link::daemon_hears(dds_entity_t writer) const {
  std::array<dds_instance_handle_t, 64> readers{};
  const int count = dds_get_matched_subscriptions(writer, readers.data(), readers.size());
  for (int i = 0; i < std::min(count, static_cast<int>(readers.size())); ++i) {
    auto* endpoint =
        dds_get_matched_subscription_data(writer, readers[static_cast<std::size_t>(i)]);
    if (endpoint == nullptr) continue;
    Guid guid;
    std::ranges::copy(endpoint->participant_key.v, guid.begin());
    dds_builtintopic_free_endpoint(endpoint);
    const auto daemon = daemons_.all().find(guid);
    if (daemon != daemons_.all().end() && text(daemon->second.status.vehicle_id) == vehicle_id_)
      return true;
  }
  return false;
}

void Link::await_match(dds_entity_t writer, Clock::time_point until) {
  while (!daemon_hears(writer)) {
    if (Clock::now() >= until) {
      dds_offered_incompatible_qos_status_t differs{};
      if (dds_get_offered_incompatible_qos_status(writer, &differs) == DDS_RETCODE_OK &&
          differs.last_policy_id == DDS_TYPE_CONSISTENCY_ENFORCEMENT_QOS_POLICY_ID) {
        throw Failure(
            ExitCode::unreachable,
            fmt::format("{} was built with other types of commands than this lss-cli", vehicle_id_),
            fmt::format("take the lss-cli of its version, {}", text(status_.version)));
      }
      throw Failure(ExitCode::unreachable,
                    fmt::format("{} sends status but does not listen to commands", vehicle_id_),
                    "check the log of lssd; is another DDS configuration in CYCLONEDDS_URI?");
    }
    if (waker_.wait(until).interrupted) throw Interrupted();
    take();
  }
}

// A match with the daemon's reader does not mean that the daemon has matched our reader, and
// acknowledgements are not sent twice. So repeat a request without effect (a dry run that anyone
// may do) until it is answered.
void Link::await_answer(Clock::time_point until) {
  const Invocation probe{&common_command(CommandKind::request_data), {}};
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

std::string Link::own_name() const {
  return participant_->enclave() ? participant_->enclave()->name : std::string(kSharedSource);
}

std::string Link::own_source() const {
  const std::string with_pid = fmt::format("{}:{}", own_name(), getpid());
  return with_pid.size() < sizeof lss_Command::source ? with_pid : own_name();
}

void Link::open_command_writer(const std::string& source) {
  source_ = source;
  if (!is_certified(source)) {
    throw Failure(ExitCode::usage,
                  fmt::format("the source '{}' is not in the name of the certificate, '{}'", source,
                              own_name()),
                  fmt::format("--source {0}, or {0}:SOMETHING", own_name()));
  }
  if (command_writer_) return;
  const auto open = [&](dds::Kind kind) {
    return dds::create_writer(participant_->get(), dds::common_topic(kind));
  };
  auto created = open(dds::Kind::command);
  if (!created && participant_->enclave()) {
    created = open(dds::Kind::stop);
    only_stops_ = created.has_value();
    if (!created) {
      throw Failure(ExitCode::not_authorised,
                    fmt::format("the enclave '{}' may only look", own_name()),
                    "take one of the role stop or command: lss-cli keystore list FOLDER");
    }
  }
  command_writer_ = checked(std::move(created));
  dds_set_listener(command_writer_.get(), waker_.listener());
}

void Link::open_commands(const std::string& source) {
  if (answered_) return;
  open_command_writer(source);
  if (!only_stops_) heartbeat_writer_ = writer(dds::common_topic(dds::Kind::heartbeat));
  const Clock::time_point until = Clock::now() + seconds(options_.find_timeout_s());
  await_match(command_writer_.get(), until);
  if (!only_stops_) await_match(heartbeat_writer_.get(), until);
  await_answer(until);
  answered_ = true;
}

void Link::take_part(const std::string& folder) {
  waker_.take_part(folder, source_);
  sequence_.from_one();
  heartbeats_ = 0;
  take();
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
  if (telemetry_reader_ || vehicle_->telemetry == nullptr) return;
  const std::size_t size = vehicle_->telemetry->m_size;
  sample_.resize((size + sizeof(std::max_align_t) - 1) / sizeof(std::max_align_t));
  telemetry_reader_ = reader(dds::telemetry_topic(vehicle_->name, vehicle_->telemetry));
}

std::optional<Link::Answer> Link::next_answer() {
  Answer answer{};
  void* samples[1] = {&answer.ack};
  dds_sample_info_t info{};
  while (dds_take(ack_reader_.get(), samples, &info, 1, 1) == 1) {
    if (!info.valid_data || text(answer.ack.source) != source_ ||
        !participant_->is_by_vehicle(text(answer.ack.vehicle_id), ack_reader_.get(), info))
      continue;
    const std::optional<Guid> daemon = dds::owner_of(ack_reader_.get(), info.publication_handle);
    if (!daemon) continue;  // it went
    answer.daemon = *daemon;
    return answer;
  }
  return std::nullopt;
}

Waker::Result Link::wait(Clock::time_point until, int input_fd) {
  constexpr int kLook_ms = 10, kLooks = 1000;
  Waker::Result woken = waker_.wait(until, input_fd);
  for (int look = 0; !woken.interrupted && !hear_all(look); ++look) {
    if (look == kLooks)
      throw Failure(ExitCode::unreachable, "data from the daemon does not arrive");
    const Waker::Result more = waker_.poll(kLook_ms, input_fd);
    woken.interrupted |= more.interrupted;
    woken.input |= more.input;
  }
  return woken;
}

// In simulated time, wait for everything written until now, however long DDS takes; for telemetry,
// which may be lost, at most one second of wall-clock time.
bool Link::hear_all(int look) {
  lockstep::Client* simulation = waker_.simulation();
  if (simulation == nullptr) return true;
  constexpr int kLost = 100;
  take();
  while (const std::optional<lss_CommandAck> ack = take<lss_CommandAck>(ack_reader_.get())) {
    if (text(ack->source) != source_) continue;
    simulation->heard_answer(ack->seq);
    acks_.push_back(*ack);
  }
  telemetry();
  const bool waits = telemetry_ns_ != 0 && look < kLost;
  return simulation->all_heard(status_.time_ns, waits ? telemetry_ns_ : lockstep::kNever);
}

std::optional<lss_CommandAck> Link::next_ack() {
  if (!acks_.empty()) {
    const lss_CommandAck ack = acks_.front();
    acks_.pop_front();
    return ack;
  }
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

std::string Link::dictionary() {
  dictionary_reader_ = reader(dds::common_topic(dds::Kind::dictionary));
  const Clock::time_point until = Clock::now() + seconds(kDictionary_s);
  while (true) {
    if (std::optional<std::string> found = next_dictionary()) return std::move(*found);
    if (Clock::now() >= until) {
      throw Failure(ExitCode::unreachable,
                    fmt::format("the daemon of {} sent no dictionary", vehicle_id_),
                    "is it of an older version? see lss-cli status");
    }
    if (waker_.wait(until).interrupted) throw Interrupted();
  }
}

std::optional<std::string> Link::next_dictionary() {
  lss_Dictionary sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  std::optional<std::string> found;
  while (!found && dds_take(dictionary_reader_.get(), samples, &info, 1, 1) == 1) {
    if (info.valid_data && is_ours(text(sample.vehicle_id), dictionary_reader_.get(), info))
      found = sample.json;
  }
  dds_sample_free(&sample, &lss_Dictionary_desc, DDS_FREE_CONTENTS);
  return found;
}

const void* Link::telemetry() {
  if (!telemetry_reader_) return nullptr;
  std::vector<std::max_align_t> buffer(sample_.size());
  void* samples[1] = {buffer.data()};
  dds_sample_info_t info{};
  while (dds_take(telemetry_reader_.get(), samples, &info, 1, 1) == 1) {
    char id[sizeof lss_Status::vehicle_id];  // the key is the first member of every type, then time
    std::memcpy(id, buffer.data(), sizeof id);
    if (!info.valid_data || !is_ours(text(id), telemetry_reader_.get(), info)) continue;
    std::memcpy(sample_.data(), buffer.data(), sample_.size() * sizeof(std::max_align_t));
    std::memcpy(&telemetry_ns_, reinterpret_cast<const char*>(buffer.data()) + sizeof id,
                sizeof telemetry_ns_);
    ++telemetry_count_;
  }
  return telemetry_count_ == 0 ? nullptr : sample_.data();
}

std::uint64_t Link::send(const Invocation& command, std::uint16_t flags) {
  return send_to(vehicle_id_, command, flags);
}

std::uint64_t Link::send_to(std::string_view vehicle_id, const Invocation& command,
                            std::uint16_t flags) {
  if (only_stops_ && command.info->access != Access::anyone) {
    throw Failure(ExitCode::not_authorised,
                  fmt::format("the enclave '{}' may only stop in an emergency, not {}", own_name(),
                              command.info->name),
                  "lss-cli estop");
  }
  const lss_Command sample =
      to_dds(command, {vehicle_id, source_, sequence_.next(), flags, options_.lease_ms});
  const dds_return_t result = dds_write(command_writer_.get(), &sample);
  if (result < 0)
    throw Failure(ExitCode::internal, fmt::format("cannot send: {}", dds_strretcode(result)));
  if (lockstep::Client* simulation = waker_.simulation();
      simulation && !simulation->await_command(sample.seq, kTaken))
    throw not_taken();
  return sample.seq;
}

void Link::heartbeat() {
  if (only_stops_) return;
  const lss_Heartbeat sample = heartbeat_to_dds(vehicle_id_, source_, ++heartbeats_);
  dds_write(heartbeat_writer_.get(), &sample);
  const lockstep::Client* simulation = waker_.simulation();
  if (simulation == nullptr) return;
  for (TimeNs waited = 0; !simulation->await_heartbeat(heartbeats_, kAgain); waited += kAgain) {
    if (waited >= kTaken) throw not_taken();
    dds_write(heartbeat_writer_.get(), &sample);
  }
}

}  // namespace lss::cli
