#pragma once

// Lunar Zebro's body, legs and ground as rigid bodies (DART). One step is 1 ms and takes about 0.1
// ms.

#include "tools/lss-sim/zebro/plant.h"

namespace lss::sim::zebro {

class Robot final : public Plant {
 public:
  // The robot lies on its belly, its legs off the ground at unknown angles.
  explicit Robot(const TerrainOptions& terrain);
  ~Robot() override;
  Robot(const Robot&) = delete;
  Robot& operator=(const Robot&) = delete;

  void step(const std::array<ShaftDrive, kLegs>& drives) override;

  const std::array<ShaftState, kLegs>& shafts() const override { return shafts_; }
  BodyState body() const override;

 private:
  struct World;
  std::unique_ptr<World> world_;
  std::array<ShaftState, kLegs> shafts_{};
};

}  // namespace lss::sim::zebro
