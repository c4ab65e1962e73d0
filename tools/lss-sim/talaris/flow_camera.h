#pragma once

// A downward pointing camera that measures how fast the ground passes, on its serial line (115,200
// 8N1; frames of the MultiWii serial protocol, version 2). Written from docs/icd-talaris.md, not
// from the daemon's driver. Threads as in sensor.h.

#include <array>
#include <optional>
#include <random>

#include "tools/lss-sim/talaris/sensor.h"

namespace lss::sim::talaris {

struct FlowCameraOptions {
  bool present = false;
  double counts_per_rad = 1'000;
  double period_s = 0.050;
  double jitter_s = 0.001;    // of its first byte, either way
  double latency_s = 0;       // from the end of the exposure to the first byte
  double noise_rad_s = 0.02;  // standard deviation of a frame, over its period
  double scale = 0;           // too much by this share
  double min_m = 0.1, max_m = 10;
  double most_rad = 0.9;  // from the ground's normal; above it there is no picture
  double most_rad_s = 7;  // faster ground is blurred
};

struct FlowCameraFaults {
  bool silent = false;
  bool blind = false;    // of no quality: dust, darkness, even ground
  double off_rad_s = 0;  // along both axes
};

class FlowCamera final : public Sensor<FlowCameraFaults> {
 public:
  FlowCamera(const FlowCameraOptions& options, unsigned seed);

  // A millisecond: how fast the ground passes towards +y and +z of B, rad/s; unset: not seen.
  void step(std::optional<std::array<double, 2>> passes_rad_s);
  std::span<const std::uint8_t> receive(std::uint8_t, TimeNs) override { return {}; }

 private:
  void expose_done();

  FlowCameraOptions options_;
  std::mt19937 random_;
  std::array<double, 2> passed_rad_{};
  bool seen_ = true;  // all the time since the last frame
  int age_ms_ = 0;
};

}  // namespace lss::sim::talaris
