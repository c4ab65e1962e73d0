#pragma once

// Parameters that can change while the daemon runs (docs/parameters.md): each is a key of the
// vehicle's table of the configuration. A vehicle lists them once, in
// daemon/vehicles/NAME/tunables.cpp, with range and unit for the configuration, the armour and the
// clients. Values are in the units of the configuration. Pure functions; any thread; nothing
// allocates.

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include "drivers/time.h"
#include "idl/angles.h"
#include "idl/commands.h"

namespace lss {

// When it may change.
enum class Change : std::uint8_t {
  always,
  at_rest,  // in Idle and FatalError: nothing moves
};

struct TunableInfo {
  const char* name;  // dotted, as in the vehicle's table of the configuration: "limits.current_A"
  const char* unit;  // "A"; "" when it has none
  double min, max;
  Change change;
  bool whole;  // a number without a fraction
  const char* help;
};

struct TunableValues {
  std::array<double, kMaxTunables> value{};
  std::uint32_t count = 0;
  std::uint32_t changes = 0;  // so far
};

// State of the saved parameters.
enum class SavedState : std::uint8_t {
  none,      // nothing was saved
  good,      // both copies are
  one_copy,  // the other one is damaged, of another vehicle or schema, or not there
  partly,    // some values are not taken: unknown, or out of range
  lost,      // no copy is good: the values of the configuration
};

// The contents of lss/parameters.
struct ParameterReport {
  std::span<const TunableInfo> infos;
  TunableValues present, configured;
  std::array<double, kMaxTunables> saved{};  // NaN: the configuration's
  std::uint64_t number = 0;                  // of the last save; 0: none
  SavedState state = SavedState::none;
};

// Equal but for the rounding of a conversion there and back.
inline bool same_value(double a, double b) noexcept {
  return a == b || std::abs(a - b) <= 1e-9 * std::max(std::abs(a), std::abs(b));
}

// -1: there is none. The name ends at the first NUL, if it has one.
inline int find_tunable(std::span<const TunableInfo> all, std::string_view name) noexcept {
  name = name.substr(0, name.find('\0'));
  for (std::size_t i = 0; i < all.size(); ++i) {
    if (name == all[i].name) return static_cast<int>(i);
  }
  return -1;
}

// Whether the value alone is valid: finite, in range, whole where it has to be.
inline bool in_range(const TunableInfo& t, double value) noexcept {
  return value >= t.min && value <= t.max && (!t.whole || value == std::floor(value));
}

// Member of the vehicle's parameters P that stores the value.
using TunablePlace = std::variant<double*, TimeNs*, int*, unsigned*>;
template <class P>
struct Tunable {
  TunableInfo info;
  double factor;  // from the unit of the configuration to that of the member
  TunablePlace (*place)(P& parameters);
};

namespace way {
template <class X, class Step>
constexpr auto& follow(X& x, Step step) noexcept {
  if constexpr (std::is_member_pointer_v<Step>) {
    return x.*step;
  } else {
    return x[static_cast<std::size_t>(step)];
  }
}
template <class X, class Step, class... Steps>
constexpr auto& follow(X& x, Step step, Steps... steps) noexcept {
  return follow(follow(x, step), steps...);
}
template <class P, class T>
P owner(T P::*);
}  // namespace way

// A line of the list: the way to the member (pointers to members, indices), its key in the
// configuration, unit, range. In units of degrees the member is in radians; in s and ms it is a
// number in that unit, or a TimeNs. Members of whole numbers take whole numbers only.
template <auto First, auto... Path>
consteval auto tunable(const char* name, const char* unit, double min, double max, Change change,
                       const char* help, bool whole = false) {
  using P = decltype(way::owner(First));
  using Member = std::remove_reference_t<decltype(way::follow(std::declval<P&>(), First, Path...))>;
  const std::string_view u = unit;
  double factor = u == "deg" || u == "deg/s" ? kDegree : 1;
  if (std::is_same_v<Member, TimeNs>) factor = u == "s" ? 1e9 : u == "ms" ? 1e6 : throw "s or ms";
  whole = whole || (std::is_integral_v<Member> && factor == 1);
  return Tunable<P>{{name, unit, min, max, change, whole, help}, factor, [](P& p) -> TunablePlace {
                      return &way::follow(p, First, Path...);
                    }};
}

template <class P, std::size_t N>
constexpr std::array<TunableInfo, N> infos_of(const std::array<Tunable<P>, N>& tunables) {
  static_assert(N <= kMaxTunables);
  std::array<TunableInfo, N> infos{};
  for (std::size_t i = 0; i < N; ++i) infos[i] = tunables[i].info;
  return infos;
}

template <const auto& kTunables>
inline constexpr auto kInfosOf = infos_of(kTunables);

template <class P>
void set_tunable(const Tunable<P>& t, P& parameters, double value) noexcept {
  const double scaled = value * t.factor;
  std::visit(
      [scaled](auto* member) {
        using T = std::remove_pointer_t<decltype(member)>;
        if constexpr (std::is_floating_point_v<T>) {
          *member = scaled;
        } else {
          *member = static_cast<T>(std::llround(scaled));
        }
      },
      t.place(parameters));
}

// To twelve digits: as a person would write it.
template <class P>
double get_tunable(const Tunable<P>& t, const P& parameters) noexcept {
  P copy = parameters;
  const double value =
      std::visit([](auto* member) { return static_cast<double>(*member); }, t.place(copy)) /
      t.factor;
  if (value == 0 || !std::isfinite(value)) return value;
  std::array<char, 32>
      text{};  // -d.ddddddddddde-ddd: the same on every processor, and no allocation
  const auto end =
      std::to_chars(text.begin(), text.end(), value, std::chars_format::scientific, 11);
  double rounded = value;
  std::from_chars(text.begin(), end.ptr, rounded);
  return rounded;
}

// All parameters of a vehicle.
template <class P>
struct Tuning {
  std::span<const Tunable<P>> tunables;
  std::span<const TunableInfo> infos;         // of the same
  void (*derive)(P& parameters) = [](P&) {};  // computes dependent values
  // nullptr, or why they do not fit together
  const char* (*check)(const P& parameters) = [](const P&) -> const char* { return nullptr; };
};

template <class P>
TunableValues values_of(std::span<const Tunable<P>> tunables, const P& parameters) noexcept {
  TunableValues values;
  for (const Tunable<P>& t : tunables) values.value[values.count++] = get_tunable(t, parameters);
  return values;
}

// Sets value `index` to `value`, which is in range; false, and nothing changes, when it does not
// fit the others. `really` false: only checks.
template <class P>
bool adjust(const Tuning<P>& tuning, P& parameters, TunableValues& values, std::size_t index,
            double value, bool really) noexcept {
  P changed = parameters;
  set_tunable(tuning.tunables[index], changed, value);
  tuning.derive(changed);
  if (tuning.check(changed) != nullptr) return false;
  if (!really) return true;
  parameters = changed;
  values.value[index] = value;
  ++values.changes;
  return true;
}

}  // namespace lss
