#pragma once

// Lines of verbs for `run` and `shell`: line ends and ';' separate commands, blanks separate words,
// '...' and "..." keep blanks, # begins a comment. Pure functions.

#include <string>
#include <string_view>
#include <vector>

namespace lss::cli {

struct Line {
  int number = 0;  // in the file, from 1
  std::vector<std::string> words;
};

// Lines without words are left out. A quote that is not closed is a Failure with its line: "NAME:3:
// ...".
std::vector<Line> parse_sequence(std::string_view text, std::string_view name);

}  // namespace lss::cli
