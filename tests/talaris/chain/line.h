#pragma once

// A sensor on its serial line in virtual time: the shipping driver on one side, lss-sim's device
// and line on the other, every byte at its instant. A turn does what a turn of the bus thread does
// (daemon/runtime/serial_bus.h, daemon/vehicles/talaris/line.h), in the same order. One thread.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "daemon/runtime/sample_queue.h"
#include "daemon/vehicles/talaris/buses.h"
#include "tools/lss-sim/frame/uart.h"
#include "tools/lss-sim/frame/vehicle.h"

namespace lss::talaris {

class Line {
 public:
  // `device` of the line outlives this.
  Line(const sim::SerialLine& line, std::unique_ptr<SensorLine> driver, unsigned seed, TimeNs now);

  void turn(TimeNs now);
  TimeNs next_wake() const noexcept {
    return std::min(uart_.next_wake(), std::max(driver_->next_wake(), turned_ns_ + 1));
  }

  // The frame that began since the last call, when its line is the IMU's.
  bool take_tick(FrameTick& tick) noexcept;
  bool pop(TalarisSample& sample, TimeNs end) noexcept { return samples_.pop(sample, end); }
  const LineReport& report() const noexcept { return report_; }
  sim::WireFaults& faults() noexcept { return uart_.faults; }
  // What the daemon keeps: its driver, on the heap, with its status in it; queue; report and tick.
  std::span<std::uint8_t> driver_memory();
  const LineStatus& status() const noexcept { return driver_->status(); }
  std::span<std::uint8_t> queue() { return bytes_of(samples_); }
  std::vector<std::span<std::uint8_t>> memory() {
    return {bytes_of(report_), bytes_of(tick_), bytes_of(ticked_)};
  }

 private:
  void give(TimeNs now);  // samples and report, to the frame thread

  sim::Uart uart_;
  std::unique_ptr<SensorLine> driver_;
  SampleQueue<TalarisSample> samples_;
  LineReport report_{};
  FrameTick tick_{};
  bool ticked_ = false;
  TimeNs turned_ns_ = 0;
};

}  // namespace lss::talaris
