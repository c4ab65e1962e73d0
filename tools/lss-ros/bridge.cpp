#include "tools/lss-ros/bridge.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "idl/codes.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::ros {
namespace {

using cli::Clock;
using cli::seconds;
using std::chrono::milliseconds;

// Source of the commands of a node. With DDS Security it is in the name of the certificate.
std::string source_of(const dds::Participant& ours, const std::string& node) {
  std::string source = (ours.enclave() ? ours.enclave()->name : "ros2") + ":" + node;
  source.resize(std::min(source.size(), sizeof lss_Command::source - 1));
  return source;
}
constexpr const char* kCalls[] = {"stop", "estop", "solve", "start"};
constexpr milliseconds kTurn{100};
constexpr double kAfterStart_s = 10;  // the lease is kept for the first cmd_vel
constexpr double kCallLimit_s = 120;
constexpr double kProbe_s = 10;
constexpr std::size_t kMostCalls = 100, kMostSources = 16;

std::int64_t utc_now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

const char* velocity_type(const BridgeOptions& options) {
  return options.stamped ? "geometry_msgs/msg/TwistStamped" : "geometry_msgs/msg/Twist";
}

}  // namespace

Bridge::Bridge(cli::Link& link, dds_entity_t ros, const dds::Participant& ours,
               const BridgeOptions& options)
    : link_(link),
      ours_(ours),
      own_(source_of(ours, "lss_ros")),
      options_(options),
      vehicle_id_(cli::text(link.status().vehicle_id)),
      converter_(
          link.vehicle(), vehicle_id_,
          [this](std::size_t channel, const Message& message) { node_.write(channel, message); }),
      node_(ros, "/" + ros_name(vehicle_id_), "lss_ros", options.distro),
      commander_(ours, vehicle_id_, options.lease_ms),
      driver_(link.vehicle(), commander_, options) {
  const std::string space = "/" + ros_name(vehicle_id_) + "/";
  for (const Channel& channel : converter_.channels()) node_.add_writer(channel);
  node_.add_reader(space + "cmd_vel", velocity_type(options));
  for (const char* name : kCalls) node_.add_service(space + name);
  node_.announce();
  link_.open_events();
  link_.open_telemetry();
  if (const cli::Vehicle& vehicle = link.vehicle(); vehicle.telemetry != nullptr) {
    telemetry_reader_ = cli::checked(
        dds::create_reader(ours.get(), dds::telemetry_topic(vehicle.name, vehicle.telemetry),
                           dds::Transport::best, node_.listener()));
  }
  sources_.emplace_back(own_);
  await_answer();
}

// Until a request without effect was answered: commands and answers before the match are lost.
void Bridge::await_answer() {
  const cli::Invocation probe = cli::with_defaults(cli::common_command(CommandKind::request_data));
  for (const Clock::time_point until = Clock::now() + seconds(kProbe_s); Clock::now() < until;) {
    commander_.send(probe, own_, kFlagDryRun);
    if (link_.wait(Clock::now() + kTurn).interrupted) throw cli::Interrupted();
    if (commander_.next_ack()) return;
  }
  throw cli::Failure(cli::ExitCode::unreachable, vehicle_id_ + " does not answer commands",
                     "check the log of lssd");
}

void Bridge::take_velocity() {
  while (const std::optional<Node::Received> received = node_.next()) {
    std::optional<geometry_msgs::Twist> twist;
    if (!options_.stamped) {
      twist = from_cdr<geometry_msgs::Twist>(received->cdr);
    } else if (const auto stamped = from_cdr<geometry_msgs::TwistStamped>(received->cdr)) {
      twist = stamped->twist;
    }
    if (!twist) continue;
    const lss_Status& status = link_.status();
    const std::string node = node_.node_of(received->writer);
    const bool named = !node.empty() && cli::text(status.authority) != own_;
    const std::string source = named ? source_of(ours_, node) : own_;
    if (std::ranges::count(sources_, source) == 0) {
      if (sources_.size() >= kMostSources) sources_.erase(sources_.begin() + 1);
      sources_.push_back(source);
    }
    held_until_ = {};
    driver_.wanted({twist->linear.x, twist->angular.z}, source, status);
  }
}

// A ROS call may end what a ROS node began.
std::string Bridge::source_of_calls() {
  const std::string holder(cli::text(link_.status().authority));
  return std::ranges::count(sources_, holder) > 0 ? holder : own_;
}

void Bridge::send(Pending& pending) {
  constexpr CommandKind kKinds[] = {CommandKind::stop, CommandKind::emergency_stop,
                                    CommandKind::solve, CommandKind::start};
  const auto kind = static_cast<std::uint16_t>(kKinds[static_cast<std::size_t>(pending.call)]);
  pending.seq = commander_.send(cli::with_defaults(cli::find_command(link_.vehicle(), kind)),
                                source_of_calls());
  if (pending.first == 0) pending.first = pending.seq;
  pending.again = Clock::now() + kTurn;
}

