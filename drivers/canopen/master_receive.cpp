// Received messages of the master.

#include "drivers/canopen/master.h"

namespace lss::canopen {
namespace {

constexpr std::uint32_t kFunction = 0x780, kNode = 0x07F;
constexpr int kStorm = 10;  // EMCYs in a second

// Services of slaves and those that only a master may send; no TIME, no LSS.
constexpr std::array<CanFilter, 6> kFilters = {{{0x000, 0x700},
                                                {0x180, 0x780},
                                                {0x200, 0x600},
                                                {0x400, 0x600},
                                                {0x600, 0x780},
                                                {0x700, 0x780}}};

bool is_state(NmtState state) {
  return state == NmtState::boot_up || state == NmtState::stopped ||
         state == NmtState::operational || state == NmtState::pre_operational;
}

bool only_a_master_sends(std::uint32_t id) {
  const std::uint32_t function = id & kFunction;
  return id == kNmt || id == kSync || function == kSdoRequest ||
         (function >= kRpdo1 && function < kSdoAnswer && (function & 0x080) == 0);
}

}  // namespace

std::span<const CanFilter> filters() noexcept { return kFilters; }

Master::Node* Master::node_of(std::uint32_t id) noexcept {
  const std::size_t index = index_[id & kNode];
  return index < count_ ? &nodes_[index] : nullptr;
}

void Master::receive(const CanFrame& frame) noexcept {
  ++counters_.frames_received;
  if (frame.extended || frame.remote || frame.error || frame.id > kStandardIds || frame.size > 8) {
    ++counters_.unknown_frames;
    return;
  }
  const std::uint32_t function = frame.id & kFunction;
  if (only_a_master_sends(frame.id) || frame.id == kHeartbeat + parameters_.heartbeat.master) {
    ++counters_.other_masters;
    return;
  }
  const bool tpdo = function >= kTpdo1 && function < kSdoAnswer;
  if (!tpdo && function != kEmergency && function != kSdoAnswer && function != kHeartbeat) {
    ++counters_.unknown_frames;
    return;
  }
  Node* node = node_of(frame.id);
  if (node == nullptr) {
    ++counters_.unknown_nodes;
    return;
  }
  ++node->status.frames;
  if (babbles(*node, frame.time_ns)) {
    ++node->status.ignored;
    return;
  }
  if (tpdo) {
    pdo(*node, static_cast<int>((function - kTpdo1) / kPdoStep) + 1, frame);
  } else if (function == kEmergency) {
    emergency(*node, frame);
  } else if (function == kHeartbeat) {
    heartbeat(*node, frame);
  } else {
    node->sdo.receive(frame);
    sdo_over(*node, frame.time_ns);
  }
}

// More frames in one window than all its services together can need.
bool Master::babbles(Node& node, TimeNs time) noexcept {
  if (time - node.window_ns >= parameters_.babble_window_ns || time < node.window_ns) {
    node.window_ns = time;
    node.window_frames = 0;
  }
  const bool babbling = node.status.state == NodeState::babbling;
  if (++node.window_frames <= parameters_.babble_frames) return babbling;
  if (!babbling) {
    ++node.status.babbles;
    node.was_operational =
        node.status.state == NodeState::operational || node.status.state == NodeState::lost;
    node.sdo.cancel();
    node.nmt_due = false;
  }
  enter(node, NodeState::babbling, time, time + parameters_.babble_quiet_ns);
  return true;
}

void Master::heartbeat(Node& node, const CanFrame& frame) noexcept {
  const auto nmt = static_cast<NmtState>(frame.data[0]);
  if (frame.size != 1 || !is_state(nmt)) {
    ++counters_.unknown_frames;
    return;
  }
  const TimeNs time = frame.time_ns;
  node.status.nmt = nmt;
  node.status.heartbeat_ns = time;
  if (nmt == NmtState::boot_up) return booted(node, time);

  const NodeState state = node.status.state;
  const bool watched = state == NodeState::operational || state == NodeState::lost;
  if (nmt == NmtState::operational && (watched || state == NodeState::starting)) {
    enter(node, NodeState::operational, time, time + parameters_.heartbeat.lost_after_ns());
  } else if (watched) {
    ++node.status.fall_backs;
    enter(node, NodeState::fallen_back, time, time);
  }
}

void Master::booted(Node& node, TimeNs time) noexcept {
  ++node.status.boots;
  switch (node.status.state) {
    case NodeState::off:  // it is reset soon
    case NodeState::babbling: return;
    case NodeState::booting: return identify(node, time);
    case NodeState::operational:
    case NodeState::lost:
    case NodeState::starting:
    case NodeState::fallen_back: ++node.status.reboots; [[fallthrough]];
    case NodeState::rebooted: return enter(node, NodeState::rebooted, time, time);
    case NodeState::missing:
    case NodeState::identifying:
    case NodeState::wrong_device:
    case NodeState::configuring:
    case NodeState::failed: break;
  }
  if (boot_allowed_)
    identify(node, time);
  else
    fail(node, time);
}

void Master::emergency(Node& node, const CanFrame& frame) noexcept {
  if (frame.size != 8) {
    ++counters_.unknown_frames;
    return;
  }
  NodeStatus& status = node.status;
  status.emcy_code = static_cast<std::uint16_t>(frame.data[0] | frame.data[1] << 8);
  status.emcy_register = frame.data[2];
  status.emcy_ns = frame.time_ns;
  ++status.emcys;
  if (frame.time_ns - node.storm_ns >= kSecond || frame.time_ns < node.storm_ns) {
    status.emcy_storm = node.storm_emcys > kStorm;
    node.storm_ns = frame.time_ns;
    node.storm_emcys = 0;
  }
  if (++node.storm_emcys > kStorm) status.emcy_storm = true;
  if (status.emcy_storm) quiet_ns_ = kAlways;
}

void Master::pdo(Node& node, int number, const CanFrame& frame) noexcept {
  const Pdo* mapped = node.parameters.tpdo_of(number);
  if (mapped == nullptr) {
    ++counters_.unknown_frames;
    return;
  }
  if (node.status.state != NodeState::operational) {
    ++node.status.ignored;
    return;
  }
  if (frame.size != mapped->bytes()) {
    ++node.status.wrong_lengths;
    return;
  }
  if (sample_count_ == kMaxSamples) {
    ++counters_.overflows;
    first_sample_ = (first_sample_ + 1) % kMaxSamples;
    --sample_count_;
  }
  const auto index = static_cast<std::uint8_t>(&node - nodes_.data());
  samples_[(first_sample_ + sample_count_++) % kMaxSamples] = {
      frame.time_ns, index, static_cast<std::uint8_t>(number), frame.size, frame.data};
}

bool Master::take(PdoSample& sample) noexcept {
  if (sample_count_ == 0) return false;
  sample = samples_[first_sample_];
  first_sample_ = (first_sample_ + 1) % kMaxSamples;
  --sample_count_;
  return true;
}

}  // namespace lss::canopen
