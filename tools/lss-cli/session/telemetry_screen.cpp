#include "tools/lss-cli/session/telemetry_screen.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "idl/units.h"
#include "tools/lss-cli/session/telemetry.h"

namespace lss::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWidth = 110;  // of a table with a row for each element
constexpr std::size_t kColumns = 8;  // of one with a column for each element
constexpr const char* kHidden[] = {"time_ns", "frame", "state", "mode"};  // lss/status says them

std::string show(const Json& value, const Unit& unit) {
  if (value.is_null()) return "-";
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_structured()) {
    std::string list;
    for (const Json& part : value) list += (list.empty() ? "" : ", ") + show(part, unit);
    return list;
  }
  if (!value.is_number_float() && unit.factor == 1) return value.dump();
  const double number = value.get<double>() * unit.factor;
  return std::isfinite(number) ? fmt::format("{:.4g}", number) : "-";
}

std::string row(const std::string& name, const Json& value, const Style& style) {
  const Unit unit = unit_in(name);
  return fmt::format("{} {:>12} {}\n", style.dim(fmt::format("{:<26}", without_unit(name))),
                     show(value, unit), unit.shown);
}

// An array of structs as texts.
struct Table {
  struct Column {
    std::string name, unit;
    std::vector<std::string> cells;
    std::size_t width() const {
      std::size_t widest = std::max(name.size(), unit.size());
      for (const std::string& cell : cells) widest = std::max(widest, cell.size());
      return widest;
    }
  };
  std::vector<std::string> rows;  // names of the elements
  std::vector<Column> columns;

  std::size_t name_width(const std::string& title) const {
    std::size_t widest = title.size();
    for (const std::string& name : rows) widest = std::max(widest, name.size());
    return widest;
  }
};

Table table_of(const std::string& field, const Json& list, const Shown& shown, bool details) {
  Table table;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string name = shown.name_of(field, list[i]);
    table.rows.push_back(name.empty() ? fmt::format("{}", i + 1) : name);
  }
  for (const auto& [member, unused] : list.front().items()) {
    const std::string path = field + "." + member;
    if (member == "id" || member == "name" || shown.details.contains(path) != details) continue;
    const Unit unit = unit_in(member);
    Table::Column column{std::string(without_unit(member)), std::string(unit.shown), {}};
    const auto words = shown.words.find(path);
    for (const Json& element : list) {
      const Json& value = element.at(member);
      const bool named = words != shown.words.end() && value.is_number_unsigned() &&
                         value.get<std::size_t>() < words->second.words.size();
      column.cells.push_back(named ? words->second.words[value.get<std::size_t>()]
                                   : show(value, unit));
    }
    table.columns.push_back(std::move(column));
  }
  return table;
}

// A row for each element.
std::string upright(const std::string& field, const Table& table, const Style& style) {
  const std::size_t first = table.name_width(field);
  std::string names = fmt::format("{:<{}}", field, first), units = std::string(first, ' ');
  for (const Table::Column& column : table.columns) {
    names += fmt::format(" {:>{}}", column.name, column.width());
    units += fmt::format(" {:>{}}", column.unit, column.width());
  }
  std::string text = style.dim(names) + "\n";
  if (units.find_first_not_of(' ') != std::string::npos) text += style.dim(units) + "\n";
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    text += style.bold(fmt::format("{:<{}}", table.rows[i], first));
    for (const Table::Column& column : table.columns)
      text += fmt::format(" {:>{}}", column.cells[i], column.width());
    text += "\n";
  }
  return text;
}

// A line for each member; as many elements beside each other as a terminal shows.
std::string across(const std::string& field, const Table& table, const Style& style) {
  std::string text;
  for (std::size_t from = 0; from < table.rows.size(); from += kColumns) {
    const std::size_t end = std::min(table.rows.size(), from + kColumns);
    std::string heading = fmt::format("{:<24}", field);
    for (std::size_t i = from; i < end; ++i) heading += fmt::format(" {:>10}", table.rows[i]);
    text += style.bold(heading) + "\n";
    for (const Table::Column& column : table.columns) {
      text += style.dim(fmt::format("  {:<22}", column.name));
      for (std::size_t i = from; i < end; ++i) text += fmt::format(" {:>10}", column.cells[i]);
      text += fmt::format(" {}\n", column.unit);
    }
  }
  return text;
}

std::string table(const std::string& field, const Json& list, const Shown& shown, bool details,
                  const Style& style) {
  const Table table = table_of(field, list, shown, details);
  if (table.columns.empty()) return "";
  std::size_t width = table.name_width(field);
  for (const Table::Column& column : table.columns) width += 1 + column.width();
  return (width <= kWidth ? upright(field, table, style) : across(field, table, style)) + "\n";
}

void add_lines(std::string& text, const std::string& name, const Json& value, const Shown& shown,
               bool details, const Style& style) {
  if (value.is_object()) {
    for (const auto& [member, part] : value.items())
      add_lines(text, name.empty() ? member : name + "." + member, part, shown, details, style);
  } else if (value.is_array() && !value.empty() && value.front().is_object()) {
    const std::string list = table(name, value, shown, details, style);
    if (!list.empty() && !text.empty() && !text.ends_with("\n\n")) text += "\n";
    text += list;
  } else if (shown.details.contains(name) == details &&
             std::ranges::find(kHidden, name) == std::end(kHidden)) {
    text += row(name, value, style);
  }
}

}  // namespace

std::string Shown::name_of(std::string_view field, const Json& element) const {
  const std::uint16_t subject = subject_of(field, element);
  if (subject == 0) return "";
  return subject <= subjects.size() ? subjects[subject - 1u] : fmt::format("module {}", subject);
}

Json with_words(Json telemetry, const Shown& shown) {
  const auto replace = [](Json& value, const Shown::Words& words) {
    if (words.shown_only || !value.is_number_unsigned()) return;
    const auto number = value.get<std::size_t>();
    value = number < words.words.size() ? words.words[number] : "?";
  };
  for (const auto& [path, words] : shown.words) {
    const std::size_t dot = path.find('.');
    const auto field = telemetry.find(path.substr(0, dot));
    if (field == telemetry.end()) continue;
    if (dot == std::string::npos) {
      replace(*field, words);
    } else if (field->is_array()) {
      for (Json& element : *field) {
        if (const auto member = element.find(path.substr(dot + 1)); member != element.end())
          replace(*member, words);
      }
    }
  }
  telemetry = with_null_for_never(std::move(telemetry));
  for (const auto& [path, parts] : shown.parts) {
    const auto list = telemetry.find(path);
    if (list == telemetry.end() || !list->is_array()) continue;
    for (Json& element : *list) {
      if (std::string name = shown.name_of(path, element); !name.empty()) element["name"] = name;
      const auto age = element.find("age_ms");
      // It is not there: neither online nor silent.
      if (Shown::is_in(parts.optional, shown.subject_of(path, element)) && age != element.end() &&
          age->is_null() && element.contains("online"))
        element["online"] = nullptr;
    }
  }
  return telemetry;
}

std::string telemetry_screen(const Json& telemetry, const Shown& shown, const Style& style) {
  std::string text;
  add_lines(text, "", telemetry, shown, false, style);
  return text;
}

std::string telemetry_details(const Json& telemetry, const Shown& shown, const Style& style) {
  std::string text;
  if (!shown.details.empty()) add_lines(text, "", telemetry, shown, true, style);
  return text;
}

}  // namespace lss::cli
