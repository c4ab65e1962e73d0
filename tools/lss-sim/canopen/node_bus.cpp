#include "tools/lss-sim/canopen/node_bus.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <string_view>

#include "tools/lss-sim/canopen/drive.h"

namespace lss::sim::nodes {

Node* NodeBus::node(std::uint8_t id) {
  const auto found = std::ranges::find(nodes_, id, &Node::id);
  return found == nodes_.end() ? nullptr : *found;
}

void NodeBus::receive(const CanFrame& frame) {
  const std::lock_guard lock(mutex_);
  for (Node* node : nodes_) node->receive(frame);
  note_waiting();
}

// Nodes take turns, so that a babbling node does not block the others.
std::optional<CanFrame> NodeBus::send() {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    speaker_ = (speaker_ + 1) % nodes_.size();
    if (auto frame = nodes_[speaker_]->send()) return frame;
  }
  waiting_ = false;
  if (foreign_.empty()) return std::nullopt;
  const CanFrame frame = foreign_.front();
  foreign_.pop_front();
  return frame;
}

void NodeBus::step_nodes() {
  for (Node* node : nodes_) node->step();
  speak_foreign();
}

void NodeBus::note_waiting() {
  waiting_ = !foreign_.empty() || std::ranges::any_of(nodes_, &Node::wants_to_send);
}

// Frames of nodes that are not on this bus, and of types that it does not use.
void NodeBus::speak_foreign() {
  foreign_owed_ = foreign_1_s_ > 0 ? foreign_owed_ + foreign_1_s_ * kStep_s : 0;
  std::uniform_int_distribution<unsigned> any(0, 255);
  for (; foreign_owed_ >= 1; --foreign_owed_) {
    constexpr std::uint32_t kServices[] = {0x080, 0x180, 0x280, 0x380, 0x480, 0x580, 0x700};
    const std::uint32_t stranger = 0x40 + any(random_) % 0x30;
    CanFrame frame{.id = kServices[any(random_) % std::size(kServices)] + stranger,
                   .extended = any(random_) % 8 == 0,
                   .remote = any(random_) % 8 == 0,
                   .size = static_cast<std::uint8_t>(any(random_) % 9)};
    if (frame.extended) frame.id |= 0x18FF'0000;
    for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(any(random_));
    foreign_.push_back(frame);
  }
}

bool NodeBus::set_node_fault(const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (fault.values.empty()) return false;
  if (name == "foreign-frames") {
    foreign_1_s_ = attach ? fault.values.front() : 0;
    return true;
  }
  const auto of_number = [&](const Node* each) { return each->id() == fault.values.front(); };
  const auto at = std::ranges::find_if(nodes_, of_number);
  if (at == nodes_.end()) return false;
  Node* found = *at;
  NodeFaults& faults = found->faults;
  const double second = attach && fault.values.size() > 1 ? fault.values[1] : 0;
  if (name == "node-silent") {
    faults.silent = attach;
  } else if (name == "node-reboot") {
    found->power_on();
  } else if (name == "emcy") {
    found->inject_emcy(static_cast<std::uint16_t>(fault.values[1]), attach);
  } else if (name == "emcy-storm") {
    faults.emcy_storm_1_s = second;
  } else if (name == "drive-fault") {
    dynamic_cast<Drive&>(*found).fail(static_cast<std::uint16_t>(second));
  } else if (name == "babble") {
    faults.babble_1_s = second;
  } else if (name == "wrong-pdo-length") {
    faults.longer_pdos = static_cast<int>(second);
  } else if (name == "sdo-abort") {
    faults.sdo_abort = static_cast<std::uint32_t>(second);
  } else if (name == "wrong-device-type") {
    found->set_device_type(static_cast<std::uint32_t>(second));
  } else {
    return set_signal_fault(*found, fault, attach);
  }
  return true;
}

bool NodeBus::set_signal_fault(Node& node, const Fault& fault, bool attach) {
  const std::string_view name = fault.kind->name;
  if (name != "stuck" && name != "drift" && name != "encoder-jump") return false;
  Signal* signal = node.signal(static_cast<int>(fault.values[1]));
  if (signal == nullptr) {
    fmt::print(stderr, "lss-sim: {} does nothing: node 0x{:02X} has no such value\n",
               to_text(fault), node.id());
    return true;
  }
  if (name == "stuck") {
    signal->stick(attach);
  } else {
    const double units = attach ? fault.values[2] : 0;
    name == "drift" ? signal->drift(units) : signal->jump(units);
  }
  return true;
}

}  // namespace lss::sim::nodes
