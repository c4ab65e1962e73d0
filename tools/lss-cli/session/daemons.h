#pragma once

// The daemons on the domain, from DDS discovery and their status. DDS reports a daemon's
// participant before its topics, so a daemon is known before its status arrives. Main thread only;
// nothing blocks here.

#include <dds/dds.h>

#include <map>
#include <optional>
#include <string_view>
#include <vector>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/session/waker.h"

namespace lss::cli {

using dds::Guid;

struct Options;

// The participant of lss-cli. Throws a Failure.
dds::Participant own_participant(const Options& options);

struct Daemon {
  lss_Status status{};                       // the newest
  std::optional<Clock::time_point> heard{};  // when it arrived; empty: none yet
  Clock::time_point spoke{};                 // the newest status or heartbeat
  unsigned others = 0;                       // that it knows of
};

class Daemons {
 public:
  Daemons(const dds::Participant& participant, const dds_listener_t* listener);

  // Takes all new samples. True: a daemon appeared, sent its first status, or disappeared.
  bool take();
  // The daemons that are present.
  const std::map<Guid, Daemon>& all() const { return all_; }
  bool all_heard() const;  // each has sent its status, and none is missing
  // How many are not present, but known to one that is.
  std::size_t missing() const;
  // The daemons of this name; the one with the newest status first.
  std::vector<const Daemon*> named(std::string_view vehicle_id) const;

 private:
  bool take_participants();
  bool take_writers();
  bool take_status();
  void take_heartbeats();
  const Guid* daemon_of(dds_instance_handle_t writer);

  const dds::Participant& participant_;
  dds::Entity participant_reader_, status_reader_, heartbeat_reader_;
  std::map<Guid, Daemon> all_;
  std::map<dds_instance_handle_t, Guid> writers_;  // of status, matched
};

// Daemons say how many others they know of. That there is none which they do not know of yet, only
// listening for some time shows. The time is counted in slices, each without news: when this
// process gets little CPU time, so do its DDS threads, and the listening takes correspondingly
// longer. It is three times as long as all news took, 0.3 s to a
// second: where the first daemon was heard late, because its machine is busy, so may be the second,
// and a busy virtual machine lets one of its processors stand still for 0.1 s.
class Lull {
 public:
  // Call after each check for news; returns the time of the next check.
  Clock::time_point step(bool news, Clock::time_point now);
  bool is_over() const {
    return slices_ >= kSlices && now_ - last_news_ >= std::min(3 * (last_news_ - begin_), kMost);
  }

 private:
  static constexpr int kSlices = 30;
  static constexpr std::chrono::milliseconds kSlice{10};
  static constexpr Clock::duration kMost = std::chrono::seconds(1);
  int slices_ = 0;
  Clock::time_point begin_{}, last_news_{}, now_{}, slice_end_{};
};

}  // namespace lss::cli
