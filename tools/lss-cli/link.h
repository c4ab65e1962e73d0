#pragma once

// The command line's end of the DDS face: finds the vehicle, hears its status, acknowledgements,
// events, timing and telemetry, sends commands and heartbeats. Without shared memory unless asked,
// so that it hears the daemon whatever RouDi does. Main thread only; every wait is bounded. Trouble
// is thrown as a Failure.

#include <array>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/commands.h"
#include "tools/lss-cli/failure.h"
#include "tools/lss-cli/options.h"
#include "tools/lss-cli/waker.h"
#include "tools/lss-cli/wire.h"

namespace lss::cli {

class Link {
 public:
  explicit Link(const Options& options);

  // Waits for the status of the vehicle. unreachable when there is none, unknown_name when only
  // others are there, usage when there are several and none was named.
  void find_vehicle();
  // Opens the writers and waits until a command that does nothing was acknowledged: from then on
  // both ways work.
  void open_commands(const std::string& source);
  // The same without waiting for anything but a reader.
  void open_emergency(const std::string& source);

  Waker::Result wait(Clock::time_point until, int input_fd = -1) {
    return waker_.wait(until, input_fd);
  }

  const Vehicle& vehicle() const { return *vehicle_; }
  // The newest status; takes what has come. news: another one than at the last call.
  const lss_Status& status();
  Clock::duration status_age() const;
  bool daemon_left() const { return left_; }  // it said good-bye, or DDS lost it

  std::optional<lss_CommandAck> next_ack();
  std::optional<lss_Event> next_event();
  std::optional<lss_Timing> next_timing();
  std::optional<lss_TimingStatistics> next_timing_statistics();
  std::optional<lss_Parameters> next_parameters();
  // The newest sample, of the vehicle's own type; nullptr when none was heard yet.
  const void* telemetry();
  std::uint64_t telemetry_count() const { return telemetry_count_; }

  // Returns the sequence number.
  std::uint64_t send(const Invocation& command, std::uint16_t flags);
  void heartbeat();
  const std::string& source() const { return source_; }

  void open_events();
  void open_timing();
  void open_timing_statistics();
  void open_parameters();
  void open_telemetry();

 private:
  struct Seen {
    lss_Status status{};
    dds_guid_t participant{};
    bool alive = false;
  };

  dds::Entity reader(const dds::Topic& topic);
  dds::Entity writer(const dds::Topic& topic);
  void take_status();
  std::vector<std::string> candidates() const;
  void open_writers(const std::string& source);
  bool daemon_hears(dds_entity_t writer) const;
  void await_match(dds_entity_t writer, Clock::time_point until);
  void await_answer(Clock::time_point until);
  Failure unreachable() const;
  template <class Sample>
  std::optional<Sample> take(dds_entity_t reader);

  Options options_;
  Waker waker_;  // before any entity
  dds::Participant participant_;
  dds::Entity status_reader_, ack_reader_, event_reader_, timing_reader_, statistics_reader_,
      parameter_reader_, telemetry_reader_;
  dds::Entity command_writer_, heartbeat_writer_;

  std::map<std::string, Seen> seen_;
  const Vehicle* vehicle_ = nullptr;
  std::string vehicle_id_;
  Clock::time_point status_time_{};
  bool left_ = false;
  std::string source_;
  Sequence sequence_;
  std::uint64_t heartbeats_ = 0;
  std::vector<std::max_align_t> sample_;  // of telemetry
  std::uint64_t telemetry_count_ = 0;
};

}  // namespace lss::cli
