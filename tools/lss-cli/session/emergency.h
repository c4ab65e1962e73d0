#pragma once

// The emergency stop of one vehicle or of every vehicle on the domain: sent as soon as a reader of
// commands is matched, again for each new reader, and repeatedly until each addressed daemon has
// completed it, regardless of other answers. Main thread; bounded.

#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/lss-cli/session/link.h"

namespace lss::cli {

// The answer of one daemon.
struct Stopped {
  std::string vehicle_id;   // empty: it did not say its name
  lss_Instance instance{};  // as far as its status was received
  bool fell = false;        // it was in the air
  bool answered = false;
  lss_CommandAck ack{};  // the last one, or the first completed one
  double after_s = 0;    // from the first command sent to the last answer

  bool completed() const { return answered && ack.phase == lss_PHASE_COMPLETED; }
};

class EmergencyStop {
 public:
  // `vehicle_id`: kEveryVehicle for all.
  EmergencyStop(Link& link, std::string vehicle_id);

  // Other work while waiting.
  struct Hooks {
    std::function<void()> turn;                         // at least ten times a second
    std::function<void(const lss_CommandAck&)> answer;  // any to the source of the link
  };
  // Until all addressed daemons have completed it, or the time is over. Ctrl-C: Interrupted.
  void run(double longest_s, const Hooks& hooks);
  // One turn without waiting: sends it when due and takes all answers. Returns the time of the next
  // turn; nothing when all addressed daemons have completed it. Calls hooks.answer only.
  std::optional<Clock::time_point> step(const Hooks& hooks);

  // One for each addressed daemon that is known; by name.
  std::vector<Stopped> results() const;

 private:
  bool is_for_all() const { return vehicle_id_ == dds::kEveryVehicle; }
  bool is_meant(std::string_view vehicle_id) const;
  void send();
  void take_acks(const Hooks& hooks);
  void take_status();
  bool is_done() const;
  bool is_under_way() const;

  Link& link_;
  std::string vehicle_id_;
  Invocation command_;
  Lull lull_;
  std::uint64_t first_ = 0;                     // sequence number
  Clock::time_point sent_{}, last_{}, next_{};  // the first one, the newest, the one to come
  double repeat_s_ = 1;                         // until the next one
  std::vector<dds_instance_handle_t> hearers_;
  std::map<Guid, Stopped> all_;
};

// As an entry of `commands` in documents of lss-cli.
nlohmann::json to_json(const Stopped& stopped, const std::string& source);

}  // namespace lss::cli
