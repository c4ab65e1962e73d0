#pragma once

// Supervises CANopen nodes and drives of CiA 402: contact, identity, resets and what they report.
// It reports these as events and faults to the locomotion controller. Module i+1 is node i of the
// bus. Frame thread; time is data; no allocation.

#include <algorithm>
#include <array>

#include "daemon/cycle/resets.h"
#include "daemon/cycle/supervisor.h"
#include "drivers/canopen/drive_bus.h"

namespace lss::kit {

inline std::uint16_t module_of(std::size_t node) noexcept {
  return static_cast<std::uint16_t>(node + 1);
}

// Raises a fault of a node. During error solving the fault is only latched, because the strategies
// handle it.
inline void blame(FaultId id, std::size_t node, Supervisor& s) noexcept {
  if (s.controller().state == State::solve_errors) {
    s.latch(id, module_of(node));
  } else {
    s.raise(id, module_of(node));
  }
}

class NodeWatch {
 public:
  static constexpr TimeNs kSettled = 500 * kMillisecond;  // until a node that runs sends its values
  static constexpr std::size_t kDropouts = 4;  // this number within kDropoutWindow is a fault
  static constexpr TimeNs kDropoutWindow = 10 * kSecond;

  struct Node {
    bool answers = false;
    bool needed = true;  // without it the vehicle does not move
    bool in_service = true;
  };

  // Call in every frame before watch(), which checks for silence. `link(i)`: canopen::DriveLink of
  // a node.
  template <class Link, class Answers>
  void watch_resets(TimeNs now, TimeNs limit, bool port_open, Link&& link, Answers&& answers,
                    Supervisor& s) noexcept {
    resets_.watch(
        now, limit, port_open, [&](std::size_t i) { return link(i).node.boots; },
        [&](std::size_t i) { return answers(i) && now - link(i).node.since_ns >= kSettled; }, s);
  }

  void watch(std::size_t i, const canopen::NodeStatus& node, const Node& is, bool port_open,
             Supervisor& s) noexcept {
    using canopen::NodeState;
    const auto follow = [&](NodeState state, FaultId id) {
      if (node.state == state) s.latch(id, module_of(i));
      if (node.state == NodeState::operational) s.clear(id, module_of(i));
    };
    follow(NodeState::wrong_device, FaultId::node_wrong);
    follow(NodeState::failed, FaultId::node_refuses);
    follow(NodeState::babbling, FaultId::node_babbles);
    if (node.emcys != emcys_[i]) {
      emcys_[i] = node.emcys;
      s.note(EventId::emergency_message, module_of(i), node.emcy_code);
    }
    if (node.reboots != reboots_[i]) {
      reboots_[i] = node.reboots;
      const bool moving = s.controller().state == State::operational && is.in_service && is.needed;
      if (moving) {
        s.raise(FaultId::module_reset, module_of(i));
      } else {
        s.note(EventId::module_was_reset, module_of(i));
      }
    }
    if (is.needed && is.in_service) watch_contact(i, is.answers, port_open, s);
  }

  // `judged` false: a fault of the drive has another cause and is not reported.
  void watch_drive(std::size_t i, const canopen::DriveLink& link, bool answers, bool judged,
                   Supervisor& s) noexcept {
    using canopen::DriveState;
    const bool fault =
        answers && (link.drive == DriveState::fault || link.drive == DriveState::fault_reaction);
    if (fault && !was_faulty_[i] && judged) blame(FaultId::drive_fault, i, s);
    was_faulty_[i] = fault;
    const bool disobeys = answers && link.disobeys;
    if (disobeys && !disobeyed_[i]) blame(FaultId::module_disobeys, i, s);
    disobeyed_[i] = disobeys;
  }

  // Call when the drive is out of service: faults that it reports afterwards count as new.
  void forget_drive(std::size_t i) noexcept { was_faulty_[i] = disobeyed_[i] = false; }

  // Each time the drive drops out of operation enabled (canopen::DriveLink) is an event; too many
  // within kDropoutWindow are a fault. `judged` as above.
  void watch_dropouts(std::size_t i, const canopen::DriveLink& link, TimeNs now, bool judged,
                      Supervisor& s) noexcept {
    std::array<TimeNs, kDropouts>& at_ns = dropped_ns_[i];
    if (link.dropouts < dropouts_[i]) dropouts_[i] = 0;  // the bus began again
    if (link.dropouts - dropouts_[i] > kDropouts) dropouts_[i] = link.dropouts - kDropouts;
    for (; dropouts_[i] != link.dropouts; ++dropouts_[i]) {
      std::copy_backward(at_ns.begin(), at_ns.end() - 1, at_ns.end());
      at_ns[0] = now;
      s.note(EventId::drive_dropped_out, module_of(i), static_cast<double>(dropouts_[i] + 1));
      const bool often = at_ns.back() != 0 && now - at_ns.back() <= kDropoutWindow;
      if (often && judged && s.controller().state == State::operational) {
        s.raise(FaultId::drive_drops_out, module_of(i));
        at_ns = {};
      }
    }
  }

  // A command resets the node: until it is back its silence is expected.
  void begin_reset(std::size_t i, TimeNs now, const canopen::NodeStatus& node) noexcept {
    resets_.begin(i, now, node.boots);
  }
  bool away(std::size_t i) const noexcept { return resets_.away(i); }

  template <class V>
  void keep(V& v) {
    v(resets_, reboots_, emcys_, was_faulty_, disobeyed_, dropouts_, dropped_ns_);
  }

 private:
  void watch_contact(std::size_t i, bool answers, bool port_open, Supervisor& s) noexcept {
    const lc::ControllerState& c = s.controller();
    const bool unheard = (c.unheard >> i & 1u) != 0, silent = (c.silent >> i & 1u) != 0;
    if (answers && (unheard || silent)) {
      s.happen(lc::Event::module_heard, module_of(i));
      s.note(EventId::node_configured, module_of(i));
    } else if (!answers && !unheard && !silent && !resets_.away(i) && port_open) {
      s.happen(lc::Event::module_silent, module_of(i));
      blame(FaultId::module_silent, i, s);
    }
  }

  Resets resets_;
  std::array<std::uint64_t, canopen::kMaxNodes> reboots_{}, emcys_{};
  std::array<bool, canopen::kMaxNodes> was_faulty_{}, disobeyed_{};
  std::array<std::uint64_t, canopen::kMaxNodes> dropouts_{};
  std::array<std::array<TimeNs, kDropouts>, canopen::kMaxNodes> dropped_ns_{};  // latest first
};

// Gives the supervisor the ages of the nodes' last heartbeats, for guards and for display.
template <class Link>
void set_ages(std::size_t nodes, TimeNs now, TimeNs limit, Link&& link, Supervisor& s) noexcept {
  std::array<std::int64_t, kMaxModules> age_ms{};
  unsigned unfit = 0;
  for (std::size_t i = 0; i < nodes; ++i) {
    const canopen::NodeStatus& node = link(i).node;
    if (node.heartbeat_ns != 0) age_ms[i] = (now - node.heartbeat_ns) / kMillisecond;
    // The last configuration failed because the node refused it, not because it was silent.
    const bool refuses = node.abort_code != 0 && node.abort_code != canopen::kAbortTimeout;
    const bool wrong = node.state == canopen::NodeState::wrong_device;
    const bool away = node.state == canopen::NodeState::missing || node.heartbeat_ns == 0;
    if (!away && (wrong || refuses)) unfit |= 1u << i;
  }
  s.set_unfit(static_cast<std::uint16_t>(unfit));
  s.set_ages(age_ms, limit / kMillisecond);
}

}  // namespace lss::kit
