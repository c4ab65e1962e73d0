#pragma once

// The command line's end of the DDS interface: finds the vehicle, receives its status,
// acknowledgements, events, timing and telemetry, sends commands and heartbeats. Without shared
// memory by default, so that reception does not depend on RouDi. Main thread only; every wait is
// bounded. Errors are thrown as a Failure.

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/session/commands.h"
#include "tools/lss-cli/session/daemons.h"
#include "tools/lss-cli/session/described_vehicle.h"
#include "tools/lss-cli/session/waker.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/options.h"

namespace lss::cli {

// The source name of commands that belong to no particular process, without DDS Security.
inline constexpr std::string_view kSharedSource = "lss-cli";

class Link {
 public:
  // Without a participant it makes one.
  explicit Link(const Options& options,
                std::shared_ptr<const dds::Participant> participant = nullptr);

  // Of the participant.
  std::span<const std::string> warnings() const { return participant_->warnings(); }
  // Waits for the status of the vehicle and of every daemon known to DDS. Throws unreachable when
  // there is none, unknown_name when there are only others, usage when there are several and none
  // was named.
  void find_vehicle();
  // Waits until DDS has reported no new daemon for some time.
  void listen();
  // Waits until a daemon has answered, as long as find_vehicle() does. True: the vehicle meant may
  // be one that this program was built without.
  bool may_be_described();
  // Throws usage when no vehicle was named and a second one appeared shortly after. Call before the
  // first command that moves.
  void check_meant();
  // There is no vehicle, or only vehicles of other names; empty: any.
  Failure unreachable(const std::string& vehicle_id) const;
  // Opens the writers and waits until a command without effect is acknowledged: then both
  // directions work.
  void open_commands(const std::string& source);
  // From here on uses the simulated time of lss-sim in that folder.
  void take_part(const std::string& folder);
  lockstep::Client* simulation() { return waker_.simulation(); }
  // Opens the writer without waiting, for no particular vehicle. A source that is empty, or not
  // that of the certificate, never prevents a stop: then it is own_source().
  void open_emergency(const std::string& source) {
    const bool fits = !source.empty() && is_certified(source);
    if (!command_writer_) open_command_writer(fits ? source : own_source());
  }

  Waker::Result wait(Clock::time_point until, int input_fd = -1);
  // Also when the verb that waited ends by Ctrl-C.
  bool was_interrupted() const { return waker_.was_interrupted(); }
  void forget_interruption() { waker_.forget_interruption(); }

  const Vehicle& vehicle() const { return *vehicle_; }
  // It is not on the roster: its daemon describes it.
  bool is_described() const;
  // Takes new samples and returns the newest status. news: it has changed since the last call.
  const lss_Status& status();
  bool daemon_left() const { return left_; }  // it disposed its status, or DDS lost it
  // It left, or sent no status for 3 s. In simulated time a second may take long: there only the
  // first.
  bool daemon_lost() const;
  // The daemons that now publish for the vehicle, the newest first. More than one: they share one
  // name.
  std::vector<lss_Instance> instances() const;

  // Takes new status samples. True: a daemon appeared, sent its first status, or disappeared.
  bool take();
  const Daemons& daemons() const { return daemons_; }
  // The readers that the writer of commands is matched with.
  std::vector<dds_instance_handle_t> hearers() const;

  // An acknowledgement to our source, from any vehicle.
  struct Answer {
    lss_CommandAck ack;
    Guid daemon;
  };
  std::optional<Answer> next_answer();

  std::optional<lss_CommandAck> next_ack();
  std::optional<lss_Event> next_event();
  std::optional<lss_Timing> next_timing();
  std::optional<lss_TimingStatistics> next_timing_statistics();
  std::optional<lss_Parameters> next_parameters();
  // JSON. Waits for it; throws unreachable when none comes.
  std::string dictionary();
  // The newest sample, of the vehicle's own type; nullptr when none was received yet.
  const void* telemetry();
  std::uint64_t telemetry_count() const { return telemetry_count_; }

  // Returns the sequence number.
  std::uint64_t send(const Invocation& command, std::uint16_t flags);
  std::uint64_t send_to(std::string_view vehicle_id, const Invocation& command,
                        std::uint16_t flags = 0);
  void heartbeat();
  const std::string& source() const { return source_; }
  // Of a source, before its PID: that of the certificate, with DDS Security.
  std::string own_name() const;
  // With that name, or with that name and the PID.
  std::string own_source() const;

  void open_events();
  void open_timing();
  void open_timing_statistics();
  void open_parameters();
  void open_telemetry();

 private:
  dds::Entity reader(const dds::Topic& topic);
  dds::Entity writer(const dds::Topic& topic);
  std::vector<std::string> names() const;
  bool is_found() const;
  // Looks for daemons until is_enough(), at most for find_timeout_s(). `lull`: DDS has reported
  // no new one for some time.
  void look(const std::function<bool(bool all_heard, bool lull)>& is_enough);
  const Vehicle& describe();
  Failure several() const;
  // Without DDS Security any is.
  bool is_certified(const std::string& source) const {
    return !participant_->enclave() || dds::name_of_source(source) == own_name();
  }
  void open_command_writer(const std::string& source);
  bool daemon_hears(dds_entity_t writer) const;
  void await_match(dds_entity_t writer, Clock::time_point until);
  void await_answer(Clock::time_point until);
  std::optional<std::string> next_dictionary();
  bool hear_all(int look);
  template <class Sample>
  std::optional<Sample> take(dds_entity_t reader);
  // Whether the sample of this vehicle_id is of the vehicle, and by it.
  bool is_ours(std::string_view id, dds_entity_t reader, const dds_sample_info_t& info) const;

  Options options_;
  std::unique_ptr<DescribedVehicle> described_;  // outlives its reader
  Waker waker_;                                  // before any entity
  std::shared_ptr<const dds::Participant> participant_;
  Daemons daemons_;
  dds::Entity ack_reader_, event_reader_, timing_reader_, statistics_reader_, parameter_reader_,
      dictionary_reader_, telemetry_reader_;
  dds::Entity command_writer_, heartbeat_writer_;
  bool only_stops_ = false;  // the writer is that of lss/stop

  const Vehicle* vehicle_ = nullptr;
  std::string vehicle_id_;
  lss_Status status_{};
  Clock::time_point status_time_{}, found_{};
  Clock::time_point spoke_{};  // a daemon of that name
  bool left_ = false;
  bool answered_ = false;            // both directions work
  std::deque<lss_CommandAck> acks_;  // taken already
  std::string source_;
  Sequence sequence_;
  std::uint64_t heartbeats_ = 0;
  std::vector<std::max_align_t> sample_;  // of telemetry
  std::uint64_t telemetry_count_ = 0;
  TimeNs telemetry_ns_ = 0;
};

}  // namespace lss::cli
