#pragma once

// The two nodes of D.I.A.N.A. Ardito that are no drives: I/O (CiA 401: clutches, beacon,
// emergency-stop button, motor power, suspension angles) and IMU. Written from docs/icd-ardito.md
// sections 5, 7 and 10.

#include "tools/lss-sim/ardito/node.h"
#include "tools/lss-sim/ardito/rover.h"

namespace lss::sim::ardito {

class IoNode final : public Node {
 public:
  static constexpr std::uint8_t kId = 0x20;

  explicit IoNode(unsigned seed);
  void feel(const Suspension& suspension, bool button, bool power_good);
  bool clutch(std::size_t wheel) const { return (outputs() >> wheel & 1) != 0; }
  bool beacon() const { return (outputs() >> 6 & 1) != 0; }
  Signal* signal(int number) override;

 private:
  std::uint32_t outputs() const { return outputs_; }
  void measure() override;
  void written(std::uint16_t index, std::uint8_t sub) override;
  void left_operational(bool communication_error) override;
  void reset() override { outputs_ = 0; }
  void tick() override {}

  Signal beta_, rho1_, rho2_;
  std::uint32_t outputs_ = 0;
  std::uint8_t inputs_ = 0;
};

class ImuNode final : public Node {
 public:
  static constexpr std::uint8_t kId = 0x21;

  explicit ImuNode(unsigned seed);
  void feel(const BodyState& body);
  void set_stuck(bool stuck) { stuck_ = stuck; }
  Signal* signal(int number) override;

 private:
  void measure() override;
  void written(std::uint16_t, std::uint8_t) override {}
  void left_operational(bool) override {}
  void count_sync() override { counter_ = static_cast<std::uint16_t>(counter_ + (stuck_ ? 0 : 1)); }
  void reset() override { counter_ = 0; }
  void tick() override {}

  Signal forward_mm_s_, right_mm_s_, speed_, direction_, yaw_rate_;
  std::uint16_t counter_ = 0;
  bool stuck_ = false;
};

}  // namespace lss::sim::ardito
