#include "tools/lss-cli/session/daemons.h"

#include <algorithm>

#include "idl/other_daemons.h"
#include "idl/recording_reader.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/options.h"

namespace lss::cli {
namespace {

dds::Entity builtin_reader(dds_entity_t participant, const dds_listener_t* listener) {
  const dds_entity_t reader =
      dds_create_reader(participant, DDS_BUILTIN_TOPIC_DCPSPARTICIPANT, nullptr, listener);
  if (reader < 0) throw Failure(ExitCode::internal, "cannot ask DDS who is there");
  return dds::Entity(reader);
}

// Two daemons of one name must not hide each other: samples of one key wait side by side.
dds::Entity reader_of(dds::Kind kind, dds_entity_t participant, const dds_listener_t* listener) {
  return checked(dds::create_recording_reader(participant, dds::common_topic(kind), listener));
}

dds::ParticipantParameters parameters(const Options& options) {
  dds::ParticipantParameters result;
  result.short_lived = true;
  result.domain = options.domain;
  result.shared_memory = options.shared_memory;
  result.enclave = options.enclave;
  return result;
}

}  // namespace

dds::Participant own_participant(const Options& options) {
  auto participant = dds::Participant::create(parameters(options));
  // An enclave that cannot be used is the user's to repair.
  if (!participant && !options.enclave.empty() &&
      (participant.error().cure == Cure::change || !dds::read_enclave(options.enclave)))
    throw Failure(ExitCode::usage, participant.error().text);
  return checked(std::move(participant));
}

Daemons::Daemons(const dds::Participant& participant, const dds_listener_t* listener)
    : participant_(participant),
      participant_reader_(builtin_reader(participant.get(), listener)),
      status_reader_(reader_of(dds::Kind::status, participant.get(), listener)),
      heartbeat_reader_(reader_of(dds::Kind::heartbeat, participant.get(), nullptr)) {}

bool Daemons::take() {
  const bool participants = take_participants();
  const bool writers = take_writers();
  const bool statuses = take_status();
  take_heartbeats();
  return statuses || participants || writers;
}

bool Daemons::take_participants() {
  bool news = false;
  dds::take_participants(
      participant_reader_.get(),
      [&](const Guid& guid, const std::optional<unsigned>& others) {
        // With DDS Security anybody's mark: there a daemon is who may write status.
        if (participant_.enclave() || !others) return;
        const auto [daemon, is_new] = all_.try_emplace(guid);
        news = is_new || daemon->second.others != *others || news;
        daemon->second.others = *others;
      },
      [&](const Guid& guid) { news = all_.erase(guid) > 0 || news; });
  return news;
}

bool Daemons::take_writers() {
  std::vector<dds_instance_handle_t> matched(16);
  const int count =
      dds_get_matched_publications(status_reader_.get(), matched.data(), matched.size());
  if (count > static_cast<int>(matched.size())) {
    matched.resize(static_cast<std::size_t>(count));
    dds_get_matched_publications(status_reader_.get(), matched.data(), matched.size());
  }
  matched.resize(static_cast<std::size_t>(std::max(count, 0)));
  bool news = false;
  for (const dds_instance_handle_t writer : matched) {
    if (writers_.contains(writer)) continue;
    const Guid* guid = daemon_of(writer);
    news = (guid != nullptr && all_.try_emplace(*guid).second) || news;
  }
  for (auto known = writers_.begin(); known != writers_.end();) {
    if (std::ranges::find(matched, known->first) != matched.end()) {
      ++known;
      continue;
    }
    news = all_.erase(known->second) > 0 || news;
    known = writers_.erase(known);
  }
  return news;
}

// Stores the owner of the writer; nullptr when the writer has gone.
const Guid* Daemons::daemon_of(dds_instance_handle_t writer) {
  if (const auto known = writers_.find(writer); known != writers_.end()) return &known->second;
  const std::optional<Guid> guid = dds::owner_of(status_reader_.get(), writer);
  return guid ? &writers_.emplace(writer, *guid).first->second : nullptr;
}

bool Daemons::take_status() {
  bool news = false;
  lss_Status sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (dds_take(status_reader_.get(), samples, &info, 1, 1) == 1) {
    const Guid* guid = daemon_of(info.publication_handle);
    if (guid == nullptr) continue;  // it has gone
    if (!info.valid_data) {
      if (info.instance_state != DDS_IST_ALIVE) news = all_.erase(*guid) > 0 || news;
      continue;
    }
    if (!participant_.is_by_vehicle(text(sample.vehicle_id), status_reader_.get(), info)) {
      news = all_.erase(*guid) > 0 || news;  // in the name of another vehicle
      continue;
    }
    Daemon& daemon = all_[*guid];
    news = news || !daemon.heard;
    daemon.status = sample;
    daemon.heard = daemon.spoke = Clock::now();
  }
  return news;
}

// Of a daemon that has sent its status: at rest the next one comes late (StatusPace of the daemon).
void Daemons::take_heartbeats() {
  lss_Heartbeat sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (dds_take(heartbeat_reader_.get(), samples, &info, 1, 1) == 1) {
    const std::string_view id = text(sample.vehicle_id);
    if (!info.valid_data || text(sample.source) != dds::kDaemonSource ||
        !participant_.is_by_vehicle(id, heartbeat_reader_.get(), info))
      continue;
    for (auto& [guid, daemon] : all_) {
      if (daemon.heard && text(daemon.status.vehicle_id) == id &&
          is_same(daemon.status.instance, sample.instance))
        daemon.spoke = Clock::now();
    }
  }
}

Clock::time_point Lull::step(bool news, Clock::time_point now) {
  now_ = now;
  if (begin_ == Clock::time_point{}) begin_ = now_;
  if (news || begin_ == now_) {
    slices_ = 0;
    last_news_ = now_;
    slice_end_ = now_ + kSlice;
  } else if (now_ >= slice_end_) {
    ++slices_;
    slice_end_ = now_ + kSlice;
  }
  return slice_end_;
}

std::size_t Daemons::missing() const {
  std::size_t known = all_.size();
  for (const auto& [guid, daemon] : all_) known = std::max<std::size_t>(known, daemon.others + 1u);
  return known - all_.size();
}

bool Daemons::all_heard() const {
  return missing() == 0 &&
         std::ranges::all_of(all_, [](const auto& d) { return d.second.heard.has_value(); });
}

std::vector<const Daemon*> Daemons::named(std::string_view vehicle_id) const {
  std::vector<const Daemon*> list;
  for (const auto& [guid, daemon] : all_) {
    if (daemon.heard && text(daemon.status.vehicle_id) == vehicle_id) list.push_back(&daemon);
  }
  std::ranges::sort(list, std::ranges::greater{}, &Daemon::heard);
  return list;
}

}  // namespace lss::cli
