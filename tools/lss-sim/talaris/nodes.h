#pragma once

// The CANopen nodes of TALARIS: valves with the pressures (0x20), fans (0x21), and the load cell of
// the test stands (0x22). Written from docs/icd-talaris.md sections 5 to 7. Threads: as
// canopen_node.h.

#include <array>
#include <cstdint>

#include "tools/lss-sim/canopen/node.h"
#include "tools/lss-sim/talaris/plant.h"

namespace lss::sim::talaris {

using nodes::Nmt;
using nodes::Node;
using nodes::Signal;

// Outputs of a node that must be refreshed while they are on (object 0x2201).
class Renewal {
 public:
  void renewed() { since_ms_ = 0; }
  // One millisecond. True once when they were not refreshed in time.
  bool late(bool on, std::uint32_t limit_ms);

 private:
  std::uint32_t since_ms_ = 0;
};

class ValveNode final : public Node {
 public:
  static constexpr std::uint8_t kId = 0x20;

  explicit ValveNode(unsigned seed);
  void feel(double tank_kPa, double regulated_kPa, double voltage_V, double temperature_degC);
  std::uint8_t outputs() const { return outputs_; }
  std::uint64_t gaps() const { return gaps_; }  // missing frames of the sequence
  Signal* signal(int number) override;

 private:
  void measure() override;
  void written(std::uint16_t index, std::uint8_t sub) override;
  void left_operational(bool communication_error) override;
  void reset() override { shut(); }
  void tick() override;
  void shut() { outputs_ = 0; }

  Signal tank_kPa_, regulated_kPa_, voltage_10mV_, temperature_0_1degC_;
  std::uint8_t outputs_ = 0;
  std::uint32_t last_sequence_ = 0;
  std::uint64_t gaps_ = 0;
  Renewal renewal_;
};

class FanNode final : public Node {
 public:
  static constexpr std::uint8_t kId = 0x21;

  explicit FanNode(unsigned seed);
  void feel(const std::array<double, kFans>& rpm);
  const std::array<std::uint16_t, kFans>& pulse_us() const { return pulse_us_; }
  Signal* signal(int) override { return nullptr; }

 private:
  static constexpr std::uint16_t kOff_us = 1'000, kFull_us = 2'000;

  void measure() override;
  void written(std::uint16_t index, std::uint8_t sub) override;
  void left_operational(bool communication_error) override;
  void reset() override { off(); }
  void tick() override;
  void off() {
    pulse_us_.fill(kOff_us);
    ramps_ = false;
  }
  void drop();

  bool ramps_ = false;  // without orders: slows down
  std::array<double, kFans> ramp_us_{};
  std::array<double, kFans> sum_rpm_{};
  int summed_ = 0;
  std::array<std::uint16_t, kFans> pulse_us_{kOff_us, kOff_us, kOff_us, kOff_us};
  Renewal renewal_;
};

// Six components, each with the oscillation of the stand: 7 Hz, hardly damped (TALARIS thesis
// 5.2.5), about an offset that walks: its zero is taken at standstill (A.5.3).
class LoadCellNode final : public Node {
 public:
  static constexpr std::uint8_t kId = 0x22;

  explicit LoadCellNode(unsigned seed);
  void feel(const Wrench& wrench);
  const std::array<double, 6>& offset() const { return offset_; }  // N, N m
  Signal* signal(int) override { return nullptr; }

 private:
  void measure() override {}
  void written(std::uint16_t, std::uint8_t) override {}
  void left_operational(bool) override {}
  void reset() override {}
  void tick() override;
  double drawn(std::size_t component, double force_N, double moment_Nm);

  struct Ringing {
    double value = 0, rate_1_s = 0;
  };
  std::array<double, 6> load_{}, offset_{};
  std::array<Ringing, 6> felt_{};
};

}  // namespace lss::sim::talaris
