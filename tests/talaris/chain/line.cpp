#include "tests/talaris/chain/line.h"

#include <malloc.h>

#include <array>
#include <stdexcept>
#include <utility>

#include "tests/support/daemon_work.h"

namespace lss::talaris {

using testing_support::bus_work;

namespace {

constexpr TimeNs kReportEvery = 5 * kMillisecond;  // as daemon/runtime/serial_bus.h

}  // namespace

Line::Line(const sim::SerialLine& line, std::unique_ptr<SensorLine> driver, unsigned seed,
           TimeNs now)
    : uart_({.baud = line.baud,
             .bits = line.bits,
             .frame_begin = line.frame_begin,
             .frame_end = line.frame_end,
             .seed = seed},
            *line.device),
      driver_(std::move(driver)) {
  const SerialFormat format = driver_->format();
  if (format.baud != line.baud || format.bits() != line.bits)
    throw std::logic_error("the driver and the sensor speak at different rates");
  driver_->restart(now);
  report_.open = report_.was_open = true;
}

void Line::turn(TimeNs now) {
  turned_ns_ = now;
  uart_.advance(now);
  const auto heard = uart_.take(now);
  std::array<LineByte, 512> bytes;
  const std::size_t size = std::min(heard.size(), bytes.size());
  for (std::size_t i = 0; i < size; ++i) bytes[i] = {.value = heard[i]};
  if (size != 0) bus_work([&] { driver_->receive(std::span(bytes).first(size), now); });
  const auto next = [&] { return driver_->transmit(now); };
  for (auto said = bus_work(next); !said.empty(); said = bus_work(next))
    uart_.from_master(said, now);
  bus_work([&] { give(now); });
}

void Line::give(TimeNs now) {
  std::array<TalarisSample, SensorLine::kMaxSamples> samples;
  const std::size_t count = driver_->take(samples);
  for (std::size_t i = 0; i < count; ++i) samples_.push(samples[i]);
  if (driver_->take_tick(tick_)) {
    ticked_ = true;
    // As daemon/vehicles/talaris/line.h: the packet that begins the frame may have been lost.
    for (std::size_t i = 0; i < count; ++i) {
      if (!std::holds_alternative<ImuPacket>(samples[i].reading) ||
          samples[i].time_ns < tick_.time_ns)
        continue;
      tick_.time_ns = samples[i].time_ns;
      break;
    }
  }
  if (now - report_.time_ns < kReportEvery) return;
  report_.status = driver_->status();
  report_.time_ns = now;
}

std::span<std::uint8_t> Line::driver_memory() {
  void* block = dynamic_cast<void*>(driver_.get());  // as it was allocated
  return {static_cast<std::uint8_t*>(block), malloc_usable_size(block)};
}

bool Line::take_tick(FrameTick& tick) noexcept {
  if (!std::exchange(ticked_, false)) return false;
  tick = tick_;
  return true;
}

}  // namespace lss::talaris
