#pragma once

// Packets of the sensors as docs/icd-talaris.md has them, and a line that brings them in time.

#include <algorithm>
#include <cstdint>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

using Bytes = std::vector<std::uint8_t>;

inline std::vector<LineByte> line_bytes(const Bytes& bytes) {
  std::vector<LineByte> line;
  for (const std::uint8_t byte : bytes) line.push_back({byte, false});
  return line;
}
inline std::vector<LineByte> line_bytes(std::string_view text) {
  return line_bytes(Bytes(text.begin(), text.end()));
}

// The last byte brings the sum to 0.
inline Bytes with_sum(Bytes packet) {
  unsigned sum = 0;
  for (std::size_t i = 0; i + 1 < packet.size(); ++i) sum += packet[i];
  packet.back() = static_cast<std::uint8_t>(0u - sum);
  return packet;
}

inline const Bytes kLandmarkGolden = {0x2A, 0x07, 0x64, 0x00, 0x06, 0xFF, 0x05, 0x00, 0xE8,
                                      0x03, 0xF4, 0xFF, 0x03, 0x00, 0xD0, 0x09, 0x42, 0x65};
inline const Bytes kCrossbowGolden = {0xFF, 0x00, 0xDA, 0xFE, 0x4B, 0x00, 0x00, 0x2A, 0xAB,
                                      0xFF, 0xEA, 0x00, 0x05, 0x06, 0x40, 0xFD, 0xE8, 0x11};

// The golden packet with another counter and status.
inline Bytes landmark_packet(std::uint8_t counter, std::uint8_t status = 0) {
  Bytes packet = kLandmarkGolden;
  packet[1] = counter;
  packet[16] = status;
  return with_sum(packet);
}

inline std::vector<TalarisSample> take_all(SensorLine& line) {
  std::vector<TalarisSample> samples(SensorLine::kMaxSamples);
  samples.resize(line.take(samples));
  return samples;
}

template <class T>
std::vector<std::pair<TimeNs, T>> only(const std::vector<TalarisSample>& samples) {
  std::vector<std::pair<TimeNs, T>> found;
  for (const TalarisSample& s : samples) {
    if (const T* reading = std::get_if<T>(&s.reading)) found.emplace_back(s.time_ns, *reading);
  }
  return found;
}

// All bytes that the driver writes at `now`.
inline Bytes written(SensorLine& line, TimeNs now) {
  Bytes all;
  while (true) {
    const auto piece = line.transmit(now);
    if (piece.empty()) return all;
    all.insert(all.end(), piece.begin(), piece.end());
  }
}

}  // namespace lss::talaris
