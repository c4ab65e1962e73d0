#include "tools/lss-ground/fleet.h"

#include <algorithm>
#include <cstring>
#include <memory>

#include "idl/recording_reader.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::ground {
namespace {

constexpr std::size_t kMostOfDictionary = 1'000'000;  // bytes
constexpr int kAtOnce = 256;                          // samples of one topic before the next topic

// Ignores an invalid id: any participant can write to the domain.
bool good_id(std::string_view id) {
  if (id.empty() || id.size() >= sizeof lss_Status::vehicle_id) return false;
  if (id == dds::kEveryVehicle) return false;
  for (const char c : id) {
    if (c <= ' ' || c > '~') return false;
  }
  return true;
}

// All participants that are gone already are one.
dds::Guid origin_of(const dds::Entity& reader, const dds_sample_info_t& info) {
  return dds::owner_of(reader.get(), info.publication_handle).value_or(dds::Guid{});
}

}  // namespace

template <class Sample, class Each>
void Fleet::take_each(const dds::Entity& reader, Each each) {
  Sample sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  for (int i = 0; i < kAtOnce; ++i) {
    if (dds_take(reader.get(), samples, &info, 1, 1) != 1) return;
    if (participant_.is_by_vehicle(cli::text(sample.vehicle_id), reader.get(), info))
      each(sample, info);
  }
  wake_();
}

Fleet::Fleet(std::function<void()> wake)
    : wake_(std::move(wake)),
      places_([this](const std::string& id) { return ears_.driven && ears_.driven(id); }) {}

tl::expected<std::unique_ptr<Fleet>, Refusal> Fleet::create(int domain, const std::string& enclave,
                                                            std::function<void()> wake) {
  std::unique_ptr<Fleet> fleet(new Fleet(std::move(wake)));
  dds::ParticipantParameters parameters;
  parameters.domain = domain;
  parameters.enclave = enclave;
  parameters.short_lived = true;  // commands are requested again at once after a loss
  auto participant = dds::Participant::create(parameters);
  if (!participant) return tl::unexpected(participant.error());
  fleet->participant_ = std::move(*participant);
  if (auto opened = fleet->open(); !opened) return tl::unexpected(dds::refusal_of(opened.error()));
  return fleet;
}

dds::Result<void> Fleet::open() {
  listener_.reset(dds_create_listener(this));
  dds_lset_data_available(listener_.get(),
                          [](dds_entity_t, void* self) { static_cast<Fleet*>(self)->wake_(); });
  for (const auto& [kind, reader] : {std::pair{dds::Kind::status, &status_reader_},
                                     {dds::Kind::command_ack, &ack_reader_},
                                     {dds::Kind::event, &event_reader_},
                                     {dds::Kind::timing_statistics, &timing_reader_},
                                     {dds::Kind::parameters, &parameter_reader_},
                                     {dds::Kind::dictionary, &dictionary_reader_}}) {
    if (auto opened = open_reader(kind, *reader); !opened) return opened;
  }
  // Clients send them, too: those of one name must not hide one another.
  auto heartbeats = dds::create_recording_reader(
      participant_.get(), dds::common_topic(dds::Kind::heartbeat), listener_.get());
  if (!heartbeats) return tl::unexpected(heartbeats.error());
  heartbeat_reader_ = std::move(*heartbeats);
  for (const auto& [kind, writer] : {std::pair{dds::Kind::command, &command_writer_},
                                     {dds::Kind::heartbeat, &heartbeat_writer_}}) {
    auto created = dds::create_writer(participant_.get(), dds::common_topic(kind));
    if (!created) return tl::unexpected(created.error());
    *writer = std::move(*created);
  }
  // No listener: telemetry is read when it is to be sent, the newest sample only.
  for (const cli::Vehicle* kind : cli::vehicles()) {
    auto reader =
        dds::create_reader(participant_.get(), dds::telemetry_topic(kind->name, kind->telemetry));
    if (!reader) return tl::unexpected(reader.error());
    telemetry_readers_.push_back({kind, std::move(*reader)});
  }
  return {};
}

dds::Result<void> Fleet::open_reader(dds::Kind kind, dds::Entity& reader) {
  auto created = dds::create_reader(participant_.get(), dds::common_topic(kind),
                                    dds::Transport::best, listener_.get());
  if (!created) return tl::unexpected(created.error());
  reader = std::move(*created);
  return {};
}

Craft* Fleet::find(std::string_view id) {
  const auto found = crafts_.find(std::string(id));
  return found == crafts_.end() ? nullptr : &found->second;
}

void Fleet::take() {
  take_dictionaries();
  take_status();
  take_heartbeats();
  take_acks();
  take_events();
  take_timing();
  take_parameters();
}

