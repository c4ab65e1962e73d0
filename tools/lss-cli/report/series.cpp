#include "tools/lss-cli/report/series.h"

#include <algorithm>

namespace lss::cli::report {
namespace {

struct Unit {
  std::string_view suffix, text;
};
// The longest first.
constexpr Unit kUnits[] = {
    {"_thruster_s", "thruster s"},
    {"_rad_s", "rad/s"},
    {"_m_s2", "m/s²"},
    {"_degC", "°C"},
    {"_rad", "rad"},
    {"_m_s", "m/s"},
    {"_rpm", "1/min"},
    {"_Nm", "N m"},
    {"_Pa", "Pa"},
    {"_ns", "ns"},
    {"_ms", "ms"},
    {"_m", "m"},
    {"_s", "s"},
    {"_A", "A"},
    {"_V", "V"},
    {"_N", "N"},
};

}  // namespace

Table::Table(const recording::Recording& recording, std::string_view topic,
             const std::vector<std::string>& columns, const recording::Filter& filter) {
  std::vector<const recording::Column*> wanted;
  std::vector<std::vector<double>> values;
  recording::Filter only = filter;
  for (const recording::Topic& known : recording.topics()) {
    if (known.layout == nullptr || !recording::names(topic, known.name)) continue;
    only.topics = {known.name};
    for (const recording::Column& column : known.layout->columns()) {
      if (std::ranges::any_of(columns, [&](const std::string& pattern) {
            return recording::matches(pattern, column.name);
          })) {
        wanted.push_back(&column);
      }
    }
    break;
  }
  if (only.topics.empty()) return;
  values.resize(wanted.size());
  recording.each(only, [&](const recording::Message& message) {
    t_s_.push_back(recording.seconds(message.publish_ns));
    for (std::size_t i = 0; i < wanted.size(); ++i)
      values[i].push_back(message.topic.layout->number(*wanted[i], message.data));
  });
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    names_.push_back(wanted[i]->name);
    values_[wanted[i]->name] = std::move(values[i]);
  }
}

const std::vector<double>& Table::operator[](const std::string& column) const {
  static const std::vector<double> kNone;
  const auto found = values_.find(column);
  return found == values_.end() ? kNone : found->second;
}

std::string unit_of(std::string_view column) {
  if (column.ends_with(']')) column = column.substr(0, column.rfind('['));
  for (const Unit& unit : kUnits) {
    if (column.ends_with(unit.suffix)) return std::string(unit.text);
  }
  return "";
}

}  // namespace lss::cli::report
