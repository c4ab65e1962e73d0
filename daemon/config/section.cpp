#include "daemon/config/section.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "daemon/config/document.h"
#include "idl/edit_distance.h"

namespace lss::config {
namespace {

// Longest first: "_mm_s" also ends in "_s".
constexpr std::array kUnits = {"_mm_s", "_rad_s", "_deg_s", "_m_s", "_degC", "_rad", "_deg", "_kHz",
                               "_Hz",   "_mm",    "_cm",    "_ms",  "_us",   "_ns",  "_mA",  "_mV",
                               "_m",    "_s",     "_A",     "_V",   "_W",    "_K"};

struct UnitSplit {
  std::string_view base;
  std::string_view unit;  // "" or "ms", "deg_s", ...
};

UnitSplit split_unit(std::string_view key) {
  for (const std::string_view unit : kUnits) {
    if (key.size() > unit.size() && key.ends_with(unit)) {
      return {key.substr(0, key.size() - unit.size()), unit.substr(1)};
    }
  }
  return {key, {}};
}

std::string spoken(std::string_view unit) {
  std::string text(unit);
  std::replace(text.begin(), text.end(), '_', '/');
  return text;
}

const char* type_name(const toml::node& node) {
  switch (node.type()) {
    case toml::node_type::table: return "a table";
    case toml::node_type::array: return "an array";
    case toml::node_type::string: return "a text";
    case toml::node_type::integer: return "a whole number";
    case toml::node_type::floating_point: return "a number with a fraction";
    case toml::node_type::boolean: return "true or false";
    default: return "a date or time";
  }
}

}  // namespace

const std::string* nearest(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.size() > most::kGuess) return nullptr;
  const std::string* best = nullptr;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    const bool shortened = word.size() >= 3 && candidate.starts_with(word);
    const std::size_t d = shortened ? 1 : edit_distance(word, candidate);
    if (d < best_distance && d < candidate.size()) {
      best_distance = d;
      best = &candidate;
    }
  }
  return best;
}

std::string join(const std::vector<std::string>& words) {
  return fmt::format("{}", fmt::join(words, ", "));
}

void Errors::add(const std::string& file, const toml::source_region& where,
                 const std::string& sentence) {
  // The parser gives an empty document no position; its errors belong to the first line.
  const toml::source_position at = where.begin ? where.begin : toml::source_position{1, 1};
  lines_.push_back({at, fmt::format("{}:{}:{}: {}", file, at.line, at.column, one_line(sentence))});
}

std::string Errors::text() const {
  std::vector<Line> sorted = lines_;
  std::stable_sort(sorted.begin(), sorted.end(),
                   [](const Line& a, const Line& b) { return a.where < b.where; });
  std::string all;
  for (const Line& line : sorted) all += line.text + '\n';
  return all;
}

Section::Section(const toml::table* table, std::string path, std::string file, Errors& errors,
                 const toml::source_region& where)
    : table_(table),
      path_(std::move(path)),
      file_(std::move(file)),
      errors_(errors),
      where_(table != nullptr ? table->source() : where) {}

Section::Section(Section&& other) noexcept
    : table_(std::exchange(other.table_, nullptr)),
      path_(std::move(other.path_)),
      file_(std::move(other.file_)),
      errors_(other.errors_),
      where_(std::move(other.where_)),
      known_(std::move(other.known_)),
      finished_(std::exchange(other.finished_, true)) {}

const toml::node* Section::find(std::string_view key) {
  if (std::find(known_.begin(), known_.end(), key) == known_.end()) known_.emplace_back(key);
  return table_ == nullptr ? nullptr : table_->get(key);
}

std::string Section::name_of(std::string_view key) const {
  if (path_.empty() || key.empty()) return path_ + std::string(key);
  return fmt::format("{}.{}", path_, key);
}

void Section::error(std::string_view key, const std::string& sentence) {
  const toml::node* node = table_ == nullptr ? nullptr : table_->get(key);
  errors_.add(file_, node != nullptr ? node->source() : where_,
              fmt::format("{}: {}", name_of(key), sentence));
}

void Section::wrong_type(std::string_view key, const toml::node& node,
                         const std::string& expected) {
  error(key, fmt::format("is {}; {} is expected", type_name(node), expected));
}

double Section::number(std::string_view key, double fallback, double min, double max) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  if (!node->is_number()) {
    wrong_type(key, *node, "a number");
    return fallback;
  }
  const double value = node->value<double>().value_or(std::nan(""));
  if (!std::isfinite(value)) {
    error(key, "is not a finite number");
  } else if (value < min || value > max) {
    error(key, fmt::format("{} is out of range {} to {}", value, min, max));
  } else {
    return value;
  }
  return fallback;
}

std::int64_t Section::integer(std::string_view key, std::int64_t fallback, std::int64_t min,
                              std::int64_t max) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  if (!node->is_integer()) {
    wrong_type(key, *node, "a whole number");
    return fallback;
  }
  const std::int64_t value = node->as_integer()->get();
  if (value >= min && value <= max) return value;
  error(key, fmt::format("{} is out of range {} to {}", value, min, max));
  return fallback;
}

bool Section::flag(std::string_view key, bool fallback) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  if (node->is_boolean()) return node->as_boolean()->get();
  wrong_type(key, *node, "true or false");
  return fallback;
}

