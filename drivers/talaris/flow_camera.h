#pragma once

// A downward pointing camera that measures how fast the ground passes (TALARIS thesis 2.3.6 plans
// one), as sold for multicopters: frames of the MultiWii serial protocol, version 2, at its own
// rhythm (docs/icd-talaris.md section 10). It needs no command.

#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

struct FlowCameraParameters {
  int baud = 115'200;
  double counts_per_rad = 1'000;
  TimeNs period_ns = 50 * kMillisecond;
  TimeNs latency_ns = 0;            // from the end of the exposure to the first byte: subtracted
  std::uint8_t least_quality = 40;  // of 255; less is counted, and no sample
};

class FlowCamera final : public SensorLine {
 public:
  explicit FlowCamera(const FlowCameraParameters& parameters) noexcept;

  void restart(TimeNs now) noexcept override;
  void receive(std::span<const LineByte> bytes, TimeNs now) noexcept override;
  std::span<const std::uint8_t> transmit(TimeNs) noexcept override { return {}; }
  TimeNs next_wake() const noexcept override;

 private:
  static constexpr std::size_t kHead = 8;          // "$X<", flag, function, size
  static constexpr std::size_t kMostPayload = 32;  // longer ones are no frames of such a device

  void parse() noexcept;
  void end_frame(std::size_t size) noexcept;

  FlowCameraParameters parameters_;
  std::array<Held, kHead + kMostPayload + 1> buffer_{};
  std::size_t size_ = 0;
};

}  // namespace lss::talaris
