#include "drivers/can/cannelloni.h"

#include <algorithm>

namespace lss {
namespace {

constexpr std::uint8_t kVersion = 2, kData = 0;
constexpr std::size_t kHeader = 5, kFrameHeader = 5;
constexpr std::uint32_t kExtended = 0x8000'0000, kRemote = 0x4000'0000, kError = 0x2000'0000;
constexpr std::uint8_t kFd = 0x80;
constexpr std::size_t kMaxFdData = 64;

std::uint32_t big_endian(std::span<const std::uint8_t> b) {
  return std::uint32_t{b[0]} << 24 | std::uint32_t{b[1]} << 16 | std::uint32_t{b[2]} << 8 | b[3];
}

}  // namespace

void CannelloniReader::begin(std::span<const std::uint8_t> datagram) noexcept {
  ++counters_.datagrams;
  left_ = 0;
  rest_ = {};
  if (datagram.size() < kHeader || datagram[0] != kVersion || datagram[1] != kData) {
    ++counters_.bad_header;
    return;
  }
  left_ = static_cast<std::uint16_t>(datagram[3] << 8 | datagram[4]);
  rest_ = datagram.subspan(kHeader);
  if (left_ == 0 && !rest_.empty()) ++counters_.trailing;
}

bool CannelloniReader::end() noexcept {
  left_ = 0;
  return false;
}

bool CannelloniReader::next(CanFrame& frame) noexcept {
  while (left_ > 0) {
    if (rest_.size() < kFrameHeader) {
      ++counters_.truncated;
      return end();
    }
    const std::uint32_t word = big_endian(rest_);
    const bool fd = (rest_[4] & kFd) != 0;
    const std::size_t length = rest_[4] & 0x7Fu;
    const bool remote = (word & kRemote) != 0;
    const std::size_t header = kFrameHeader + (fd ? 1u : 0u);
    const std::size_t bytes = header + (remote ? 0u : length);
    if (length > (fd ? kMaxFdData : frame.data.size())) {  // the begin of the next is unknown
      ++counters_.bad_frame;
      return end();
    }
    if (rest_.size() < bytes) {
      ++counters_.truncated;
      return end();
    }
    const std::span<const std::uint8_t> data = rest_.subspan(header, bytes - header);
    rest_ = rest_.subspan(bytes);
    if (--left_ == 0 && !rest_.empty()) ++counters_.trailing;
    if (fd) {
      ++counters_.can_fd;
      continue;
    }
    frame = {};
    frame.extended = (word & kExtended) != 0;
    frame.remote = remote;
    frame.error = (word & kError) != 0;
    frame.id = word & kExtendedIds;
    if (!frame.extended && !frame.error && frame.id > kStandardIds) {
      ++counters_.bad_frame;
      continue;
    }
    frame.size = static_cast<std::uint8_t>(length);
    std::copy(data.begin(), data.end(), frame.data.begin());
    ++counters_.frames;
    return true;
  }
  return false;
}

bool CannelloniWriter::add(const CanFrame& frame) noexcept {
  const std::uint8_t length = std::min<std::uint8_t>(frame.size, 8);
  const std::size_t data = frame.remote ? 0u : length;
  if (count_ == 0) size_ = kHeader;
  if (size_ + kFrameHeader + data > bytes_.size()) return false;
  const std::uint32_t word = frame.id | (frame.extended ? kExtended : 0u) |
                             (frame.remote ? kRemote : 0u) | (frame.error ? kError : 0u);
  for (int shift = 24; shift >= 0; shift -= 8) {
    bytes_[size_++] = static_cast<std::uint8_t>(word >> shift);
  }
  bytes_[size_++] = length;
  std::copy_n(frame.data.begin(), data, bytes_.begin() + static_cast<std::ptrdiff_t>(size_));
  size_ += data;
  ++count_;
  return true;
}

std::span<const std::uint8_t> CannelloniWriter::take(std::uint8_t sequence) noexcept {
  bytes_[0] = kVersion;
  bytes_[1] = kData;
  bytes_[2] = sequence;
  bytes_[3] = static_cast<std::uint8_t>(count_ >> 8);
  bytes_[4] = static_cast<std::uint8_t>(count_);
  const std::size_t size = count_ == 0 ? kHeader : size_;
  count_ = 0;
  return std::span(bytes_).first(size);
}

}  // namespace lss
