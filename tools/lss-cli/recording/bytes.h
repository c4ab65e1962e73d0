#pragma once

// Writes and reads the little-endian bytes of MCAP records, and computes the checksum of MCAP. A
// Reader that runs past its end throws Torn.

#include <bit>
#include <boost/crc.hpp>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>

namespace lss::cli::recording {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

using Bytes = std::span<const std::byte>;
using Texts = std::map<std::string, std::string>;

inline Bytes bytes_of(std::string_view text) { return std::as_bytes(std::span(text)); }

// CRC32 of zlib.
class Crc {
 public:
  void add(Bytes data) { crc_.process_bytes(data.data(), data.size()); }
  std::uint32_t value() const { return crc_.checksum(); }

 private:
  boost::crc_32_type crc_;
};

inline std::uint32_t crc_of(Bytes data) {
  Crc crc;
  crc.add(data);
  return crc.value();
}

// A growing array of bytes. A text, map or block has its length before it.
class Writer {
 public:
  // Numbers, texts and maps of texts, one after the other.
  template <class... Parts>
  static Writer of(const Parts&... parts) {
    Writer out;
    out.add(parts...);
    return out;
  }
  template <class... Parts>
  void add(const Parts&... parts) {
    (put(parts), ...);
  }
  template <class Number>
  void number(Number value) {
    out_.append(reinterpret_cast<const char*>(&value), sizeof value);
  }
  void raw(Bytes data) { out_.append(reinterpret_cast<const char*>(data.data()), data.size()); }
  void text(std::string_view text) {
    number(static_cast<std::uint32_t>(text.size()));
    out_.append(text);
  }
  void texts(const Texts& map) {
    Writer inner;
    for (const auto& [key, value] : map) {
      inner.text(key);
      inner.text(value);
    }
    text(inner.out_);
  }
  void block(Bytes data) {
    number(static_cast<std::uint64_t>(data.size()));
    raw(data);
  }
  // A whole record: opcode, length, content.
  void record(std::uint8_t opcode, const Writer& content) {
    number(opcode);
    block(content.data());
  }

  Bytes data() const { return bytes_of(out_); }
  const std::string& str() const { return out_; }
  std::size_t size() const { return out_.size(); }
  void clear() { out_.clear(); }

 private:
  template <class Part>
  void put(const Part& part) {
    if constexpr (std::is_arithmetic_v<Part>) {
      number(part);
    } else if constexpr (std::is_same_v<Part, Texts>) {
      texts(part);
    } else {
      text(part);
    }
  }

  std::string out_;
};

// There are fewer bytes than expected.
class Torn : public std::runtime_error {
 public:
  Torn() : std::runtime_error("torn") {}
};

class Reader {
 public:
  explicit Reader(Bytes data) : data_(data) {}

  template <class Number>
  Number number() {
    Number value{};
    std::memcpy(&value, take(sizeof value).data(), sizeof value);
    return value;
  }
  Bytes take(std::size_t size) {
    if (size > data_.size() - at_) throw Torn();
    at_ += size;
    return data_.subspan(at_ - size, size);
  }
  Bytes block() { return take(static_cast<std::size_t>(number<std::uint64_t>())); }
  Bytes sized32() { return take(number<std::uint32_t>()); }
  std::string text() {
    const Bytes inner = sized32();
    return {reinterpret_cast<const char*>(inner.data()), inner.size()};
  }
  Texts texts() {
    Reader inner(sized32());
    Texts map;
    while (!inner.empty()) {
      const std::string key = inner.text();
      map[key] = inner.text();
    }
    return map;
  }

  bool empty() const { return at_ == data_.size(); }
  std::size_t at() const { return at_; }
  Bytes rest() const { return data_.subspan(at_); }

 private:
  Bytes data_;
  std::size_t at_ = 0;
};

}  // namespace lss::cli::recording
