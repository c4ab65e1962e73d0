#pragma once

// A sensor of TALARIS on its serial line, as daemon/runtime/serial_bus.h drives it. The IMU's line
// also announces where frames begin.

#include "daemon/runtime/frames.h"
#include "daemon/runtime/serial_bus.h"
#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

struct LineEnds {
  SensorLine* line = nullptr;
  SensorFrames* frames = nullptr;  // of the IMU
};

class LineDriver {
 public:
  using Byte = LineByte;
  static constexpr std::size_t kMaxReplies = SensorLine::kMaxSamples;

  explicit LineDriver(const LineEnds& ends) noexcept : line_(*ends.line), frames_(ends.frames) {}

  void restart(TimeNs now) noexcept { line_.restart(now); }
  void receive(std::span<const LineByte> bytes, TimeNs now) noexcept { line_.receive(bytes, now); }
  std::span<const std::uint8_t> transmit(TimeNs now) noexcept { return line_.transmit(now); }
  TimeNs next_wake() const noexcept { return line_.next_wake(); }
  std::size_t take(std::span<TalarisSample> out) noexcept {
    const std::size_t count = line_.take(out);
    if (line_.take_tick(tick_)) begin(out.first(count));
    return count;
  }
  // The batch is complete before its frame begins.
  void published() noexcept {
    if (tick_ns_ != 0 && frames_ != nullptr) frames_->announce(tick_.index, tick_ns_);
    tick_ns_ = 0;
  }
  const LineStatus& counters() const noexcept { return line_.status(); }

 private:
  // When the packet that begins the frame was lost, the frame begins with the next one: it is late,
  // and its command may be, too.
  void begin(std::span<const TalarisSample> heard) noexcept {
    tick_ns_ = tick_.time_ns;
    for (const TalarisSample& sample : heard) {
      if (!std::holds_alternative<ImuPacket>(sample.reading) || sample.time_ns < tick_.time_ns)
        continue;
      tick_ns_ = sample.time_ns;
      return;
    }
  }

  SensorLine& line_;
  SensorFrames* frames_;
  FrameTick tick_{};
  TimeNs tick_ns_ = 0;  // 0: no frame begins
};

using LineBus = SerialBus<LineDriver, LineEnds, NoOrders, TalarisSample, LineStatus>;

}  // namespace lss::talaris
