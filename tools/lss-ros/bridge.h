#pragma once

// One vehicle as a ROS node: publishes what its daemon publishes, drives it by cmd_vel, and offers
// services. A client of the daemon like lss-cli: authority, lease and guards are the daemon's. One
// thread; every wait is bounded. Errors are thrown as a Failure.

#include <deque>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/lss-cli/session/link.h"
#include "tools/lss-ros/commander.h"
#include "tools/lss-ros/converter.h"
#include "tools/lss-ros/node.h"

namespace lss::ros {

struct BridgeOptions {
  int ros_domain = 0;
  std::vector<std::string> interfaces = {"lo"};
  Distro distro = Distro::iron;
  bool stamped = false;         // cmd_vel is a TwistStamped
  bool cmd_vel_starts = false;  // starts the vehicle where that is needed
  std::uint32_t lease_ms = 500;
};

// Drives by velocities. A message is obeyed for the lease; without another one the daemon ends it.
class Driver {
 public:
  Driver(const cli::Vehicle& vehicle, Commander& commander, const BridgeOptions& options);

  void wanted(const Velocity& velocity, const std::string& source, const lss_Status& status);
  void heard(const lss_CommandAck& ack);
  // Sends what is due.
  void step(const lss_Status& status);
  // The last refusal; empty: none lately.
  std::string trouble() const;

 private:
  using Time = cli::Clock::time_point;
  struct Sent {
    std::uint64_t seq;
    cli::Invocation command;
    bool over, is_step;
  };
  std::optional<cli::Invocation> command_for(const Velocity& velocity, const lss_Status& status);
  void refuse(const std::string& why);
  bool is_silent() const { return cli::Clock::now() - heard_ > lease_; }

  const cli::Vehicle& vehicle_;
  Commander& commander_;
  bool starts_;
  cli::Clock::duration lease_;
  std::string source_;
  std::optional<cli::Invocation> wanted_;
  std::optional<Sent> sent_;
  bool resting_ = false;                         // wanted: standstill
  bool operational_ = false;                     // at the last step
  bool stopped_ = false;                         // by others: not again before a pause
  std::int64_t settled_ns_ = 0, daemon_ns_ = 0;  // daemon_ns_: its start, UTC
  Time heard_{}, not_before_{}, refused_at_{};
  std::string trouble_;
};

class Bridge {
 public:
  // The participants of ROS' domain and of the vehicle's must outlive it, and so must the link.
  Bridge(cli::Link& link, dds_entity_t ros, const dds::Participant& ours,
         const BridgeOptions& options);

  // Until Ctrl-C. Returns false when the daemon came back as another one: begin again. `turn`:
  // called often.
  bool run(const std::function<void()>& turn);

 private:
  enum class Call { stop, estop, solve, start };
  struct Pending {
    Node::Request request;
    Call call;
    std::uint64_t seq = 0, first = 0;
    cli::Clock::time_point until{}, again{};
  };

  void take();
  void take_velocity();
  void take_requests();
  void take_acks();
  void send(Pending& pending);
  void step_calls();
  std::string source_of_calls();
  void await_answer();
  void report();
  bool is_ours(std::span<const std::byte> cdr) const;

  cli::Link& link_;
  const dds::Participant& ours_;
  const std::string own_;  // source of this program's commands
  BridgeOptions options_;
  std::string vehicle_id_;
  Converter converter_;
  Node node_;
  Commander commander_;
  Driver driver_;
  std::deque<Pending> pending_;
  std::vector<std::string> sources_;  // that this program has used
  cli::Clock::time_point held_until_{};
  std::int64_t last_status_ns_ = 0;
  dds::Entity telemetry_reader_;
  std::string reported_;
  cli::Clock::time_point lost_at_{}, diagnose_at_{};  // next
};

}  // namespace lss::ros
