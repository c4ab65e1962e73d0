#pragma once

// The emergency stop of one vehicle or of every vehicle on the domain: sent as soon as anybody
// hears commands, again whenever somebody new does, and again and again until each daemon that is
// meant has completed it, whatever else it answered. Main thread; bounded.

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/lss-cli/link.h"

namespace lss::cli {

// How one daemon took it.
struct Stopped {
  std::string vehicle_id;   // empty: it did not say its name
  lss_Instance instance{};  // as far as its status was heard
  bool fell = false;        // it was in the air
  bool answered = false;
  lss_CommandAck ack{};  // the last one; of the first that was completed
  double after_s = 0;    // the last answer, from the first one that was sent

  bool completed() const { return answered && ack.phase == lss_PHASE_COMPLETED; }
};

class EmergencyStop {
 public:
  // `vehicle_id`: kEveryVehicle for all.
  EmergencyStop(Link& link, std::string vehicle_id);

  // What else goes on meanwhile.
  struct Hooks {
    std::function<void()> turn;                         // ten times a second at least
    std::function<void(const lss_CommandAck&)> answer;  // any to the source of the link
  };
  // Until all that are meant have completed it, or the time is over. Ctrl-C: Interrupted.
  void run(double longest_s, const Hooks& hooks);

  // One for each daemon that is meant and was heard of; by name.
  std::vector<Stopped> results() const;

 private:
  bool is_for_all() const { return vehicle_id_ == dds::kEveryVehicle; }
  bool is_meant(std::string_view vehicle_id) const;
  void send();
  void take_acks(const Hooks& hooks);
  void take_status();
  bool is_done() const;

  Link& link_;
  std::string vehicle_id_;
  Invocation command_;
  Lull lull_;
  std::uint64_t first_ = 0;  // sequence number
  Clock::time_point sent_{};
  std::map<Guid, Stopped> all_;
};

}  // namespace lss::cli
