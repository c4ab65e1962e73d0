#include "tools/lss-cli/session/emergency.h"

#include <algorithm>

#include "idl/codes.h"
#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/status.h"

namespace lss::cli {
namespace {

constexpr double kRepeat_s = 0.1;
// A daemon hears nothing of a writer that it does not know yet, and nobody here sees when it does:
// soon after a match it is sent again, then ever later. For each that hears it.
constexpr double kFirstRepeat_s = 0.005;
// Where all are executing it: one more would take the place of that.
constexpr double kUnderWay_s = 1;
constexpr double kNamed_s = 1;  // for the status of daemons that have answered

}  // namespace

EmergencyStop::EmergencyStop(Link& link, std::string vehicle_id)
    : link_(link),
      vehicle_id_(std::move(vehicle_id)),
      command_{.info = &common_command(CommandKind::emergency_stop), .parameter = {}} {}

bool EmergencyStop::is_meant(std::string_view vehicle_id) const {
  return is_for_all() || vehicle_id == vehicle_id_;
}

// Every daemon that hears it has it.
bool EmergencyStop::is_under_way() const {
  return all_.size() >= hearers_.size() && std::ranges::all_of(all_, [](const auto& one) {
           const Stopped& stopped = one.second;
           return stopped.answered &&
                  (stopped.ack.phase == lss_PHASE_ACCEPTED ||
                   stopped.ack.phase == lss_PHASE_EXECUTING || stopped.completed());
         });
}

void EmergencyStop::send() {
  last_ = Clock::now();
  const std::uint64_t seq = link_.send_to(vehicle_id_, command_);
  if (first_ != 0) return;
  first_ = seq;
  sent_ = Clock::now();
}

void EmergencyStop::take_acks(const Hooks& hooks) {
  while (const std::optional<Link::Answer> answer = link_.next_answer()) {
    const lss_CommandAck& ack = answer->ack;
    if (hooks.answer) hooks.answer(ack);
    const bool ours = ack.kind == command_.info->kind && first_ != 0 && ack.seq >= first_;
    if (!ours || !is_meant(text(ack.vehicle_id))) continue;
    Stopped& stopped = all_[answer->daemon];
    if (stopped.completed()) continue;
    stopped.vehicle_id = text(ack.vehicle_id);
    stopped.answered = true;
    stopped.ack = ack;
    stopped.fell = stopped.fell || static_cast<Reason>(ack.reason) == Reason::fell;
    stopped.after_s = std::chrono::duration<double>(Clock::now() - sent_).count();
  }
}

void EmergencyStop::take_status() {
  for (const auto& [guid, daemon] : link_.daemons().all()) {
    const std::string_view id = text(daemon.status.vehicle_id);
    if (!daemon.heard || !is_meant(id)) continue;
    Stopped& stopped = all_[guid];
    stopped.vehicle_id = id;
    stopped.instance = daemon.status.instance;
  }
}

// The status names the daemon; it may arrive a little after the acknowledgement.
bool EmergencyStop::is_done() const {
  const Daemons& daemons = link_.daemons();
  const bool present = std::ranges::all_of(daemons.all(), [this](const auto& known) {
    return known.second.heard || all_.contains(known.first);
  });
  const bool accounted = present && (!is_for_all() || daemons.missing() == 0);
  const auto heard = [&](const Guid& guid) {
    const auto known = daemons.all().find(guid);
    return known != daemons.all().end() && known->second.heard;
  };
  const bool named = Clock::now() > sent_ + seconds(kNamed_s) ||
                     std::ranges::all_of(all_, [&](const auto& one) { return heard(one.first); });
  const bool settled = lull_.is_over() || (!is_for_all() && daemons.all_heard());
  return accounted && named && settled && !all_.empty() &&
         std::ranges::all_of(all_, [](const auto& one) { return one.second.completed(); });
}

std::optional<Clock::time_point> EmergencyStop::step(const Hooks& hooks) {
  std::vector<dds_instance_handle_t> hearers = link_.hearers();
  const bool news = hearers != hearers_;
  if (news || Clock::now() >= next_) {
    send();
    const double first_s = kFirstRepeat_s * static_cast<double>(hearers.size());
    repeat_s_ = std::min(news && first_s > 0 ? first_s : 2 * repeat_s_, kRepeat_s);
    hearers_ = std::move(hearers);
    next_ = Clock::now() + seconds(repeat_s_);
  }
  const Clock::time_point look = lull_.step(link_.take(), Clock::now());
  take_acks(hooks);
  take_status();
  if (is_under_way()) next_ = std::max(next_, last_ + seconds(kUnderWay_s));
  if (is_done()) return std::nullopt;
  return std::min(next_, look);
}

void EmergencyStop::run(double longest_s, const Hooks& hooks) {
  const Clock::time_point until = Clock::now() + seconds(longest_s);
  do {  // it is sent, however short the time is
    const std::optional<Clock::time_point> next = step(hooks);
    if (!next) return;
    if (hooks.turn) hooks.turn();
    if (link_.wait(std::min(*next, until)).interrupted) throw Interrupted();
  } while (Clock::now() < until);
}

std::vector<Stopped> EmergencyStop::results() const {
  std::vector<Stopped> list;
  for (const auto& [guid, stopped] : all_) list.push_back(stopped);
  for (const auto& [guid, daemon] : link_.daemons().all()) {
    if (!daemon.heard && is_for_all() && !all_.contains(guid)) list.emplace_back();
  }
  if (is_for_all()) list.resize(list.size() + link_.daemons().missing());
  std::ranges::sort(list, {}, &Stopped::vehicle_id);
  return list;
}

nlohmann::json to_json(const Stopped& stopped, const std::string& source) {
  nlohmann::json result = ack_json(stopped.ack);
  if (!stopped.answered) result["phase"] = "unanswered";
  const CommandInfo& info = common_command(CommandKind::emergency_stop);
  result["command"] = info.name;
  result["kind"] = info.kind;
  result["source"] = source;
  result["seq"] = stopped.answered ? nlohmann::json(stopped.ack.seq) : nlohmann::json();
  result["duration_s"] = stopped.answered ? nlohmann::json(stopped.after_s) : nlohmann::json();
  result["vehicle_id"] = stopped.vehicle_id;
  result["instance"] = instance_json(stopped.instance);
  result["stopped"] = stopped.completed();
  result["airborne"] = stopped.fell;
  return result;
}

}  // namespace lss::cli
