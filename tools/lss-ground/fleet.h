#pragma once

// All vehicles on the domain, seen and commanded over DDS, each under the requested source. Without
// shared memory, so that reception does not depend on RouDi. Event loop only, except for `wake`,
// which Cyclone's threads call.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/session/described_vehicle.h"
#include "tools/lss-ground/daemons.h"
#include "tools/lss-ground/places.h"

namespace lss::ground {

// One vehicle, as known from its messages. One that is not on the roster of lss-cli is known when
// the dictionary of its daemon has arrived.
struct Craft {
  std::string id;
  std::string dictionary{};            // of `described`
  const cli::Vehicle* kind = nullptr;  // of the roster, or of `described`
  std::shared_ptr<const cli::DescribedVehicle> described;
  lss_Status status{};
  Clock::time_point status_time{};
  Clock::time_point heard{};  // the newest status or heartbeat of a daemon of that name
  bool alive = false;         // its daemon is present
  Daemons daemons;
  std::vector<std::max_align_t> telemetry;
  Clock::time_point telemetry_time{};
  std::deque<lss_Event> events;  // the newest, as many as the daemon stores
  lss_TimingStatistics timing{};
  lss_Parameters parameters{};  // none: not received yet

  const void* sample() const { return telemetry.empty() ? nullptr : telemetry.data(); }
};

class Fleet {
 public:
  // New samples; called by take() and take_telemetry().
  struct Ears {
    std::function<void(Craft&)> status;
    std::function<void(Craft&, const lss_Event&)> event;
    std::function<void(Craft&)> timing;
    std::function<void(Craft&)> parameters;
    std::function<void(Craft&)> telemetry;
    std::function<void(const lss_CommandAck&)> ack;
    std::function<void(const std::string&)> gone;    // it no longer has a place in the fleet
    std::function<bool(const std::string&)> driven;  // by a page
  };

  // wake: there is new data for take().
  // `enclave`: folder, for DDS Security; empty: none.
  static tl::expected<std::unique_ptr<Fleet>, Refusal> create(int domain,
                                                              const std::string& enclave,
                                                              std::function<void()> wake);

  void listen(Ears ears) { ears_ = std::move(ears); }
  void take();
  void take_telemetry();

  std::map<std::string, Craft>& crafts() { return crafts_; }
  Craft* find(std::string_view id);
  // It answers our commands: it keeps its place in the fleet.
  void answered(const std::string& id) { places_.answered(id, Clock::now()); }
  // Recently a vehicle found no place in the fleet.
  bool crowded() const { return places_.crowded(Clock::now()); }
  // Removes vehicles that were silent for too long. Call from time to time.
  void forget();

  // The name of the enclave; empty without DDS Security.
  std::string own_name() const {
    return participant_.enclave() ? participant_.enclave()->name : "";
  }

  const dds::Participant& participant() const { return participant_; }

  // False: DDS did not accept it.
  bool send(const lss_Command& command);
  void heartbeat(const std::string& vehicle_id, const std::string& source);

 private:
  explicit Fleet(std::function<void()> wake);
  dds::Result<void> open();
  dds::Result<void> open_reader(dds::Kind kind, dds::Entity& reader);
  void take_status();
  void take_heartbeats();
  void take_acks();
  void take_events();
  void take_timing();
  void take_parameters();
  void take_dictionaries();
  void heard_dictionary(std::string_view id, std::string text, const dds::Guid& origin);
  // Takes new samples, up to a limit, so that the loop can do its other work.
  template <class Sample, class Each>
  void take_each(const dds::Entity& reader, Each each);
  Craft* admit(const lss_Status& sample, const dds::Guid& origin);
  // Of a vehicle that is not on the roster: its dictionary has arrived.
  bool is_described(const std::string& id) const;
  // nullptr: it cannot be read.
  std::shared_ptr<const cli::DescribedVehicle> describe(const std::string& id);
  void leave(std::string id);  // a copy: often of the craft that it erases

  // Samples that arrived before the first status.
  struct Early {
    std::deque<lss_Event> events;
    lss_Parameters parameters{};
    std::string dictionary;
  };
  Early* early(std::string_view id, const dds::Guid& origin);  // nullptr: no place
  struct TelemetryReader {
    const cli::Vehicle* kind;
    dds::Entity entity;
  };

  std::function<void()> wake_;
  Ears ears_;
  std::map<std::string, Craft> crafts_;
  std::map<std::string, Early> early_;
  Places places_, early_places_;  // of each of them
  std::uint64_t heartbeats_ = 0;

  struct ListenerDeleter {
    void operator()(dds_listener_t* listener) const { dds_delete_listener(listener); }
  };
  std::unique_ptr<dds_listener_t, ListenerDeleter> listener_;
  dds::Participant participant_;
  dds::Entity status_reader_, heartbeat_reader_, ack_reader_, event_reader_, timing_reader_,
      parameter_reader_, dictionary_reader_;
  std::vector<TelemetryReader> telemetry_readers_;
  dds::Entity command_writer_, heartbeat_writer_;
};

}  // namespace lss::ground
