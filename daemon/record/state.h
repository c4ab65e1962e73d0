#pragma once

// The state of a vehicle between frames, as bytes: a replay can begin with it in mid-run
// (docs/recording.md). A class names in keep(v) all members that the cycle changes:
//
//   template <class V> void keep(V& v) { v(navigation_, orders_, solver_); }
//
// A member that is missing there does not build (cmake/kept_members.py), unless it is a pointer or
// the comment behind it says why it has "no state".
//
// Members with keep() are visited by it; the others are copied as they are in memory, so they must
// not contain pointers. That suits programs of the same layout, which StateLayout describes. Only
// StateLayout allocates.

#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>

namespace lss::record {

template <class T, class V>
concept Keeps = requires(T& x, V& v) {
  x.keep(v);
};

// A member without keep(). Eigen's fixed matrices are plain, but not trivially copyable.
template <class T>
constexpr void check_plain() {
  static_assert(!std::is_polymorphic_v<T> && !std::is_pointer_v<T> && !std::is_reference_v<T> &&
                    std::is_trivially_destructible_v<T>,
                "no plain member: give its class keep()");
}

class StateWriter {
 public:
  explicit StateWriter(std::span<std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  std::size_t size() const noexcept { return size_; }
  bool fits() const noexcept { return size_ <= buffer_.size(); }

  template <class... T>
  void operator()(T&... members) noexcept {
    (put(members), ...);
  }

 private:
  template <class T>
  void put(T& x) noexcept {
    if constexpr (Keeps<T, StateWriter>) {
      x.keep(*this);
    } else {
      check_plain<T>();
      if (size_ + sizeof x <= buffer_.size()) std::memcpy(&buffer_[size_], &x, sizeof x);
      size_ += sizeof x;
    }
  }

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
};

// good(): as many bytes as the members have.
class StateReader {
 public:
  explicit StateReader(std::span<const std::uint8_t> bytes) noexcept : bytes_(bytes) {}
  bool good() const noexcept { return good_ && bytes_.empty(); }

  template <class... T>
  void operator()(T&... members) noexcept {
    (get(members), ...);
  }

 private:
  template <class T>
  void get(T& x) noexcept {
    if constexpr (Keeps<T, StateReader>) {
      x.keep(*this);
    } else {
      check_plain<T>();
      good_ = good_ && bytes_.size() >= sizeof x;
      if (!good_) return;
      std::memcpy(static_cast<void*>(&x), bytes_.data(), sizeof x);
      bytes_ = bytes_.subspan(sizeof x);
    }
  }

  std::span<const std::uint8_t> bytes_;
  bool good_ = true;
};

// The complete state of a daemon between two frames.
template <class V, class Vehicle, class Supervisor>
void keep(V& v, Vehicle& vehicle, Supervisor& supervisor, typename Vehicle::Telemetry& telemetry) {
  v(vehicle, supervisor, telemetry);
}

// The sizes of the members, in their order.
class StateLayout {
 public:
  template <class... T>
  void operator()(T&... members) {
    (add(members), ...);
  }
  const std::string& text() const noexcept { return text_; }

 private:
  template <class T>
  void add(T& x) {
    if constexpr (Keeps<T, StateLayout>) {
      text_ += '{';
      x.keep(*this);
      text_ += '}';
    } else {
      text_ += std::to_string(sizeof x) + ' ';
    }
  }

  std::string text_;
};

}  // namespace lss::record
