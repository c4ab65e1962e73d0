#pragma once

// The structure of a record as text: members in their order, with their types. It is in the header
// of a recording, so that a program reads only what it knows, and other programs can read it
// (grammar: docs/recording.md). Made by visit() of fields.h; ordinary threads.

#include <array>
#include <concepts>
#include <string>
#include <type_traits>
#include <variant>

#include "daemon/record/fields.h"

namespace lss::record {

class Schema {
 public:
  template <class T>
  void operator()(const char* name, const T& x) {
    text_ += name;
    text_ += ':';
    type(x);
    text_ += ';';
  }
  template <class T, std::size_t N>
  void list(const char* name, const std::array<T, N>& x, const std::uint32_t&) {
    text_ += name;
    text_ += ":<";
    type(x[0]);
    text_ += ">;";
  }
  const std::string& text() const noexcept { return text_; }

 private:
  template <class T>
  void type(const T& x) {
    if constexpr (std::is_enum_v<T>) {
      type(std::underlying_type_t<T>{});
    } else if constexpr (std::same_as<T, bool>) {
      text_ += "b1";
    } else if constexpr (std::same_as<T, char>) {
      text_ += "c1";
    } else if constexpr (Number<T>) {
      text_ += std::floating_point<T> ? 'f' : std::unsigned_integral<T> ? 'u' : 'i';
      text_ += std::to_string(sizeof x);
    } else {
      text_ += '{';
      record::visit(*this, x);
      text_ += '}';
    }
  }
  template <Array T>
  void type(const T& x) {
    text_ += '[' + std::to_string(std::size(x)) + ']';
    type(x[0]);
  }
  template <class... T>
  void type(const std::variant<T...>&) {
    text_ += '(';
    bool first = true;
    ((text_ += first ? "" : "|", first = false, type(T{})), ...);
    text_ += ')';
  }

  std::string text_;
};

}  // namespace lss::record
