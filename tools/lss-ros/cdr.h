#pragma once

// ROS messages (messages.txt) to and from CDR version 1, little-endian, as ROS 2 sends and records
// them: an encapsulation header of 4 bytes, then the members. Pure.

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

namespace lss::ros {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

inline constexpr std::size_t kCdrHeader = 4;

class CdrWriter {
 public:
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      bytes_.resize(kCdrHeader + (size() + sizeof value - 1) / sizeof value * sizeof value);
      append(&value, sizeof value);
    } else if constexpr (std::is_same_v<T, std::string>) {
      put(static_cast<std::uint32_t>(value.size() + 1));
      append(value.c_str(), value.size() + 1);
    } else if constexpr (requires { value.max_size(), value.begin(), value.end(); }) {
      if constexpr (requires { value.capacity(); }) put(static_cast<std::uint32_t>(value.size()));
      for (const auto& element : value) put(element);
    } else {
      T::each(value, [this](const auto& member) { put(member); });
    }
  }
  std::vector<std::byte> bytes() && { return std::move(bytes_); }

 private:
  std::size_t size() const { return bytes_.size() - kCdrHeader; }
  void append(const void* data, std::size_t size) {
    const auto* bytes = static_cast<const std::byte*>(data);
    bytes_.insert(bytes_.end(), bytes, bytes + size);
  }

  std::vector<std::byte> bytes_{std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
};

// Every get() after the end of the bytes, or of a length that does not fit, is false.
class CdrReader {
 public:
  explicit CdrReader(std::span<const std::byte> message) : all_(message) {
    good_ = all_.size() >= kCdrHeader && all_[0] == std::byte{0} && all_[1] == std::byte{1};
  }

  template <class T>
  bool get(T& value) {
    if constexpr (std::is_arithmetic_v<T>) {
      at_ = kCdrHeader + (at_ - kCdrHeader + sizeof value - 1) / sizeof value * sizeof value;
      if (!has(sizeof value)) return false;
      std::memcpy(&value, all_.data() + at_, sizeof value);
      at_ += sizeof value;
    } else if constexpr (std::is_same_v<T, std::string>) {
      std::uint32_t size = 0;
      if (!get(size) || !has(size)) return false;
      value.assign(reinterpret_cast<const char*>(all_.data() + at_), size == 0 ? 0 : size - 1);
      at_ += size;
    } else if constexpr (requires { value.max_size(), value.begin(), value.end(); }) {
      if constexpr (requires { value.capacity(); }) {
        std::uint32_t size = 0;
        if (!get(size) || !has(size)) return false;  // an element has one byte at least
        value.resize(size);
      }
      for (auto& element : value) get(element);
    } else {
      T::each(value, [this](auto& member) { get(member); });
    }
    return good_;
  }

 private:
  bool has(std::size_t size) {
    good_ = good_ && at_ <= all_.size() && size <= all_.size() - at_;
    return good_;
  }

  std::span<const std::byte> all_;
  std::size_t at_ = kCdrHeader;
  bool good_ = false;
};

template <class Message>
std::vector<std::byte> to_cdr(const Message& message) {
  CdrWriter writer;
  writer.put(message);
  return std::move(writer).bytes();
}
// nullopt: the bytes are not of this type.
template <class Message>
std::optional<Message> from_cdr(std::span<const std::byte> bytes) {
  Message message{};
  CdrReader reader(bytes);
  if (!reader.get(message)) return std::nullopt;
  return message;
}

}  // namespace lss::ros
