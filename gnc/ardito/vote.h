#pragma once

// Bitwise majority of three equal objects, member by member: padding is never read. A type takes
// part by a static members(self) that ties all its members; the compiler checks that all are tied
// and that there is no padding (kAllMembersTied).

#include <array>
#include <bit>
#include <cstdint>
#include <tuple>
#include <type_traits>
#include <utility>

namespace lss::gnc::ardito {

template <class T>
concept Tied = requires(T& t) {
  T::members(t);
};

template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};

// Bytes of all scalars in T.
template <class T>
constexpr std::size_t tied_size() noexcept {
  if constexpr (IsArray<T>::value) {
    return std::tuple_size_v<T> * tied_size<typename T::value_type>();
  } else if constexpr (Tied<T>) {
    return []<class... M>(std::type_identity<std::tuple<M&...>>) {
      return (tied_size<M>() + ... + std::size_t{0});
    }(std::type_identity<decltype(T::members(std::declval<T&>()))>{});
  } else {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>, "T needs members()");
    return sizeof(T);
  }
}

template <class T>
inline constexpr bool kAllMembersTied = tied_size<T>() == sizeof(T);

// Writes the bitwise majority into all three; returns a bit for each that differed from it.
template <class T>
std::uint32_t vote(T& a, T& b, T& c) noexcept {
  if constexpr (IsArray<T>::value) {
    std::uint32_t different = 0;
    for (std::size_t i = 0; i < a.size(); ++i) different |= vote(a[i], b[i], c[i]);
    return different;
  } else if constexpr (Tied<T>) {
    return [&]<std::size_t... I>(std::index_sequence<I...>, auto x, auto y, auto z) {
      return (vote(std::get<I>(x), std::get<I>(y), std::get<I>(z)) | ... | 0U);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(T::members(a))>>{}, T::members(a),
     T::members(b), T::members(c));
  } else {
    static_assert(sizeof(T) == 8 || sizeof(T) == 4);
    using Bits = std::conditional_t<sizeof(T) == 8, std::uint64_t, std::uint32_t>;
    const Bits x = std::bit_cast<Bits>(a), y = std::bit_cast<Bits>(b), z = std::bit_cast<Bits>(c);
    const Bits majority = (x & y) | (y & z) | (z & x);
    const T value = std::bit_cast<T>(majority);
    a = value;
    b = value;
    c = value;
    return (x != majority ? 1U : 0U) | (y != majority ? 2U : 0U) | (z != majority ? 4U : 0U);
  }
}

}  // namespace lss::gnc::ardito
