#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/lss-cli/session/wire.h"
#include "tools/lss-ros/bridge.h"

namespace lss::ros {
namespace {

using cli::Clock;
using cli::Invocation;
using std::chrono::milliseconds;

constexpr milliseconds kBetweenCommands{100};
constexpr milliseconds kAfterRefusal{1000};
constexpr milliseconds kTroubleShown{3000};

bool is_same(const Invocation& a, const Invocation& b) {
  return a.info->kind == b.info->kind && a.parameter == b.parameter;
}

}  // namespace

Driver::Driver(const cli::Vehicle& vehicle, Commander& commander, const BridgeOptions& options)
    : vehicle_(vehicle),
      commander_(commander),
      starts_(options.cmd_vel_starts),
      lease_(milliseconds(options.lease_ms)) {}

void Driver::refuse(const std::string& why) {
  trouble_ = why;
  refused_at_ = Clock::now();
  not_before_ = refused_at_ + kAfterRefusal;
}

std::string Driver::trouble() const {
  return Clock::now() - refused_at_ < kTroubleShown ? trouble_ : "";
}

std::optional<Invocation> Driver::command_for(const Velocity& velocity, const lss_Status& status) {
  resting_ = velocity.ahead_m_s == 0 && velocity.turn_rad_s == 0;
  if (resting_) {
    if (status.state != lss_STATE_OPERATIONAL) return std::nullopt;
    return cli::with_defaults(cli::find_command(vehicle_, vehicle_.rest));
  }
  const Face* face = find_face(vehicle_.name);
  if (!std::isfinite(velocity.ahead_m_s) || !std::isfinite(velocity.turn_rad_s)) {
    refuse("cmd_vel is refused: it is not a finite number");
  } else if (face == nullptr || face->command == nullptr) {
    refuse(fmt::format("cmd_vel is refused: {} is not driven by velocity", vehicle_.name));
  } else if (const auto command = face->command(velocity, vehicle_)) {
    return *command;
  } else {
    refuse("cmd_vel is refused: " + command.error());
  }
  return std::nullopt;
}

void Driver::wanted(const Velocity& velocity, const std::string& source, const lss_Status& status) {
  if (source != source_ && !is_silent() && sent_ && !sent_->over) {
    trouble_ = fmt::format("cmd_vel of {} is refused: {} drives", source, source_);
    refused_at_ = Clock::now();
    return;
  }
  if (is_silent()) stopped_ = false;
  source_ = source;
  heard_ = Clock::now();
  wanted_ = command_for(velocity, status);
  step(status);
  // Not for a message that is refused; a vehicle that stands on our order keeps its lease.
  const bool stands = resting_ && cli::text(status.authority) == source_;
  if (wanted_ && sent_ && (!sent_->over || stands)) commander_.heartbeat(source_);
}

void Driver::step(const lss_Status& status) {
  const bool operational = status.state == lss_STATE_OPERATIONAL;
  if (operational_ && !operational && wanted_) stopped_ = true;
  operational_ = operational;
  // A daemon that started since knows nothing of what was sent, and its clock may be behind.
  if (status.instance.started_utc_ns != daemon_ns_) settled_ns_ = 0, sent_.reset();
  daemon_ns_ = status.instance.started_utc_ns;
  if (is_silent()) wanted_.reset(), sent_.reset();
  if (!wanted_ || status.time_ns < settled_ns_) return;
  if (stopped_ && starts_ && !operational) {
    if (!resting_ && Clock::now() >= not_before_)
      refuse("cmd_vel is refused: the vehicle was stopped; pause cmd_vel to start it again");
    return;
  }
  std::vector<Invocation> steps;
  if (operational || starts_) steps = vehicle_.prepare(status, *wanted_);
  const Invocation& next = steps.empty() ? *wanted_ : steps.front();
  if (sent_ && !sent_->over && sent_->is_step && !resting_) return;
  if (sent_ && is_same(sent_->command, next) && (!sent_->over || operational)) return;
  const bool refused = Clock::now() - refused_at_ < kAfterRefusal;
  if (Clock::now() < not_before_ && (refused || !resting_)) return;
  sent_ = {commander_.send(next, source_), next, false, !steps.empty()};
  not_before_ = Clock::now() + kBetweenCommands;
}

void Driver::heard(const lss_CommandAck& ack) {
  if (!sent_ || ack.seq != sent_->seq || cli::text(ack.source) != source_) return;
  if (ack.phase == lss_PHASE_ACCEPTED || ack.phase == lss_PHASE_EXECUTING) return;
  settled_ns_ = ack.time_ns;
  sent_->over = true;
  if (ack.phase == lss_PHASE_COMPLETED) return;
  if (ack.phase != lss_PHASE_SUPERSEDED)
    refuse(fmt::format("cmd_vel is refused: {}", cli::text(ack.text)));
  sent_.reset();
}

}  // namespace lss::ros
