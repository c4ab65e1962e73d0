#include "tools/lss-cli/verbs/sequence.h"

#include <fmt/format.h>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

class Splitter {
 public:
  explicit Splitter(std::string_view name) : name_(name) {}

  void take(char c) {
    if (comment_ && c != '\n') return;
    if (quote_ != '\0' && c != '\n') {
      c == quote_ ? void(quote_ = '\0') : word_.push_back(c);
    } else if (c == '\'' || c == '"') {
      quote_ = c;
      in_word_ = true;
    } else if (c == '\n' || c == ';') {
      end_line();
      if (c == '\n') ++number_;
    } else if (c == ' ' || c == '\t' || c == '\r') {
      end_word();
    } else if (c == '#' && !in_word_) {
      comment_ = true;
    } else {
      word_.push_back(c);
      in_word_ = true;
    }
  }

  std::vector<Line> finish() {
    end_line();
    return std::move(lines_);
  }

 private:
  void end_word() {
    if (in_word_) words_.push_back(std::move(word_));
    word_.clear();
    in_word_ = false;
  }
  void end_line() {
    if (quote_ != '\0') {
      throw Failure(ExitCode::usage,
                    fmt::format("{}:{}: the quote {} is not closed", name_, number_, quote_));
    }
    end_word();
    if (!words_.empty()) lines_.push_back({number_, std::move(words_)});
    words_.clear();
    comment_ = false;
  }

  std::string_view name_;
  int number_ = 1;
  char quote_ = '\0';
  bool comment_ = false, in_word_ = false;
  std::string word_;
  std::vector<std::string> words_;
  std::vector<Line> lines_;
};

}  // namespace

std::vector<Line> parse_sequence(std::string_view text, std::string_view name) {
  Splitter splitter(name);
  for (const char c : text) splitter.take(c);
  return splitter.finish();
}

}  // namespace lss::cli
