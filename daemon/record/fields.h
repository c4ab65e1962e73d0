#pragma once

// Visitors of the members of structs: records are written, read back, compared and shown by the
// same description. visit(v, x) names each member of x to v, by the struct itself (members.h); a
// struct with lists in it has a function fields(v, x) of its own, as those of the IDL, which the
// build describes (cmake/idl_fields.py).
//
//   v("name", member)                 numbers, enums, arrays of them, structs, and variants of
//                                     structs; arrays are std::array, or of C in those of the IDL
//   v.list("name", array, count)      the first `count` elements of an array; count is a member
//
// The writer allocates nothing.

#include <array>
#include <concepts>
#include <cstring>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "daemon/cycle/members.h"
#include "daemon/cycle/supervisor.h"

namespace lss::record {

// v("name", member) for each member; by fields(v, x) where the struct has it.
template <class V, class X>
constexpr void visit(V& v, X& x) {
  if constexpr (requires { fields(v, x); }) {
    fields(v, x);
  } else {
    using T = std::remove_const_t<X>;
    const auto all = members::tie(x);
    [&]<std::size_t... I>(std::index_sequence<I...>) __attribute__((always_inline)) {
      (v(members::kName<T, I>.data(), std::get<I>(all)), ...);
    }
    (std::make_index_sequence<kMembers<T>>());
  }
}

// The members of a base, which the derived struct has to list before its own: it needs a function
// fields() of its own, since a struct's own members cannot be read where it has a base.
template <class Base, class V, class X>
constexpr void visit_base(V& v, X& x) {
  visit(v, static_cast<std::conditional_t<std::is_const_v<X>, const Base, Base>&>(x));
}

// T or const T.
template <class X, class T>
concept Like = std::same_as<std::remove_const_t<X>, T>;

template <class T>
concept Number = std::is_arithmetic_v<T> || std::is_enum_v<T>;

// std::array, or an array of C.
template <class T>
concept Array = requires(T& x) {
  std::size(x);
  x[0];
};
// Characters up to the first NUL.
template <class T>
concept Text = Array<T> && std::same_as < std::remove_cvref_t<decltype(std::declval<T&>()[0])>,
char > ;

// Into a buffer; `size` is larger than the buffer when it was too small.
class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  std::size_t size() const noexcept { return size_; }
  bool fits() const noexcept { return size_ <= buffer_.size(); }

  template <class T>
  [[gnu::always_inline]] void operator()(const char*, const T& x) noexcept {
    put(x);
  }
  template <class T, std::size_t N>
  void list(const char*, const std::array<T, N>& x, const std::uint32_t& count) noexcept {
    put(count);
    for (std::uint32_t i = 0; i < count; ++i) put(x[i]);
  }

 private:
  template <class T>
  void put(const T& x) noexcept {
    if constexpr (Number<T>) {
      append(&x, sizeof x);
    } else {
      record::visit(*this, x);
    }
  }
  template <Array T>
  void put(const T& x) noexcept {
    if constexpr (Number<std::remove_cvref_t<decltype(x[0])>>) {
      append(std::data(x), sizeof x);
    } else {
      for (const auto& element : x) put(element);
    }
  }
  template <class... T>
  void put(const std::variant<T...>& x) noexcept {
    put(static_cast<std::uint8_t>(x.index()));
    std::visit([this](const auto& alternative) { put(alternative); }, x);
  }

  // Not `size_ + size <= ...`: GCC 14 follows the sum where it wraps, and warns of that.
  [[gnu::always_inline]] void append(const void* bytes, std::size_t size) noexcept {
    if (size <= buffer_.size() && size_ <= buffer_.size() - size) {
      std::memcpy(&buffer_[size_], bytes, size);
    }
    size_ += size;
  }

  std::span<std::uint8_t> buffer_;
  std::size_t size_ = 0;
};

// Out of a buffer. Broken input gives zeros and good() == false, never more than the buffer has.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> buffer) noexcept : buffer_(buffer) {}
  bool good() const noexcept { return good_; }
  bool at_end() const noexcept { return at_ == buffer_.size(); }
  std::size_t at() const noexcept { return at_; }

  template <class T>
  void operator()(const char*, T& x) noexcept {
    get(x);
  }
  template <class T, std::size_t N>
  void list(const char*, std::array<T, N>& x, std::uint32_t& count) noexcept {
    get(count);
    if (count > N) {
      count = 0;
      good_ = false;
    }
    for (std::uint32_t i = 0; i < count; ++i) get(x[i]);
  }

 private:
  template <class T>
  void get(T& x) noexcept {
    if constexpr (std::same_as<T, bool>) {  // any other byte in a bool would be undefined
      std::uint8_t byte = 0;
      get(byte);
      good_ = good_ && byte <= 1;
      x = byte != 0;
    } else if constexpr (Number<T>) {
      good_ = good_ && buffer_.size() - at_ >= sizeof x;
      if (!good_) return void(x = T{});
      std::memcpy(&x, &buffer_[at_], sizeof x);
      at_ += sizeof x;
    } else {
      record::visit(*this, x);
    }
  }
  template <Array T>
  void get(T& x) noexcept {
    for (auto& element : x) get(element);
  }
  template <class... T>
  void get(std::variant<T...>& x) noexcept {
    std::uint8_t index = 0;
    get(index);
    good_ = good_ && index < sizeof...(T);
    if (!good_) return;
    [&]<std::size_t... I>(std::index_sequence<I...>) {
      ((I == index ? get(x.template emplace<I>()) : void()), ...);
    }
    (std::index_sequence_for<T...>());
  }

  std::span<const std::uint8_t> buffer_;
  std::size_t at_ = 0;
  bool good_ = true;
};

}  // namespace lss::record

namespace lss {

template <class V, record::Like<Supervisor::Outbox> X>
void fields(V& v, X& x) {
  static_assert(kMembers<Supervisor::Outbox> == 6);  // all but holder
  v.list("acks", x.acks, x.ack_count);
  v.list("events", x.events, x.event_count);
  v("dropped", x.dropped);
}

}  // namespace lss
