#include "drivers/zebro/ascii_codec.h"

namespace lss::zebro {
namespace {

constexpr char kStart = ':';
constexpr char kDigits[] = "0123456789ABCDEF";
constexpr std::size_t kStopAt = 1 + 2 * kFrameBytes;  // place of the first stop character

// -1: no legal digit; lower case is none.
constexpr auto kValues = [] {
  std::array<std::int8_t, 256> values{};
  values.fill(-1);
  for (std::int8_t i = 0; i < 16; ++i) values[static_cast<std::uint8_t>(kDigits[i])] = i;
  return values;
}();

std::uint8_t lrc(std::span<const std::uint8_t> bytes) {
  unsigned sum = 0;
  for (const std::uint8_t b : bytes) sum += b;
  return static_cast<std::uint8_t>(-sum);
}

std::uint8_t crc8(std::span<const std::uint8_t> bytes) {
  unsigned crc = 0xFF;
  for (const std::uint8_t b : bytes) {
    crc ^= b;
    for (int bit = 0; bit < 8; ++bit) crc = (crc << 1) ^ ((crc & 0x80u) != 0 ? 0x12Fu : 0u);
  }
  return static_cast<std::uint8_t>(crc ^ 0xFFu);
}

}  // namespace

std::uint8_t check_value(Check check, std::span<const std::uint8_t> bytes) noexcept {
  return check == Check::lrc ? lrc(bytes) : crc8(bytes);
}

std::span<const std::uint8_t> encode(const Frame& frame, Check check, Stop stop,
                                     std::span<std::uint8_t, kMaxFrameCharacters> out) noexcept {
  std::array<std::uint8_t, kFrameBytes> bytes{frame.address, frame.code};
  for (std::size_t i = 0; i < kFrameData; ++i) bytes[2 + i] = frame.data[i];
  bytes.back() = check_value(check, std::span(bytes).first(kFrameBytes - 1));

  std::size_t n = 0;
  out[n++] = kStart;
  for (const std::uint8_t b : bytes) {
    out[n++] = static_cast<std::uint8_t>(kDigits[b >> 4]);
    out[n++] = static_cast<std::uint8_t>(kDigits[b & 0xF]);
  }
  if (stop == Stop::crlf) out[n++] = '\r';
  out[n++] = '\n';
  return out.first(n);
}

void Receiver::receive(std::span<const std::uint8_t> bytes, TimeNs now) noexcept {
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    i += digits(bytes.subspan(i));
    if (i < bytes.size()) character(bytes[i], now);
  }
}

// Takes the next digits of a frame, which are most of the received data; how many.
std::size_t Receiver::digits(std::span<const std::uint8_t> bytes) noexcept {
  if (place_ != Place::inside) return 0;
  std::size_t taken = 0;
  for (; characters_ < kStopAt && taken < bytes.size(); ++characters_, ++taken) {
    const int value = kValues[bytes[taken]];
    if (value < 0) break;
    std::uint8_t& byte = bytes_[(characters_ - 1) / 2];
    byte = static_cast<std::uint8_t>((byte << 4) | value);
  }
  return taken;
}

std::optional<Received> Receiver::take() noexcept {
  if (waiting_ == 0) return std::nullopt;
  const Received oldest = received_[first_];
  first_ = (first_ + 1) % kCapacity;
  --waiting_;
  return oldest;
}

void Receiver::clear() noexcept {
  place_ = Place::outside;
  first_ = waiting_ = 0;
}

void Receiver::character(std::uint8_t c, TimeNs now) noexcept {
  switch (place_) {
    case Place::outside:
      if (c == kStart) return begin(now);
      return drop(counters_.bad_start, c);
    case Place::skipping:
      if (c == kStart) return begin(now);
      if (c == '\n') place_ = Place::outside;
      return;
    case Place::inside: return inside(c, now);
  }
}

void Receiver::inside(std::uint8_t c, TimeNs now) noexcept {
  if (c == kStart) {
    ++counters_.bad_length;
    return begin(now);
  }
  const bool at_stop = characters_ >= kStopAt;
  if (c == '\n' || at_stop) {
    if (c == '\n' && characters_ + 1 == frame_characters(stop_)) return finish();
    if (c == '\r' && characters_ == kStopAt && stop_ == Stop::crlf) {
      ++characters_;
      return;
    }
    return drop(counters_.bad_length, c);
  }
  drop(counters_.bad_character, c);  // digits() would have taken a digit
}

void Receiver::begin(TimeNs now) noexcept {
  place_ = Place::inside;
  characters_ = 1;
  begun_ns_ = now;
}

void Receiver::finish() noexcept {
  place_ = Place::outside;
  if (check_value(check_, std::span(bytes_).first(kFrameBytes - 1)) != bytes_.back()) {
    ++counters_.bad_check;
    return;
  }
  if (waiting_ == kCapacity) {
    ++counters_.overflows;
    take();
  }
  Received& slot = received_[(first_ + waiting_) % kCapacity];
  slot.time_ns = begun_ns_;
  slot.frame.address = bytes_[0];
  slot.frame.code = bytes_[1];
  for (std::size_t i = 0; i < kFrameData; ++i) slot.frame.data[i] = bytes_[2 + i];
  ++waiting_;
}

void Receiver::drop(std::uint64_t& cause, std::uint8_t last) noexcept {
  ++cause;
  place_ = last == '\n' ? Place::outside : Place::skipping;
}

}  // namespace lss::zebro
