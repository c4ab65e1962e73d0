#pragma once

// A node of docs/icd-talaris.md in virtual time: boots, takes its configuration, beats, watches the
// master, follows RPDO1 and drops the order when it is not renewed. Answers come one millisecond
// after the question.

#include <array>
#include <cstdint>
#include <set>
#include <utility>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::testing_support {

class HopperNode {
 public:
  static constexpr std::uint8_t kValves = 0x20, kFans = 0x21, kLoadCell = 0x22;
  static constexpr TimeNs kNever = INT64_MAX;
  struct Write {
    std::uint16_t index;
    std::uint8_t sub;
    std::uint8_t bytes;
    std::uint32_t value;
    bool operator==(const Write&) const = default;
  };

  HopperNode(std::uint8_t number, std::uint32_t type) : id(number), device_type(type) {}

  void power_on(TimeNs now);
  void receive(const CanFrame& frame, TimeNs now);
  void run(TimeNs now);
  TimeNs next_wake() const;
  std::vector<CanFrame> take() { return std::exchange(out_, {}); }

  std::uint8_t id;
  std::uint32_t device_type;
  std::uint8_t state = 0;  // as in a heartbeat
  std::uint8_t valves = 0;
  std::array<std::uint16_t, 4> fan_us = {1000, 1000, 1000, 1000};
  std::vector<Write> writes;            // in their order, since it booted
  std::vector<std::uint8_t> sequences;  // of valve frames that were obeyed, 0 left out
  int repeated = 0;                     // valve frames
  int forgotten = 0;                    // times that outputs were not renewed
  int master_lost = 0;
  int resets = 0;
  std::array<std::uint8_t, 8> data[2]{};  // of TPDO1 and 2

  // Its faults.
  bool mute = false;
  std::set<std::uint32_t> refused;  // index << 8 | sub

 private:
  std::uint32_t written(std::uint16_t index, std::uint8_t sub) const;
  void safe();
  void outputs(const CanFrame& frame, TimeNs now);
  void sdo(const CanFrame& frame, TimeNs now);
  void send(std::uint32_t cob_id, const std::vector<std::uint8_t>& bytes, TimeNs now);

  std::vector<CanFrame> out_;
  TimeNs boot_ns_ = kNever, heartbeat_ns_ = kNever, master_ns_ = kNever, renewed_ns_ = kNever;
  std::array<TimeNs, 2> tpdo_ns_ = {kNever, kNever};
  int last_sequence_ = -1;
};

}  // namespace lss::testing_support