std::string Section::text(std::string_view key, std::string_view fallback) {
  const toml::node* node = find(key);
  if (node == nullptr) return std::string(fallback);
  if (!node->is_string()) {
    wrong_type(key, *node, "a text in quotes");
  } else if (const std::string& value = node->as_string()->get(); value.size() <= most::kText) {
    return value;
  } else {
    error(key, fmt::format("has {} characters; at most {} are read", value.size(), most::kText));
  }
  return std::string(fallback);
}

std::string Section::required_text(std::string_view key) {
  if (find(key) == nullptr) error(key, "is missing; it has no default");
  return text(key, "");
}

std::size_t Section::choice(std::string_view key, std::size_t fallback,
                            const std::vector<std::string>& choices) {
  const std::string value = text(key, choices.at(fallback));
  const auto found = std::find(choices.begin(), choices.end(), value);
  if (found != choices.end()) return static_cast<std::size_t>(found - choices.begin());
  const std::string* meant = nearest(value, choices);
  error(key, meant != nullptr
                 ? fmt::format("\"{}\" is no choice; did you mean \"{}\"?", value, *meant)
                 : fmt::format("\"{}\" is no choice; choose one of: {}", value, join(choices)));
  return fallback;
}

std::vector<std::int64_t> Section::integers(std::string_view key,
                                            const std::vector<std::int64_t>& fallback,
                                            std::size_t count, std::int64_t min, std::int64_t max) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != count || !array->is_homogeneous<std::int64_t>()) {
    error(key, fmt::format("must be a list of {} whole numbers", count));
    return fallback;
  }
  std::vector<std::int64_t> values;
  for (const toml::node& element : *array) {
    values.push_back(element.as_integer()->get());
    if (values.back() < min || values.back() > max) {
      error(key, fmt::format("{} is out of range {} to {}", values.back(), min, max));
      return fallback;
    }
  }
  return values;
}

std::vector<double> Section::numbers(std::string_view key, const std::vector<double>& fallback,
                                     std::size_t count, double min, double max) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  const toml::array* array = node->as_array();
  const auto is_number = [](const toml::node& element) { return element.is_number(); };
  if (array == nullptr || array->size() != count || !std::ranges::all_of(*array, is_number)) {
    error(key, fmt::format("must be a list of {} numbers", count));
    return fallback;
  }
  std::vector<double> values;
  for (const toml::node& element : *array) {
    values.push_back(element.value<double>().value_or(std::nan("")));
    if (values.back() >= min && values.back() <= max) continue;
    error(key, fmt::format("{} is out of range {} to {}", values.back(), min, max));
    return fallback;
  }
  return values;
}

std::vector<std::string> Section::texts(std::string_view key,
                                        const std::vector<std::string>& fallback) {
  const toml::node* node = find(key);
  if (node == nullptr) return fallback;
  const toml::array* array = node->as_array();
  if (array == nullptr || (!array->empty() && !array->is_homogeneous<std::string>())) {
    error(key, "must be a list of texts in quotes");
    return fallback;
  }
  std::vector<std::string> values;
  for (const toml::node& element : *array) values.push_back(element.as_string()->get());
  const auto is_long = [](const std::string& value) { return value.size() > most::kText; };
  if (values.size() <= most::kTables && std::ranges::none_of(values, is_long)) return values;
  error(key, fmt::format("has more than {} texts, or one of more than {} characters", most::kTables,
                         most::kText));
  return fallback;
}

Section Section::section(std::string_view key) {
  const toml::node* node = find(key);
  if (node != nullptr && !node->is_table()) {
    wrong_type(key, *node, fmt::format("a table, [{}],", name_of(key)));
    node = nullptr;
  }
  return {node == nullptr ? nullptr : node->as_table(), name_of(key), file_, errors_, where_};
}

std::vector<Section> Section::sections(std::string_view key) {
  std::vector<Section> all;
  const toml::node* node = find(key);
  if (node == nullptr) return all;
  const toml::array* array = node->as_array();
  if (array == nullptr || !array->is_homogeneous<toml::table>()) {
    wrong_type(key, *node, fmt::format("a list of tables, [[{}]],", name_of(key)));
    return all;
  }
  if (array->size() > most::kTables) {
    error(key, fmt::format("has {} tables; at most {} are read", array->size(), most::kTables));
    return all;
  }
  all.reserve(array->size());
  for (const toml::node& element : *array) {
    all.emplace_back(element.as_table(), name_of(key), file_, errors_);
  }
  return all;
}

void Section::report_unknown(const toml::key& key, const toml::node& node) {
  const std::string_view word = key.str().substr(0, most::kText);
  const char* kind = node.is_table() || node.is_array_of_tables() ? "table" : "key";
  const std::string place = path_.empty() ? "" : fmt::format(" in [{}]", path_);
  const auto add = [&](const std::string& advice) {
    errors_.add(file_, key.source(), fmt::format("unknown {} {}{}; {}", kind, word, place, advice));
  };
  for (const std::string& known : known_) {
    const UnitSplit expected = split_unit(known);
    if (split_unit(word).base != expected.base) continue;
    return add(expected.unit.empty() ? fmt::format("{} has no unit here: {}", expected.base, known)
                                     : fmt::format("unit of {} is {} here: {}", expected.base,
                                                   spoken(expected.unit), known));
  }
  if (const std::string* meant = nearest(word, known_)) {
    return add(fmt::format("did you mean {}?", *meant));
  }
  add(known_.empty() ? "nothing is known here" : "known here: " + join(known_));
}

void Section::finish() {
  if (std::exchange(finished_, true) || table_ == nullptr) return;
  for (const auto& [key, node] : *table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) == known_.end()) {
      report_unknown(key, node);
    }
  }
}

}  // namespace lss::config
