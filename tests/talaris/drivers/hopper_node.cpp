#include "tests/talaris/drivers/hopper_node.h"

#include <algorithm>

#include "tests/support/can_frames.h"

namespace lss::testing_support {

void HopperNode::power_on(TimeNs now) {
  safe();
  writes.clear();
  state = 0;
  boot_ns_ = now + 100 * kMillisecond;
  heartbeat_ns_ = master_ns_ = kNever;
  tpdo_ns_ = {kNever, kNever};
  last_sequence_ = -1;
}

void HopperNode::safe() {
  valves = 0;
  fan_us = {1000, 1000, 1000, 1000};
  renewed_ns_ = kNever;
}

// 0: it was not.
std::uint32_t HopperNode::written(std::uint16_t index, std::uint8_t sub) const {
  for (auto w = writes.rbegin(); w != writes.rend(); ++w) {
    if (w->index == index && w->sub == sub) return w->value;
  }
  return 0;
}

TimeNs HopperNode::next_wake() const {
  return std::min({boot_ns_, heartbeat_ns_, master_ns_, renewed_ns_, tpdo_ns_[0], tpdo_ns_[1]});
}

void HopperNode::run(TimeNs now) {
  if (now >= boot_ns_) {
    boot_ns_ = kNever;
    state = 0x7F;
    send(0x700u + id, {0}, now);
  }
  if (now >= master_ns_) {
    master_ns_ = kNever;
    ++master_lost;
    state = 0x7F;
    tpdo_ns_ = {kNever, kNever};
    safe();
    send(0x080u + id, {0x30, 0x81, 0x11, 0, 0, 0, 0, 0}, now);
  }
  if (now >= renewed_ns_) {
    ++forgotten;
    safe();
    send(0x080u + id, {0x50, 0x82, 0x11, 0, 0, 0, 0, 0}, now);
  }
  if (now >= heartbeat_ns_) {
    heartbeat_ns_ += written(0x1017, 0) * kMillisecond;
    send(0x700u + id, {state}, now);
  }
  for (std::size_t n = 0; n < 2; ++n) {
    if (now < tpdo_ns_[n]) continue;
    const auto parameters = static_cast<std::uint16_t>(0x1800 + n);
    tpdo_ns_[n] += written(parameters, 5) * kMillisecond;
    std::size_t bits = 0;
    const auto mapping = static_cast<std::uint16_t>(0x1A00 + n);
    for (std::uint8_t sub = 1; sub <= written(mapping, 0); ++sub)
      bits += written(mapping, sub) & 0xFF;
    send(written(parameters, 1) & 0x7FF,
         {data[n].begin(), data[n].begin() + static_cast<std::ptrdiff_t>(bits / 8)}, now);
  }
}

void HopperNode::receive(const CanFrame& frame, TimeNs now) {
  if (boot_ns_ != kNever) return;
  if (frame.id == 0x000 && (frame.data[1] == id || frame.data[1] == 0)) {
    if (frame.data[0] == 0x01) {
      state = 0x05;
      for (std::size_t n = 0; n < 2; ++n) {
        if (written(static_cast<std::uint16_t>(0x1800 + n), 5) != 0) tpdo_ns_[n] = now;
      }
    } else {
      ++resets;
      power_on(now);
    }
  } else if (frame.id == 0x600u + id) {
    sdo(frame, now);
  } else if (frame.id == 0x200u + id && state == 0x05) {
    outputs(frame, now);
  } else if (frame.id == 0x77F && written(0x1016, 1) >> 16 == 0x7F) {
    master_ns_ = now + (written(0x1016, 1) & 0xFFFF) * kMillisecond;
  }
}

void HopperNode::outputs(const CanFrame& frame, TimeNs now) {
  if (frame.size != (id == kValves ? 2 : 8)) {
    return send(0x080u + id, {0x10, 0x82, 0x11, 0, 0, 0, 0, 0}, now);
  }
  bool on = false;
  if (id == kValves) {
    const std::uint8_t sequence = frame.data[1];
    if (sequence != 0 && sequence == last_sequence_) {
      ++repeated;
      return;
    }
    valves = sequence == 0 ? 0 : frame.data[0];
    on = valves != 0;
    if (sequence != 0) {
      last_sequence_ = sequence;
      sequences.push_back(sequence);
    }
  } else {
    for (std::size_t i = 0; i < 4; ++i) {
      fan_us[i] = static_cast<std::uint16_t>(frame.data[2 * i] | frame.data[2 * i + 1] << 8);
      on = on || fan_us[i] > 1000;
    }
  }
  const std::uint32_t renewal = written(0x2201, 0);
  renewed_ns_ = on && renewal > 0 ? now + renewal * kMillisecond : kNever;
}

void HopperNode::sdo(const CanFrame& frame, TimeNs now) {
  const auto index = static_cast<std::uint16_t>(frame.data[1] | frame.data[2] << 8);
  const std::uint8_t sub = frame.data[3];
  std::vector<std::uint8_t> answer = {0x60, frame.data[1], frame.data[2], sub, 0, 0, 0, 0};
  const auto put = [&answer](std::uint8_t command, std::uint32_t value) {
    answer[0] = command;
    for (std::size_t i = 0; i < 4; ++i) answer[4 + i] = static_cast<std::uint8_t>(value >> (8 * i));
  };
  if (frame.data[0] == 0x80) return;
  if (refused.contains(std::uint32_t{index} << 8 | sub)) {
    put(0x80, 0x0602'0000);
  } else if (frame.data[0] == 0x40) {
    put(0x43, device_type);
  } else {
    const auto bytes = static_cast<std::uint8_t>(4 - (frame.data[0] >> 2 & 3));
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < bytes; ++i) value |= std::uint32_t{frame.data[4 + i]} << (8 * i);
    writes.push_back({index, sub, bytes, value});
    if (index == 0x1017) heartbeat_ns_ = now;
  }
  send(0x580u + id, answer, now);
}

void HopperNode::send(std::uint32_t cob_id, const std::vector<std::uint8_t>& bytes, TimeNs now) {
  if (mute) return;
  out_.push_back(testing_support::frame(cob_id, bytes, now + kMillisecond));
}

}  // namespace lss::testing_support
