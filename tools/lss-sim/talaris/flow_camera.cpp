#include "tools/lss-sim/talaris/flow_camera.h"

#include <algorithm>
#include <cmath>

namespace lss::sim::talaris {
namespace {

constexpr std::uint8_t kBest = 200, kNone = 0;

std::uint8_t checked(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc & 0x80) != 0 ? 0x1D5 : 0);
  }
  return static_cast<std::uint8_t>(crc);
}

}  // namespace

FlowCamera::FlowCamera(const FlowCameraOptions& options, unsigned seed)
    : options_(options), random_(seed) {}

void FlowCamera::step(std::optional<std::array<double, 2>> passes_rad_s) {
  if (!options_.present) return;
  const std::lock_guard lock(mutex_);
  if (passes_rad_s && std::hypot((*passes_rad_s)[0], (*passes_rad_s)[1]) <= options_.most_rad_s) {
    for (std::size_t i = 0; i < 2; ++i) passed_rad_[i] += 1e-3 * (*passes_rad_s)[i];
  } else {
    seen_ = false;
  }
  pass_millisecond();
  if (++age_ms_ >= std::lround(options_.period_s * 1e3)) expose_done();
}

void FlowCamera::expose_done() {
  const double period_s = 1e-3 * age_ms_;
  std::normal_distribution<double> noise(0, std::max(options_.noise_rad_s, 1e-12));
  std::array<std::int32_t, 2> counts{};
  for (std::size_t i = 0; i < 2; ++i) {
    const double rad =
        passed_rad_[i] * (1 + options_.scale) + period_s * (noise(random_) + faults_.off_rad_s);
    counts[i] = static_cast<std::int32_t>(std::lround(rad * options_.counts_per_rad));
  }
  const double late_s =
      options_.latency_s + std::uniform_real_distribution(0.0, 2 * options_.jitter_s)(random_);
  const bool good = seen_ && !faults_.blind;
  passed_rad_ = {};
  seen_ = true;
  age_ms_ = 0;
  if (faults_.silent) return;
  std::vector<std::uint8_t> bytes = {'$', 'X', '<', 0, 0x02, 0x1F, 9, 0, good ? kBest : kNone};
  for (const std::int32_t value : counts) {
    for (int shift = 0; shift < 32; shift += 8)
      bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(value) >> shift));
  }
  bytes.push_back(checked(std::span(bytes).subspan(3)));
  queue(bytes, static_cast<int>(std::lround(late_s * 1e3)));
}

}  // namespace lss::sim::talaris
