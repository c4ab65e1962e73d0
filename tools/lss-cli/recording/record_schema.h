#pragma once

// The description of records in the header of a flight recording (docs/recording.md), as a tree.
// Pure. A description that cannot be read, or is larger than daemon/record/limits.h allows, is
// thrown as a Failure.

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lss::cli::recording {

struct RecordType {
  char what = 0;          // i u f b c: a number; { [ < (
  std::size_t count = 0;  // bytes of a number, elements of an array
  struct Member {
    std::string name;  // empty except in a struct
    std::unique_ptr<RecordType> type;
  };
  std::vector<Member> members;
  std::optional<std::size_t> size;  // in bytes, where it is constant
  std::size_t least = 0;            // bytes, at least
  std::size_t fields = 1;           // with one element of each list

  bool number() const { return std::string_view("iufbc").find(what) != std::string_view::npos; }
  bool text() const { return what == '[' && members.front().type->what == 'c'; }
  std::string name() const { return text() ? "text" : what + std::to_string(count); }
};

// The struct of a whole record.
std::unique_ptr<RecordType> parse_schema(std::string_view text);

}  // namespace lss::cli::recording
