#include "drivers/talaris/flow_camera.h"

#include <algorithm>
#include <limits>

namespace lss::talaris {
namespace {

constexpr std::array<std::uint8_t, 3> kBegin = {'$', 'X', '<'};
constexpr unsigned kOpticalFlow = 0x1F02;
constexpr std::size_t kPayload = 9;  // quality, and the motion along both axes

// DVB-S2, polynomial 0xD5.
std::uint8_t crc8(std::uint8_t crc, std::uint8_t byte) noexcept {
  crc ^= byte;
  for (int bit = 0; bit < 8; ++bit)
    crc = static_cast<std::uint8_t>((crc & 0x80) != 0 ? crc << 1 ^ 0xD5 : crc << 1);
  return crc;
}

}  // namespace

FlowCamera::FlowCamera(const FlowCameraParameters& parameters) noexcept
    : SensorLine({parameters.baud, SerialFormat::Parity::none, 1, false}),
      parameters_(parameters) {}

void FlowCamera::restart(TimeNs) noexcept {
  clear();
  size_ = 0;
}

TimeNs FlowCamera::next_wake() const noexcept { return std::numeric_limits<TimeNs>::max(); }

void FlowCamera::receive(std::span<const LineByte> bytes, TimeNs now) noexcept {
  status_.counters.bytes += bytes.size();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    buffer_[size_++] = {bytes[i], arrival_ns(now, i, bytes.size())};
    parse();
  }
}

// Leaves the begin of at most one frame in the buffer.
void FlowCamera::parse() noexcept {
  while (size_ != 0) {
    const std::size_t known = std::min(size_, kBegin.size());
    if (!std::equal(kBegin.begin(), kBegin.begin() + known, buffer_.begin(),
                    [](std::uint8_t a, const Held& b) { return a == b.byte.value; })) {
      ++status_.counters.skipped;
      drop(buffer_, size_, 1);
      continue;
    }
    if (size_ < kHead) return;
    const auto payload =
        static_cast<std::size_t>(buffer_[6].byte.value | buffer_[7].byte.value << 8);
    if (payload > kMostPayload) {
      ++status_.counters.bad_check;
      drop(buffer_, size_, 1);
      continue;
    }
    const std::size_t whole = kHead + payload + 1;
    if (size_ < whole) return;
    end_frame(whole);
  }
}

void FlowCamera::end_frame(std::size_t size) noexcept {
  const auto frame = std::span(buffer_).first(size);
  std::uint8_t crc = 0;
  for (const Held& held : frame.subspan(3, size - 4)) crc = crc8(crc, held.byte.value);
  const bool marked = std::ranges::any_of(frame, [](const Held& held) { return held.byte.bad; });
  if (marked || crc != frame.back().byte.value) {
    ++(marked ? status_.counters.parity : status_.counters.bad_check);
    return drop(buffer_, size_, 1);  // another frame may begin in what was taken for this one
  }
  const unsigned function = frame[4].byte.value | static_cast<unsigned>(frame[5].byte.value) << 8;
  if (function == kOpticalFlow && size == kHead + kPayload + 1) {
    const auto motion = [&](std::size_t at) {
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < 4; ++i)
        value |= static_cast<std::uint32_t>(frame[at + i].byte.value) << (8 * i);
      return static_cast<double>(static_cast<std::int32_t>(value)) / parameters_.counts_per_rad;
    };
    ++status_.counters.packets;
    status_.heard_ns = std::max(frame[0].time_ns - parameters_.latency_ns, status_.heard_ns + 1);
    const Flow flow{.angle_rad = {motion(kHead + 1), motion(kHead + 5)},
                    .quality = frame[kHead].byte.value,
                    .usable = frame[kHead].byte.value >= parameters_.least_quality};
    if (!flow.usable) ++status_.counters.said_errors;
    keep({status_.heard_ns, flow});
  } else {
    status_.counters.skipped += size;  // of another sensor in the same device
  }
  drop(buffer_, size_, size);
}

}  // namespace lss::talaris
