#include "drivers/canopen/master.h"

#include <algorithm>
#include <bit>

namespace lss::canopen {
namespace {

// States that need a reset or configuration of the node, which may have to wait.
bool waits_for_leave(NodeState state) {
  switch (state) {
    case NodeState::missing:
    case NodeState::wrong_device:
    case NodeState::failed:
    case NodeState::lost:
    case NodeState::rebooted:
    case NodeState::fallen_back: return true;
    default: return false;
  }
}

}  // namespace

Master::Master(const MasterParameters& parameters) noexcept : parameters_(parameters) {
  index_.fill(kMaxNodes);
  for (const NodeParameters& node : parameters_.nodes) {
    if (node.node == 0) break;
    Node& n = nodes_[count_];
    n.parameters = node;
    n.configuration = Configuration(node, parameters_.heartbeat);
    n.sdo = SdoClient(node.node, parameters_.sdo_timeout_ns, parameters_.sdo_attempts);
    const bool free = node.node <= kMaxNode && node.node != parameters_.heartbeat.master &&
                      index_[node.node] == kMaxNodes;
    fit_ = fit_ && free && n.configuration.complete();
    if (free) index_[node.node] = static_cast<std::uint8_t>(count_);
    ++count_;
  }
  if (!fit_) count_ = 0;
  restart(0, 0);
}

void Master::restart(TimeNs now, TimeNs reset_at) noexcept {
  for (std::size_t i = 0; i < count_; ++i) {
    Node& node = nodes_[i];
    node.sdo.cancel();
    node.nmt_due = false;
    node.window_frames = node.storm_emcys = 0;
    node.status.nmt = NmtState::unknown;
    node.status.emcy_storm = false;
    enter(node, NodeState::off, now, reset_at);
  }
  rpdos_due_ = 0;
  sample_count_ = 0;
  heartbeat_ns_ = now;
  sync_ns_ = parameters_.sync_period_ns > 0 ? now : kNever;
  last_sync_ns_ = now - parameters_.sync_period_ns;
}

// A node that was operational is until its heartbeats say otherwise; one that was just being booted
// is lost until then.
void Master::take_over(std::size_t node, const NodeStatus& said, TimeNs now) noexcept {
  if (node >= count_) return;
  Node& n = nodes_[node];
  n.status = said;
  if (said.state == NodeState::operational) {
    enter(n, said.state, now, now + parameters_.heartbeat.lost_after_ns());
  } else {
    enter(n, waits_for_leave(said.state) ? said.state : NodeState::lost, now, now);
  }
}

void Master::enter(Node& node, NodeState state, TimeNs now, TimeNs deadline) noexcept {
  if (node.status.state != state) node.status.since_ns = now;
  node.status.state = state;
  node.deadline_ns = deadline;
  quiet_ns_ = std::min(quiet_ns_, deadline);
}

void Master::command(Node& node, Nmt nmt) noexcept {
  node.nmt = nmt;
  node.nmt_due = true;
  quiet_ns_ = kAlways;
}

void Master::boot(Node& node, Nmt how, TimeNs now) noexcept {
  node.sdo.cancel();
  command(node, how);
  enter(node, NodeState::booting, now, now + parameters_.boot_timeout_ns);
}

void Master::reset(std::size_t node, TimeNs now) noexcept {
  if (node < count_) boot(nodes_[node], Nmt::reset_node, now);
}

void Master::identify(Node& node, TimeNs now) noexcept {
  node.nmt_due = false;
  node.sdo.read(kDeviceType, 0);
  quiet_ns_ = kAlways;
  enter(node, NodeState::identifying, now);
}

void Master::fail(Node& node, TimeNs now) noexcept {
  node.sdo.cancel();
  node.status.failed_entry = {};
  node.status.abort_code = 0;
  enter(node, NodeState::failed, now, now + parameters_.retry_ns);
}

// Handles the result of the last SDO transfer.
void Master::sdo_over(Node& node, TimeNs now) noexcept {
  const SdoClient::Result result = node.sdo.result();
  if (result != SdoClient::Result::done && result != SdoClient::Result::aborted) return;
  const bool identifies = node.status.state == NodeState::identifying;
  if (!identifies && node.status.state != NodeState::configuring) return;
  const bool absent =
      result == SdoClient::Result::aborted && !identifies && node.sdo.entry().optional &&
      (node.sdo.abort_code() == kAbortNoObject || node.sdo.abort_code() == kAbortNoSub);
  if (result == SdoClient::Result::aborted && !absent) {
    node.status.failed_entry = node.sdo.entry();
    node.status.abort_code = node.sdo.abort_code();
    enter(node, NodeState::failed, now, now + parameters_.retry_ns);
    return;
  }
  if (identifies) {
    node.status.found_type = node.sdo.value();
    if (node.status.found_type != node.parameters.device_type) {
      enter(node, NodeState::wrong_device, now, now + parameters_.wrong_device_retry_ns);
      return;
    }
    node.step = 0;
    enter(node, NodeState::configuring, now);
  } else {
    ++node.step;
  }
  const std::span<const Entry> entries = node.configuration.entries();
  if (node.step < entries.size()) {
    quiet_ns_ = kAlways;
    return node.sdo.write(entries[node.step]);
  }
  command(node, Nmt::start);
  enter(node, NodeState::starting, now, now + parameters_.start_timeout_ns);
}

void Master::deadline_over(Node& node, TimeNs now) noexcept {
  switch (node.status.state) {
    case NodeState::off:
    case NodeState::lost:  // an enabled drive and outputs keep their state
      return boot(node, Nmt::reset_communication, now);
    case NodeState::missing:
    case NodeState::failed: return boot(node, Nmt::reset_node, now);
    case NodeState::booting:
      return enter(node, NodeState::missing, now, now + parameters_.retry_ns);
    case NodeState::wrong_device:
    case NodeState::rebooted:
    case NodeState::fallen_back: return identify(node, now);
    case NodeState::starting: return fail(node, now);
    case NodeState::operational:
      ++node.status.losses;
      return enter(node, NodeState::lost, now, now + parameters_.retry_ns);
    case NodeState::babbling:
      return enter(node, node.was_operational ? NodeState::lost : NodeState::missing, now,
                   now + parameters_.retry_ns);
    case NodeState::identifying:  // their SDO transfers have time-outs of their own
    case NodeState::configuring: return;
  }
}

// The node is not yet allowed to leave its state.
bool Master::waits(const Node& node) const noexcept {
  const bool resumes = resume_allowed_ && node.status.state == NodeState::fallen_back;
  return !boot_allowed_ && !resumes && waits_for_leave(node.status.state);
}

bool Master::needs_care(const Node& node, TimeNs now) noexcept {
  return node.nmt_due || node.sdo.busy() || node.status.emcy_storm || now >= node.deadline_ns;
}

void Master::advance(Node& node, TimeNs now) noexcept {
  if (node.status.emcy_storm && now - node.storm_ns >= 2 * kSecond) node.status.emcy_storm = false;
  if (now < node.deadline_ns) return;
  if (waits(node)) return;
  node.deadline_ns = kNever;
  deadline_over(node, now);
}

void Master::sync_at(TimeNs next) noexcept {
  const TimeNs period = parameters_.sync_period_ns;
  if (period <= 0) return;
  const TimeNs earliest = last_sync_ns_ + period / 2;  // never two for one frame
  const TimeNs away = (next - earliest) % period;
  sync_ns_ = earliest + (away < 0 ? away + period : away);
}

void Master::send_rpdo(std::size_t node, int number, std::span<const std::uint8_t> data) noexcept {
  if (node >= count_ || number < 1 || number > kMaxPdos) return;
  const auto n = static_cast<std::size_t>(number - 1);
  Outgoing& rpdo = nodes_[node].rpdo[n];
  rpdo.size = static_cast<std::uint8_t>(std::min(data.size(), rpdo.data.size()));
  std::copy_n(data.begin(), rpdo.size, rpdo.data.begin());
  rpdos_due_ |= std::uint64_t{1} << (node * kMaxPdos + n);
}

bool Master::transmit_rpdo(CanFrame& frame) noexcept {
  if (rpdos_due_ == 0) return false;
  const auto first = static_cast<std::size_t>(std::countr_zero(rpdos_due_));
  rpdos_due_ &= rpdos_due_ - 1;
  const Node& node = nodes_[first / kMaxPdos];
  const std::size_t n = first % kMaxPdos;
  frame.id = kRpdo1 + static_cast<std::uint32_t>(n) * kPdoStep + node.parameters.node;
  frame.size = node.rpdo[n].size;
  frame.data = node.rpdo[n].data;
  return true;
}

bool Master::transmit_sync(TimeNs now, CanFrame& frame) noexcept {
  if (now < sync_ns_) return false;
  const TimeNs late = (now - sync_ns_) / parameters_.sync_period_ns;
  counters_.syncs_skipped += static_cast<std::uint64_t>(late);
  last_sync_ns_ = sync_ns_ + late * parameters_.sync_period_ns;
  sync_ns_ = last_sync_ns_ + parameters_.sync_period_ns;
  ++counters_.syncs;
  frame.id = kSync;
  return true;
}

bool Master::transmit_heartbeat(TimeNs now, CanFrame& frame) noexcept {
  if (now < heartbeat_ns_) return false;
  heartbeat_ns_ += parameters_.heartbeat.period_ns;
  if (heartbeat_ns_ <= now) heartbeat_ns_ = now + parameters_.heartbeat.period_ns;
  frame.id = kHeartbeat + parameters_.heartbeat.master;
  frame.size = 1;
  frame.data[0] = static_cast<std::uint8_t>(NmtState::operational);
  return true;
}

bool Master::transmit(TimeNs now, CanFrame& frame) noexcept {
  frame = {};
  transmitted_ns_ = now;
  const bool sends = transmit_rpdo(frame) || transmit_sync(now, frame) ||
                     transmit_heartbeat(now, frame) || (now >= quiet_ns_ && care(now, frame));
  frame.time_ns = now;
  if (sends) ++counters_.frames_sent;
  return sends;
}

// True: a frame of a node is to be sent.
bool Master::care(TimeNs now, CanFrame& frame) noexcept {
  bool sends = false;
  for (std::size_t i = 0; i < count_ && !sends; ++i) {
    Node& node = nodes_[i];
    if (!needs_care(node, now)) continue;
    advance(node, now);
    if (node.nmt_due) {
      node.nmt_due = false;
      frame.id = kNmt;
      frame.size = 2;
      frame.data[0] = static_cast<std::uint8_t>(node.nmt);
      frame.data[1] = node.parameters.node;
      sends = true;
    } else {
      sends = node.sdo.transmit(now, frame);
      sdo_over(node, now);
    }
  }
  quiet_ns_ = sends ? kAlways : kNever;
  for (std::size_t i = 0; i < count_ && !sends; ++i) {
    const Node& node = nodes_[i];
    const bool at_once = node.nmt_due || node.sdo.busy() || node.status.emcy_storm;
    quiet_ns_ = std::min(quiet_ns_, at_once ? kAlways : waits(node) ? kNever : node.deadline_ns);
  }
  return sends;
}

TimeNs Master::next_wake() const noexcept {
  if (rpdos_due_ != 0) return kAlways;
  TimeNs wake = std::min(sync_ns_, heartbeat_ns_);
  if (quiet_ns_ > transmitted_ns_) return std::min(wake, quiet_ns_);
  for (std::size_t i = 0; i < count_; ++i) {
    const Node& node = nodes_[i];
    if (node.nmt_due) return kAlways;
    if (node.sdo.busy()) wake = std::min(wake, node.sdo.next_wake());
    if (!waits(node)) wake = std::min(wake, node.deadline_ns);
  }
  return wake;
}

}  // namespace lss::canopen
