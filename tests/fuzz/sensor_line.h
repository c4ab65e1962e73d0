#pragma once

// A sensor of TALARIS on a serial line that carries any bytes, with the marks of a terminal for bad
// ones. Samples are numbers, and not from the future.

#include <array>
#include <cmath>
#include <variant>

#include "drivers/talaris/sensor_line.h"
#include "tests/fuzz/fuzz.h"

namespace lss::talaris {

inline bool finite(const Reading& reading) {
  const auto all = [](const auto& values) {
    return std::ranges::all_of(values, [](double x) { return std::isfinite(x); });
  };
  if (const auto* imu = std::get_if<ImuPacket>(&reading))
    return all(imu->rate_rad_s) && all(imu->force_m_s2) && std::isfinite(imu->temperature_degC);
  if (const auto* status = std::get_if<ImuStatus>(&reading))
    return std::isfinite(status->rate_unit_rad_s) && std::isfinite(status->force_unit_m_s2);
  if (const auto* range = std::get_if<Range>(&reading)) return std::isfinite(range->range_m);
  if (const auto* flow = std::get_if<Flow>(&reading)) return all(flow->angle_rad);
  return false;  // no other comes from these
}

// `answers`: letters and packets that the sensor might send, which are hard to guess.
inline void listen(SensorLine& line, fuzz::Input in,
                   std::span<const std::span<const std::uint8_t>> answers) {
  using fuzz::must;
  TimeNs now = kSecond;
  ParityMarks marks;
  std::array<LineByte, 64> bytes{};
  std::array<TalarisSample, SensorLine::kMaxSamples> samples{};
  const auto receive = [&](std::span<const std::uint8_t> raw) {
    const std::size_t size = marks.decode(raw, bytes);
    must(size <= raw.size(), "marks add no bytes");
    line.receive(std::span(bytes).first(size), now);
  };
  line.restart(now);
  while (!in.empty()) {
    switch (in.below(4)) {
      case 0: receive(in.take(in.below(64))); break;
      case 1: receive(answers[in.below(static_cast<unsigned>(answers.size()))]); break;
      case 2: now += in.number<std::uint16_t>() * TimeNs{200}; break;
      default: now += in.byte() * 2 * kMillisecond;
    }
    for (int writes = 0; !line.transmit(now).empty(); ++writes)
      must(writes < 100, "transmit() comes to an end");
    must(line.next_wake() > now, "nothing is due when transmit() has nothing");
    FrameTick tick;
    if (line.take_tick(tick)) must(tick.time_ns <= now, "a frame began before now");
    for (const TalarisSample& sample : std::span(samples).first(line.take(samples))) {
      must(sample.time_ns <= now, "a sample is of before now");
      must(finite(sample.reading), "a sample is a number");
    }
  }
}

}  // namespace lss::talaris
