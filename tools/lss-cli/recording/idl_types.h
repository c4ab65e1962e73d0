#pragma once

// Types that an IDL text describes, as far as our own files go: modules, enums, structs of numbers,
// characters, enums and structs, and one-dimensional arrays of these. Such a type has a fixed size,
// and every field a fixed place in the CDR bytes. A recording contains its IDL, so that it is read
// by the types of the version that made it. Pure. A text that cannot be read, or is larger than
// mcap_format.h allows, is thrown as a Failure.

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/mcap_format.h"

namespace lss::cli::recording {

enum class Kind : std::uint8_t {
  boolean,
  octet,
  character,
  int16,
  uint16,
  int32,
  uint32,
  int64,
  uint64,
  float32,
  float64,
  enumeration,
  structure,
};

std::size_t size_of(Kind kind);  // bytes; 0: of a structure

struct Type;

struct Member {
  std::string name;
  const Type* type = nullptr;
  std::size_t count = 0;  // elements of an array; 0: not an array
};

struct Type {
  Kind kind = Kind::octet;
  std::string name;  // with its modules: lss::Status
  std::vector<Member> members;
  std::vector<std::string> names;  // of an enumeration
  std::size_t columns = 1;         // when its layout was computed
  std::size_t depth = 0;           // of structs in it, itself included
  std::size_t longest = 0;         // characters of the longest name of a column in it
};

class Types {
 public:
  explicit Types(std::string_view idl);
  const Type* find(std::string_view name) const;  // nullptr when there is none

 private:
  friend class Parser;
  std::map<std::string, std::unique_ptr<Type>, std::less<>> types_;
};

// A number or a text, and its place.
struct Column {
  std::string name;  // modules[3].position_rad
  const Type* type = nullptr;
  std::size_t offset = 0;     // behind the encapsulation header
  std::size_t text_size = 0;  // of an array of char, which is a text; otherwise 0
};

// The layout of a type in the bytes of `cdr`.
class Layout {
 public:
  explicit Layout(const Type& type);

  const Type& type() const { return type_; }
  std::size_t size() const { return size_; }  // without the encapsulation header
  const std::vector<Column>& columns() const { return columns_; }
  const Column* find(std::string_view name) const;

  // Of one message, with its encapsulation header. 64-bit numbers above 2^53 lose digits; a text is
  // NaN.
  double number(const Column& column, Bytes message) const;
  std::string text(const Column& column, Bytes message) const;
  nlohmann::ordered_json json(const Column& column, Bytes message) const;
  // Nested like the type.
  nlohmann::ordered_json json(Bytes message) const;

  // Throws when the bytes are not of this type.
  void check(Bytes message) const;

 private:
  const Type& type_;
  std::vector<Column> columns_;
  std::size_t size_ = 0;
};

}  // namespace lss::cli::recording