Craft* Fleet::admit(const lss_Status& sample, const dds::Guid& origin) {
  const std::string id(cli::text(sample.vehicle_id));
  if (!good_id(id)) return nullptr;
  const cli::Vehicle* kind = cli::find_vehicle(cli::text(sample.vehicle));
  if (kind == nullptr && !is_described(id)) return nullptr;
  const Places::Admission admission = places_.admit(id, origin, Clock::now());
  if (!admission.in) return nullptr;
  if (!admission.left.empty()) leave(admission.left);
  std::shared_ptr<const cli::DescribedVehicle> described;
  if (kind == nullptr) {
    described = describe(id);
    if (!described) {
      places_.leave(id);
      return nullptr;
    }
    kind = &described->vehicle();
  }
  Craft& craft = crafts_[id];
  craft.id = id;
  craft.kind = kind;
  craft.described = std::move(described);
  if (const auto early = early_.find(id); early != early_.end()) {
    craft.events = std::move(early->second.events);
    craft.parameters = early->second.parameters;
    if (craft.described) craft.dictionary = std::move(early->second.dictionary);
    early_.erase(early);
    early_places_.leave(id);
  }
  if (craft.described && kind->telemetry != nullptr) {
    auto reader =
        dds::create_reader(participant_.get(), dds::telemetry_topic(kind->name, kind->telemetry));
    if (reader) telemetry_readers_.push_back({kind, std::move(*reader)});
  }
  return &craft;
}

bool Fleet::is_described(const std::string& id) const {
  const auto early = early_.find(id);
  return early != early_.end() && !early->second.dictionary.empty();
}

std::shared_ptr<const cli::DescribedVehicle> Fleet::describe(const std::string& id) {
  std::string& dictionary = early_.at(id).dictionary;
  try {
    return std::make_shared<const cli::DescribedVehicle>(dictionary);
  } catch (const cli::Failure&) {
    dictionary.clear();  // it is not tried again
    return nullptr;
  }
}

void Fleet::leave(std::string id) {
  if (const Craft* craft = find(id); craft != nullptr && craft->described)
    std::erase_if(telemetry_readers_, [&](const auto& r) { return r.kind == craft->kind; });
  crafts_.erase(id);
  ears_.gone(id);
}

void Fleet::forget() {
  const Clock::time_point now = Clock::now();
  for (const std::string& id : places_.forget(now)) leave(id);
  for (const std::string& id : early_places_.forget(now)) early_.erase(id);
}

Fleet::Early* Fleet::early(std::string_view id, const dds::Guid& origin) {
  const std::string key(id);
  if (const auto known = early_.find(key); known != early_.end()) return &known->second;
  const Places::Admission admission = early_places_.admit(key, origin, Clock::now());
  if (!admission.in) return nullptr;
  early_.erase(admission.left);
  return &early_[key];
}

void Fleet::take_status() {
  take_each<lss_Status>(status_reader_,
                        [&](const lss_Status& sample, const dds_sample_info_t& info) {
                          Craft* craft = find(cli::text(sample.vehicle_id));
                          if (!info.valid_data) {
                            if (craft == nullptr) return;
                            craft->alive = info.instance_state == DDS_IST_ALIVE;
                            ears_.status(*craft);
                            return;
                          }
                          if (craft == nullptr)
                            craft = admit(sample, origin_of(status_reader_, info));
                          if (craft == nullptr) return;
                          craft->status = sample;
                          craft->status_time = craft->heard = Clock::now();
                          craft->alive = true;
                          craft->daemons.heard(sample.instance, craft->status_time);
                          places_.heard(craft->id, craft->status_time);
                          ears_.status(*craft);
                        });
}

// At rest a daemon sends its status seldom.
void Fleet::take_heartbeats() {
  take_each<lss_Heartbeat>(
      heartbeat_reader_, [&](const lss_Heartbeat& sample, const dds_sample_info_t& info) {
        Craft* craft = find(cli::text(sample.vehicle_id));
        if (!info.valid_data || craft == nullptr || cli::text(sample.source) != dds::kDaemonSource)
          return;
        craft->heard = Clock::now();
        craft->daemons.heard(sample.instance, craft->heard);
        places_.heard(craft->id, craft->heard);
      });
}

void Fleet::take_acks() {
  take_each<lss_CommandAck>(ack_reader_,
                            [&](const lss_CommandAck& ack, const dds_sample_info_t& info) {
                              if (info.valid_data) ears_.ack(ack);
                            });
}

