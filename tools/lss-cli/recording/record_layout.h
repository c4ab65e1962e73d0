#pragma once

// Records of flight recordings, read with the description in the file's header (docs/recording.md),
// so that recordings of any vehicle and any version of lssd can be read. One thread. Errors are
// thrown as a Failure.
//
// Fields are named by their path, as a replay names them: telemetry.modules[3].position_rad. A
// pattern names a field with all its parts; `*` matches any text, and "telemetry." may be omitted.

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "idl/codes.h"
#include "tools/lss-cli/recording/record_schema.h"

namespace lss::cli::recording {

class RecordLayout {
 public:
  using Bytes = std::span<const std::uint8_t>;
  using Json = nlohmann::ordered_json;

  explicit RecordLayout(std::string_view schema);
  ~RecordLayout();
  RecordLayout(RecordLayout&&) noexcept;

  // Selects the output of json(), values() and columns(). Throws unknown_name when a pattern
  // matches nothing. Initially all fields are chosen.
  void choose(const std::vector<std::string>& patterns);
  // All fields that have a place in every record: all except lists.
  void choose_what_is_always_there();

  // The codes of the recording's vehicle, for json(); without them they stay numbers.
  void name_codes(const OwnCodes& own) { own_ = own; }

  // Nested like the structs. In an array, elements that are not chosen but precede a chosen one are
  // null. Names instead of numbers where lssd has names, null for NaN.
  Json json(Bytes record);

  struct Column {
    std::string name, type;  // "u4", as in the schema; "text"
  };
  // Numbers and texts in the order of the schema. A list has as many elements as were found so far,
  // at least one.
  std::vector<Column> columns();
  // Notes the lengths of the lists.
  void look(Bytes record);
  // In the order of columns(); null where this record has no value, and for NaN. Numbers stay
  // numbers.
  void values(Bytes record, std::vector<Json>& values);

  // The place of an 8-byte number in every record; nothing when its place varies.
  std::optional<std::size_t> place(std::string_view name) const;

 private:
  struct Node;
  class Walk;

  static std::unique_ptr<Node> expand(const RecordType& type, std::string path, bool in_list);
  void mark(Node& node) const;
  bool meant(const std::string& path) const;
  bool may_be_meant(const Node& node) const;
  void number_columns();

  std::unique_ptr<RecordType> type_;
  std::unique_ptr<Node> root_;
  std::vector<std::string> patterns_, loose_;
  bool lists_ = true;
  std::size_t fields_ = 0;  // that root_ has
  std::vector<Column> columns_;
  OwnCodes own_{};
};

}  // namespace lss::cli::recording
