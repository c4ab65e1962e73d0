#pragma once

// A conversation with one vehicle: commands with their acknowledgements, the heartbeat that keeps
// the lease, and the effect of Ctrl-C and of a daemon that has ended. Every wait goes through
// pump(). Main thread only; every wait is bounded. Errors are thrown: Failure with the exit code,
// Interrupted for Ctrl-C.

#include <cstdint>
#include <deque>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/lss-cli/session/link.h"
#include "tools/lss-cli/show/output.h"

namespace lss::cli {

// One command that was sent, and its result.
struct Sent {
  Invocation command;
  std::uint64_t seq = 0;
  bool answered = false;
  bool executing = false;
  lss_CommandAck ack{};  // the last one
  Clock::time_point sent{}, heard{};
  std::int64_t sent_ns = 0;  // the daemon's time in its last status before

  bool over() const {
    return answered && ack.phase != lss_PHASE_ACCEPTED && ack.phase != lss_PHASE_EXECUTING;
  }
};

class Session {
 public:
  Session(Link& link, Output& output, const Options& options);

  Link& link() { return link_; }
  const Link& link() const { return link_; }
  const Vehicle& vehicle() const { return link_.vehicle(); }

  // From here on uses the simulated time of lss-sim in that folder. Call before the first command.
  void take_part(const std::string& folder);
  lockstep::Client* simulation() { return link_.simulation(); }  // nullptr: real time

  // Each waits for the phase of its name and throws when it ends otherwise.
  const Sent& accept(const Invocation& command);
  const Sent& begin(const Invocation& command);
  // `takes_s`: how long it takes by itself, when that is known.
  const Sent& complete(const Invocation& command, double takes_s = 0);
  // Sends many commands without a report for each, several at a time. where(i) is the start of the
  // error text of one.
  void complete_all(const std::vector<Invocation>& commands,
                    const std::function<std::string(std::size_t)>& where);
  // Only checks whether it would be accepted.
  void dry_run(const Invocation& command);
  // Stop, lie down, motors off, with progress; does nothing when nothing moves. When its outcome is
  // unknown, the heartbeat ends, so that the lease stops the vehicle, and the next call sends it
  // again. A Ctrl-C during this ends at once with timed_out.
  void safe_stop(const std::string& why);
  // The same by `command`, which has its own end; by a stop when it is rejected.
  void end_by(const Invocation& command, const std::string& why);

  // The status, not older than the last acknowledgement.
  const lss_Status& status();
  // The newest telemetry; requests a sample when none arrives by itself. nullptr when there is
  // none.
  const void* telemetry();
  void open_telemetry() { link_.open_telemetry(); }

  // Waits for news or `until`; sends the heartbeat when this session has a lease, or always with
  // beat().
  void pump(Clock::time_point until) { pump_input(until, -1); }
  bool pump_input(Clock::time_point until, int input_fd);  // true: input_fd has something
  // Until it commands, of the source that --detach uses.
  void beat();
  // For callers with their own wait: sends the heartbeat and takes acknowledgements to this source.
  void beat_when_due();
  void heard(const lss_CommandAck& ack);
  // A motion command of this session is active, as far as is known.
  bool attached() const { return attached_; }
  bool has_left() const { return has_left_; }  // at once, by a second Ctrl-C
  // Throws when the command failed or the vehicle left Operational by itself.
  void check(const Sent& command);
  void check_operational();
  // Throws when the last command has failed, or an emergency has occurred.
  void check_in_force();

  // The text of the progress line, requested ten times a second.
  void set_progress(std::function<std::string()> text) { progress_ = std::move(text); }

  // Of every command so far.
  nlohmann::json report() const;
  std::size_t commands() const { return sent_.size(); }

 private:
  void open();
  Sent& submit(const Invocation& command, std::uint16_t flags, bool quiet = false);
  void await(Sent& sent, const char* phase, bool (*done)(const Sent&), double takes_s = 0);
  void take_acks();
  void check_daemon();
  void check_name(const Invocation& command);
  [[noreturn]] void fail(const Sent& sent);
  [[noreturn]] void left_at_once();
  std::string faults();
  nlohmann::json to_json(const Sent& sent) const;
  void show(const Sent& sent);

  Link& link_;
  Output& output_;
  Options options_;
  std::deque<Sent> sent_;   // references stay valid
  std::deque<Sent> quiet_;  // not part of the report
  bool attached_ = false, beating_ = false, has_left_ = false, warned_ = false;
  std::int64_t last_ack_ns_ = 0;
  Clock::time_point next_beat_{}, next_progress_{};
  std::function<std::string()> progress_;
};

}  // namespace lss::cli