namespace {

// As the daemon: the newest of each id and subject, of each series the newest report.
void keep(std::deque<lss_Event>& events, const lss_Event& event) {
  constexpr std::size_t kMostEvents = 1024;
  std::erase_if(events, [&](const lss_Event& e) { return cli::is_newer(event, e); });
  const auto is_like = [&](const lss_Event& e) {
    return e.id == event.id && e.subject == event.subject;
  };
  if (std::ranges::count_if(events, is_like) >= dds::kEventsKept)
    events.erase(std::ranges::find_if(events, is_like));
  events.push_back(event);
  if (events.size() > kMostEvents) events.pop_front();
}

}  // namespace

void Fleet::take_events() {
  take_each<lss_Event>(event_reader_, [&](const lss_Event& event, const dds_sample_info_t& info) {
    const std::string_view id = cli::text(event.vehicle_id);
    if (!info.valid_data || !good_id(id)) return;
    Craft* craft = find(id);
    Early* before = craft == nullptr ? early(id, origin_of(event_reader_, info)) : nullptr;
    if (craft == nullptr && before == nullptr) return;
    std::deque<lss_Event>& events = craft != nullptr ? craft->events : before->events;
    // Another daemon of that name counts its events from 1 again.
    if (!events.empty() && event.index <= events.back().index &&
        event.utc_ns > events.back().utc_ns)
      events.clear();
    keep(events, event);
    if (craft != nullptr) ears_.event(*craft, event);
  });
}

void Fleet::take_timing() {
  take_each<lss_TimingStatistics>(
      timing_reader_, [&](const lss_TimingStatistics& timing, const dds_sample_info_t& info) {
        Craft* craft = info.valid_data ? find(cli::text(timing.vehicle_id)) : nullptr;
        if (craft == nullptr) return;
        craft->timing = timing;
        ears_.timing(*craft);
      });
}

void Fleet::take_parameters() {
  take_each<lss_Parameters>(
      parameter_reader_, [&](const lss_Parameters& parameters, const dds_sample_info_t& info) {
        const std::string_view id = cli::text(parameters.vehicle_id);
        if (!info.valid_data || !good_id(id)) return;
        Craft* craft = find(id);
        if (craft != nullptr) {
          craft->parameters = parameters;
          ears_.parameters(*craft);
        } else if (Early* before = early(id, origin_of(parameter_reader_, info))) {
          before->parameters = parameters;
        }
      });
}

void Fleet::take_dictionaries() {
  lss_Dictionary sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  for (int i = 0; i < kAtOnce; ++i) {
    if (dds_take(dictionary_reader_.get(), samples, &info, 1, 1) != 1) break;
    const std::string_view id = cli::text(sample.vehicle_id);
    if (info.valid_data && good_id(id) &&
        participant_.is_by_vehicle(id, dictionary_reader_.get(), info))
      heard_dictionary(id, sample.json, origin_of(dictionary_reader_, info));
  }
  dds_sample_free(&sample, &lss_Dictionary_desc, DDS_FREE_CONTENTS);
}

// Another dictionary is that of another daemon: the vehicle comes back with it, unless a page
// drives it.
void Fleet::heard_dictionary(std::string_view id, std::string text, const dds::Guid& origin) {
  if (text.size() > kMostOfDictionary) return;
  if (const Craft* craft = find(id)) {
    if (!craft->described || craft->dictionary == text) return;
    if (ears_.driven && ears_.driven(craft->id)) return;
    places_.leave(craft->id);
    leave(craft->id);
  }
  if (Early* before = early(id, origin)) before->dictionary = std::move(text);
}

void Fleet::take_telemetry() {
  for (const TelemetryReader& reader : telemetry_readers_) {
    const std::size_t size = reader.kind->telemetry->m_size;
    std::vector<std::max_align_t> buffer((size + sizeof(std::max_align_t) - 1) /
                                         sizeof(std::max_align_t));
    void* samples[1] = {buffer.data()};
    dds_sample_info_t info{};
    while (dds_take(reader.entity.get(), samples, &info, 1, 1) == 1) {
      char id[sizeof lss_Status::vehicle_id];  // the key is the first member of every type
      std::memcpy(id, buffer.data(), sizeof id);
      Craft* craft = info.valid_data ? find(cli::text(id)) : nullptr;
      if (craft == nullptr || craft->kind != reader.kind ||
          !participant_.is_by_vehicle(craft->id, reader.entity.get(), info))
        continue;
      craft->telemetry = buffer;
      craft->telemetry_time = Clock::now();
      ears_.telemetry(*craft);
    }
  }
}

bool Fleet::send(const lss_Command& command) {
  return dds_write(command_writer_.get(), &command) >= 0;
}

void Fleet::heartbeat(const std::string& vehicle_id, const std::string& source) {
  const lss_Heartbeat sample = cli::heartbeat_to_dds(vehicle_id, source, ++heartbeats_);
  dds_write(heartbeat_writer_.get(), &sample);
}

}  // namespace lss::ground
