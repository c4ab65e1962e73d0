#pragma once

// The members of a plain struct, in their order, with their names: read from the struct itself, so
// that none can be forgotten. For structs without bases and without arrays of C (std::array
// instead), of at most 26 members; others do not compile. Costs nothing at run time.

#include <array>
#include <cstddef>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>

namespace lss {
namespace members {

struct Any {
  template <class T>
  constexpr operator T() const noexcept;  // NOLINT(google-explicit-constructor)
};

template <class T, std::size_t... I>
consteval bool takes(std::index_sequence<I...>) {
  return requires { T{(static_cast<void>(I), Any{})...}; };
}
template <class T, std::size_t N = 1>
consteval std::size_t count() {
  static_assert(std::is_aggregate_v<T>, "no plain struct: it needs a function fields() of its own");
  if constexpr (takes<T>(std::make_index_sequence<N>())) {
    return count<T, N + 1>();
  } else {
    return N - 1;
  }
}

// References to all members.
template <class T>
constexpr auto tie(T& x) noexcept {
  constexpr std::size_t kCount = count<std::remove_const_t<T>>();
#define LSS_TIE(n, ...)           \
  if constexpr (kCount == n) {    \
    auto& [__VA_ARGS__] = x;      \
    return std::tie(__VA_ARGS__); \
  }
  LSS_TIE(1, a)
  LSS_TIE(2, a, b)
  LSS_TIE(3, a, b, c)
  LSS_TIE(4, a, b, c, d)
  LSS_TIE(5, a, b, c, d, e)
  LSS_TIE(6, a, b, c, d, e, f)
  LSS_TIE(7, a, b, c, d, e, f, g)
  LSS_TIE(8, a, b, c, d, e, f, g, h)
  LSS_TIE(9, a, b, c, d, e, f, g, h, i)
  LSS_TIE(10, a, b, c, d, e, f, g, h, i, j)
  LSS_TIE(11, a, b, c, d, e, f, g, h, i, j, k)
  LSS_TIE(12, a, b, c, d, e, f, g, h, i, j, k, l)
  LSS_TIE(13, a, b, c, d, e, f, g, h, i, j, k, l, m)
  LSS_TIE(14, a, b, c, d, e, f, g, h, i, j, k, l, m, n)
  LSS_TIE(15, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o)
  LSS_TIE(16, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p)
  LSS_TIE(17, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q)
  LSS_TIE(18, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r)
  LSS_TIE(19, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s)
  LSS_TIE(20, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t)
  LSS_TIE(21, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u)
  LSS_TIE(22, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v)
  LSS_TIE(23, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w)
  LSS_TIE(24, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, y)
  LSS_TIE(25, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, y, z)
  LSS_TIE(26, a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p, q, r, s, t, u, v, w, y, z, A)
#undef LSS_TIE
  static_assert(kCount <= 26);
}

// A name is read from the compiler's own name of a pointer to the member of an object that is
// declared only. clang before 18 has no such pointers; here it only checks sources.
#if !defined(__clang__) || __clang_major__ >= 18
template <class T>
struct Declared {
  T x;
};
template <class T>
extern const Declared<T> declared;
template <auto*>
consteval std::string_view pretty() {
  std::string_view all = __PRETTY_FUNCTION__;  // ... T::name); std::string_view = ...]
  all = all.substr(0, all.rfind(");"));
  return all.substr(all.rfind(':') + 1);
}
template <class T, std::size_t I>
inline constexpr auto kName = [] {
  constexpr std::string_view name = pretty<&std::get<I>(tie(declared<T>.x))>();
  static_assert(!name.empty() && name.find_first_of(" <>(&.") == name.npos);
  std::array<char, name.size() + 1> text{};
  name.copy(text.data(), name.size());
  return text;
}();
#else
template <class T, std::size_t I>
inline constexpr std::array<char, 2> kName{'?'};
#endif

}  // namespace members

template <class T>
inline constexpr std::size_t kMembers = members::count<T>();

}  // namespace lss
