#pragma once

// The object dictionary of a simulated CANopen node: what can be read and written by SDO and mapped
// into PDOs (CiA 301). Values are the bits on the bus. One thread at a time; nothing allocates
// after construction.

#include <cstdint>
#include <span>
#include <vector>

namespace lss::sim::nodes {

// Abort codes of SDO.
enum Abort : std::uint32_t {
  kDone = 0,
  kUnknownCommand = 0x05040001,
  kNoAccess = 0x06010000,
  kReadOnly = 0x06010002,
  kNoObject = 0x06020000,
  kNotMappable = 0x06040041,
  kPdoTooLong = 0x06040042,
  kWrongLength = 0x06070010,
  kNoSubIndex = 0x06090011,
  kOutOfRange = 0x06090030,
};

enum class Access : std::uint8_t { read_only, read_write };
inline constexpr auto rw = Access::read_write;
inline constexpr std::int64_t kMost = 0x7FFFFFFF;  // of an i32 that must not be negative

struct Object {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 4;
  Access access = Access::read_only;
  std::int64_t initial = 0;
  bool mappable = false;
  bool is_signed = false;
  std::int64_t min = 0, max = 0;  // of what may be written; both 0: anything
};

class Objects {
 public:
  void add(const Object& object) {
    entries_.push_back({object, static_cast<std::uint32_t>(object.initial)});
  }
  void add(std::span<const Object> objects);
  void reset();  // all values to their initial ones

  const Object* find(std::uint16_t index, std::uint8_t sub) const;
  bool has_index(std::uint16_t index) const;
  std::uint32_t get(std::uint16_t index, std::uint8_t sub) const;  // 0 when there is none
  std::int64_t get_signed(std::uint16_t index, std::uint8_t sub) const;
  void set(std::uint16_t index, std::uint8_t sub, std::int64_t value);

  // The SDO answer to this write.
  Abort check(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value) const;

 private:
  struct Entry {
    Object object;
    std::uint32_t value;
  };
  Entry* entry(std::uint16_t index, std::uint8_t sub);
  const Entry* entry(std::uint16_t index, std::uint8_t sub) const;

  std::vector<Entry> entries_;
};

// Sign-extends the low `bytes` of a value in a frame.
std::int64_t to_signed(std::uint32_t value, std::size_t bytes);

}  // namespace lss::sim::nodes
