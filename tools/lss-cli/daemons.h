#pragma once

// The daemons on the domain, as DDS and their status tell of them. DDS tells of a daemon's
// participant before it tells of its topics: one whose status is still on its way is known to be
// there. Main thread only; nothing waits here.

#include <dds/dds.h>

#include <array>
#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/waker.h"

namespace lss::cli {

// Of a DDS participant.
using Guid = std::array<std::uint8_t, sizeof(dds_guid_t)>;

struct Daemon {
  lss_Status status{};                       // the newest
  std::optional<Clock::time_point> heard{};  // when it came; empty: none came yet
};

class Daemons {
 public:
  Daemons(dds_entity_t participant, const dds_listener_t* listener);

  // Takes what has come. True: a daemon came, spoke for the first time, or went.
  bool take();
  // Those that are there.
  const std::map<Guid, Daemon>& all() const { return all_; }
  bool all_heard() const;
  // Of this name; the one that was heard last stands first.
  std::vector<const Daemon*> named(std::string_view vehicle_id) const;

 private:
  bool take_participants();
  bool take_writers();
  bool take_status();
  const Guid* daemon_of(dds_instance_handle_t writer);

  dds::Entity participant_reader_, status_reader_;
  std::map<Guid, Daemon> all_;
  std::map<dds_instance_handle_t, Guid> writers_;  // of status, matched
};

// That there is nobody else can only be known by listening for a while. Counted in slices, each of
// which has to pass without news: where this process gets little time, so do its threads of DDS,
// and the while is as much longer.
class Lull {
 public:
  // Whenever there was a look for news; returns when to look again.
  Clock::time_point step(bool news);
  bool is_over() const { return slices_ >= kSlices; }

 private:
  static constexpr int kSlices = 10;
  static constexpr std::chrono::milliseconds kSlice{10};
  int slices_ = 0;
  Clock::time_point slice_end_{};
};

// Whose writer it is that the reader is matched with.
std::optional<Guid> participant_of(dds_entity_t reader, dds_instance_handle_t writer);

}  // namespace lss::cli
