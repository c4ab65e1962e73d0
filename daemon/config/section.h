#pragma once

// Strict reading of one TOML table: every value has a type and a range, every key that was not read
// is an error with file and line, and a key with the wrong unit (`period_s` for `period_ms`) is
// reported as such. All errors of a file are reported together. Start-up only.

#include <toml++/toml.h>

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace lss::config {

// Collects "FILE:LINE:COLUMN: sentence" lines.
class Errors {
 public:
  void add(const std::string& file, const toml::source_region& where, const std::string& sentence);
  bool empty() const { return lines_.empty(); }
  std::string text() const;  // one line each, in the order of the file

 private:
  struct Line {
    toml::source_position where;
    std::string text;
  };
  std::vector<Line> lines_;
};

class Section {
 public:
  // `path` is the dotted name for messages, "" for the root. A missing table reads as empty; errors
  // about it are then reported at `where`, its parent.
  Section(const toml::table* table, std::string path, std::string file, Errors& errors,
          const toml::source_region& where = {});
  ~Section() { finish(); }
  Section(Section&& other) noexcept;
  Section(const Section&) = delete;
  Section& operator=(const Section&) = delete;
  Section& operator=(Section&&) = delete;

  // Value, or the fallback when the key is absent. Out of range, wrong type, NaN: an error and the
  // fallback.
  double number(std::string_view key, double fallback, double min, double max);
  std::int64_t integer(std::string_view key, std::int64_t fallback, std::int64_t min,
                       std::int64_t max);
  bool flag(std::string_view key, bool fallback);
  std::string text(std::string_view key, std::string_view fallback);
  std::string required_text(std::string_view key);
  // One of `choices`; returns its index.
  std::size_t choice(std::string_view key, std::size_t fallback,
                     const std::vector<std::string>& choices);
  std::vector<std::int64_t> integers(std::string_view key,
                                     const std::vector<std::int64_t>& fallback, std::size_t count,
                                     std::int64_t min, std::int64_t max);
  std::vector<double> numbers(std::string_view key, const std::vector<double>& fallback,
                              std::size_t count, double min, double max);
  std::vector<std::string> texts(std::string_view key, const std::vector<std::string>& fallback);
  Section section(std::string_view key);
  std::vector<Section> sections(std::string_view key);  // array of tables

  const std::string& file() const { return file_; }  // of the configuration

  // The key is allowed, with any value.
  void skip(std::string_view key) { find(key); }

  // For checks across keys: an error at the line of `key` (of the table when absent or "").
  void error(std::string_view key, const std::string& sentence);

  // Reports every key that was not read, with the nearest known name and, when only the unit
  // differs, the expected unit. Runs at the latest in the destructor; a second call does nothing.
  void finish();

 private:
  const toml::node* find(std::string_view key);
  std::string name_of(std::string_view key) const;
  void wrong_type(std::string_view key, const toml::node& node, const std::string& expected);
  void report_unknown(const toml::key& key, const toml::node& node);

  const toml::table* table_;
  std::string path_, file_;
  Errors& errors_;
  toml::source_region where_;
  std::vector<std::string> known_;
  bool finished_ = false;
};

// The candidate most similar to `word`; nullptr when none is near.
const std::string* nearest(std::string_view word, const std::vector<std::string>& candidates);

// "a, b, c"
std::string join(const std::vector<std::string>& words);

}  // namespace lss::config
