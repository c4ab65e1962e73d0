#pragma once

// The first member in which structs differ from the bytes of a record. Every bit counts: 0.0 is not
// -0.0. Only the bits of a NaN do not. Ordinary threads.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <optional>
#include <span>
#include <string>
#include <variant>

#include "daemon/record/fields.h"
#include "daemon/record/vehicle_records.h"

namespace lss::record {

class Compare {
 public:
  explicit Compare(std::span<const std::uint8_t> recorded) : recorded_(recorded) {}
  const std::optional<Difference>& difference() const noexcept { return difference_; }

  template <class T>
  void operator()(const char* name, const T& x) {
    inside(name, x);
  }
  template <class T, std::size_t N>
  void list(const char* name, const std::array<T, N>& x, const std::uint32_t& count) {
    inside(std::string(name) + ".count", count);
    for (std::uint32_t i = 0; i < count && !difference_; ++i)
      inside(fmt::format("{}[{}]", name, i), x[i]);
  }

 private:
  template <class T>
  void inside(const std::string& name, const T& x) {
    if (difference_) return;
    const std::size_t before = path_.size();
    if (!path_.empty() && name.front() != '[') path_ += '.';
    path_ += name;
    compare(x);
    path_.resize(before);
  }

  template <class T>
  void compare(const T& x) {
    if constexpr (Number<T>) {
      if (recorded_.size() < sizeof x) {
        difference_ = {path_, "the record ends here", text(x)};
        return;
      }
      if (std::memcmp(recorded_.data(), &x, sizeof x) != 0) {
        if constexpr (std::same_as<T, bool>) {  // another byte is not a bool
          difference_ = {path_, fmt::format("{}", recorded_[0]), text(x)};
        } else {
          T was;
          std::memcpy(&was, recorded_.data(), sizeof was);
          if (!both_nan(was, x)) difference_ = {path_, text(was), text(x)};
        }
      }
      recorded_ = recorded_.subspan(sizeof x);
    } else {
      record::visit(*this, x);
    }
  }
  template <Array T>
  void compare(const T& x) {
    for (std::size_t i = 0; i < std::size(x) && !difference_; ++i)
      inside(fmt::format("[{}]", i), x[i]);
  }
  // Text is shown as a whole.
  template <Text T>
  void compare(const T& x) {
    const std::size_t size = std::size(x);
    if (recorded_.size() < size || std::memcmp(recorded_.data(), std::data(x), size) != 0) {
      const auto shown = [](const char* c, std::size_t n) {
        return '"' + std::string(c, ::strnlen(c, n)) + '"';
      };
      difference_ = {
          path_,
          shown(reinterpret_cast<const char*>(recorded_.data()), std::min(size, recorded_.size())),
          shown(std::data(x), size)};
    } else {
      recorded_ = recorded_.subspan(size);
    }
  }
  template <class... T>
  void compare(const std::variant<T...>& x) {
    inside("kind", static_cast<std::uint8_t>(x.index()));
    if (!difference_) std::visit([this](const auto& alternative) { compare(alternative); }, x);
  }

  // The sign of a new NaN depends on the processor (IEEE 754-2019, 6.3).
  template <class T>
  static bool both_nan(const T& a, const T& b) {
    if constexpr (std::is_floating_point_v<T>) {
      return std::isnan(a) && std::isnan(b);
    } else {
      return false;
    }
  }

  template <class T>
  static std::string text(const T& x) {
    if constexpr (std::is_enum_v<T>) {
      return text(static_cast<std::underlying_type_t<T>>(x));
    } else if constexpr (std::same_as<T, double>) {
      return fmt::format("{:.17g} ({:#018x})", x, std::bit_cast<std::uint64_t>(x));
    } else if constexpr (std::same_as<T, float>) {
      return fmt::format("{:.9g} ({:#010x})", x, std::bit_cast<std::uint32_t>(x));
    } else if constexpr (std::same_as<T, bool>) {
      return x ? "1" : "0";
    } else {
      return std::to_string(x);
    }
  }

  std::span<const std::uint8_t> recorded_;
  std::string path_;
  std::optional<Difference> difference_;
};

}  // namespace lss::record
