#pragma once

// Answers the requests of an OBC that polls (docs/decisions/0018-socket-for-an-obc-that-polls.md):
// one reply for each line, none unasked. No request waits for another. Main thread; run() ends by
// Ctrl-C or SIGTERM, or with a Failure when the daemon is gone.

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <string>

#include "tools/lss-cli/obc/socket.h"
#include "tools/lss-cli/session/context.h"
#include "tools/lss-cli/session/emergency.h"

namespace lss::cli {

// One command of the vehicle: its name and parameters, as the verb of that name has them. What is
// only an option of lss-cli (--for, --hold, --stay) is a Failure, as are verbs of several commands.
Invocation read_polled(const Vehicle& vehicle, std::span<const std::string> words);

class PollServer {
 public:
  PollServer(Context& context, obc::Socket& socket);
  void run();

 private:
  enum class Wait : std::uint8_t { none, acknowledgement, status, telemetry, stop };
  // A request, from its arrival until it is the oldest of many commands, or of many others.
  struct Asked {
    std::uint32_t sequence = 0;
    std::string line;   // as received
    std::string reply;  // empty: not yet
    Wait wait = Wait::none;
    Clock::time_point until{};  // then there is an error instead
    int repeated = 0;           // while it waited
    bool stops = false;
    // Of commands:
    const CommandInfo* info = nullptr;
    std::uint64_t seq = 0;  // 0: none was sent
    Clock::time_point sent{};
    std::int64_t sent_ns = 0;  // the daemon's time in its last status before
    std::optional<lss_CommandAck> ack{};
    std::uint64_t samples = 0;  // of telemetry, before
  };

  void turn(bool input);
  void take(const obc::Lines::Line& line, bool late);
  void make_room();
  void refuse(const std::string& why);
  void perform(Asked& asked, const std::string& words, bool late);
  void command(Asked& asked, std::span<const std::string> words);
  void stop(Asked& asked);
  nlohmann::json result_of(const std::string& sequence) const;
  void heard(const lss_CommandAck& ack);
  void take_answers();
  void check(Asked& asked);
  void answer(Asked& asked, nlohmann::json document);
  void fail(Asked& asked, const Failure& failure);
  void check_daemon() const;
  Link& link() { return context_.link(); }
  const Vehicle& vehicle() { return link().vehicle(); }
  nlohmann::json command_json(const Asked& asked) const;
  nlohmann::json stopped_json();
  nlohmann::json packet();

  Context& context_;
  obc::Socket& socket_;
  std::deque<Asked> asked_;  // of this connection, the oldest first
  std::optional<EmergencyStop> stop_;
  Clock::time_point stop_until_{}, turned_{}, next_{};
  std::int64_t last_ack_ns_ = 0;
  std::uint64_t requests_ = 0, repeats_ = 0, refused_ = 0, late_ = 0;
};

}  // namespace lss::cli
