#pragma once

// Records of flight recordings, read by the description that stands in the file's header
// (docs/recording.md), so that those of any vehicle and of any version of lssd are read. One
// thread. What cannot be read is thrown as a Failure.
//
// Fields are named by their path, as a replay names them: telemetry.modules[3].position_rad. A
// pattern names a field with everything in it; `*` stands for anything, and "telemetry." may be
// left out.

#include <cstdint>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/record_schema.h"

namespace lss::cli::recording {

class RecordLayout {
 public:
  using Octets = std::span<const std::uint8_t>;
  using Json = nlohmann::ordered_json;

  explicit RecordLayout(std::string_view schema);
  ~RecordLayout();
  RecordLayout(RecordLayout&&) noexcept;

  // What json(), values() and columns() give from now on; unknown_name when there is none of a
  // pattern. At first everything is chosen.
  void choose(const std::vector<std::string>& patterns);
  // All that has its place in every record, which is everything but lists.
  void choose_what_is_always_there();

  // Nested as the structs are; of an array, what is not chosen before what is, is null. Names
  // instead of numbers for what lssd names, null for NaN.
  Json json(Octets record);

  struct Column {
    std::string name, type;  // "u4", as in the schema; "text"
  };
  // Numbers and texts in the order of the schema. Of a list as many elements as were seen so far,
  // at least one.
  std::vector<Column> columns();
  // Sees how long the lists are.
  void look(Octets record);
  // In the order of columns(); null where this record has none, and for NaN. Numbers stay numbers.
  void values(Octets record, std::vector<Json>& values);

  // Where a number of 8 octets stands in every record; nothing when it has no fixed place.
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
};

}  // namespace lss::cli::recording