void Bridge::take_requests() {
  while (const std::optional<Node::Request> request = node_.next_request()) {
    if (pending_.size() >= kMostCalls) {
      if (static_cast<Call>(request->service) != Call::estop) {
        node_.reply(*request, false, "too many calls at a time");
        continue;
      }
      node_.reply(pending_.front().request, false, "gave way to an emergency stop");
      pending_.pop_front();
    }
    Pending& pending = pending_.emplace_back();
    pending.request = *request;
    pending.call = static_cast<Call>(request->service);
    pending.until = Clock::now() + seconds(kCallLimit_s);
    send(pending);
    if (pending.call == Call::start) held_until_ = Clock::now() + seconds(kAfterStart_s);
  }
}

// An emergency stop is sent until one is completed (docs/dds.md).
void Bridge::step_calls() {
  std::erase_if(pending_, [this](const Pending& one) {
    const bool late = Clock::now() >= one.until;
    if (late) node_.reply(one.request, false, "the daemon did not answer in time");
    return late;
  });
  for (Pending& one : pending_)
    if (one.call == Call::estop && Clock::now() >= one.again) send(one);
  if (Clock::now() < held_until_) commander_.heartbeat(source_of_calls());
}

void Bridge::take_acks() {
  while (const std::optional<lss_CommandAck> ack = commander_.next_ack()) {
    if (std::ranges::count(sources_, cli::text(ack->source)) == 0) continue;
    driver_.heard(*ack);
    if (ack->phase == lss_PHASE_ACCEPTED || ack->phase == lss_PHASE_EXECUTING) continue;
    const bool done = ack->phase == lss_PHASE_COMPLETED;
    std::erase_if(pending_, [&](const Pending& one) {
      const bool is_stop = one.call == Call::estop;
      const bool ours =
          is_stop ? done && ack->kind == 3 && ack->seq >= one.first : ack->seq == one.seq;
      if (ours) node_.reply(one.request, done, std::string(cli::text(ack->text)));
      return ours;
    });
  }
}

void Bridge::report() {
  const std::string trouble = driver_.trouble();
  if (trouble == reported_) return;
  reported_ = trouble;
  converter_.report(trouble, utc_now_ns());
  if (!trouble.empty()) fmt::print(stderr, "lss-ros: {}\n", trouble);
  last_status_ns_ = 0;  // the diagnostics have it at once
}

// vehicle_id is the first member of every type.
bool Bridge::is_ours(std::span<const std::byte> cdr) const {
  char id[sizeof lss_Status::vehicle_id] = {};
  std::memcpy(id, cdr.data() + kCdrHeader, std::min(sizeof id, cdr.size() - kCdrHeader));
  return cli::text(id) == vehicle_id_;
}

void Bridge::take() {
  node_.take_news();
  const lss_Status& status = link_.status();
  const void* sample = link_.telemetry();
  const bool lost = link_.daemon_lost();
  // Who shows diagnostics misses them after some seconds; at rest the status comes less often.
  if (status.time_ns != last_status_ns_ || (!lost && Clock::now() >= diagnose_at_)) {
    last_status_ns_ = status.time_ns;
    diagnose_at_ = Clock::now() + seconds(1);
    converter_.status(status, sample);
  }
  dds_sample_info_t info{};
  for (auto cdr = take_cdr(telemetry_reader_, info); !cdr.empty();
       cdr = take_cdr(telemetry_reader_, info))
    if (is_ours(cdr) && ours_.is_by_vehicle(vehicle_id_, telemetry_reader_.get(), info))
      converter_.telemetry(cdr);
  while (const std::optional<lss_Event> event = link_.next_event()) converter_.event(*event);
  node_.take_graph();
  take_acks();
  take_velocity();
  take_requests();
  driver_.step(status);
  step_calls();
  report();
  if (lost && Clock::now() >= lost_at_) {
    converter_.lost(utc_now_ns());
    lost_at_ = Clock::now() + seconds(1);
  }
}

bool Bridge::run(const std::function<void()>& turn) {
  const std::string version(cli::text(link_.status().version));
  const std::string kind(cli::text(link_.status().vehicle));
  while (true) {
    turn();
    take();
    const lss_Status& status = link_.status();
    if (cli::text(status.version) != version || cli::text(status.vehicle) != kind) return false;
    if (link_.wait(Clock::now() + kTurn, node_.news_fd()).interrupted) return true;
  }
}

}  // namespace lss::ros
