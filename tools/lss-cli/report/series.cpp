#include "tools/lss-cli/report/series.h"

#include <algorithm>
#include <limits>

namespace lss::cli::report {

Table::Table(const recording::Recording& recording, std::string_view topic,
             const std::vector<std::string>& columns, const recording::Filter& filter) {
  std::vector<const recording::Column*> wanted;
  std::vector<std::vector<double>> values;
  recording::Filter only = filter;
  const recording::Topic* of = nullptr;  // another may have its name, and another type
  for (const recording::Topic& known : recording.topics()) {
    if (known.layout == nullptr || !recording::names(topic, known.name)) continue;
    only.topics = {known.name};
    of = &known;
    for (const recording::Column& column : known.layout->columns()) {
      if (std::ranges::any_of(columns, [&](const std::string& pattern) {
            return recording::matches(pattern, column.name);
          })) {
        wanted.push_back(&column);
      }
    }
    break;
  }
  if (of == nullptr) return;
  values.resize(wanted.size());
  recording.each(only, [&](const recording::Message& message) {
    if (&message.topic != of) return;
    t_s_.push_back(recording.seconds(message.publish_ns));
    for (std::size_t i = 0; i < wanted.size(); ++i)
      values[i].push_back(message.topic.layout->number(*wanted[i], message.data));
  });
  for (std::size_t i = 0; i < wanted.size(); ++i) {
    names_.push_back(wanted[i]->name);
    values_[wanted[i]->name] = std::move(values[i]);
  }
  none_.assign(t_s_.size(), std::numeric_limits<double>::quiet_NaN());
}

const std::vector<double>& Table::operator[](const std::string& column) const {
  const auto found = values_.find(column);
  return found == values_.end() ? none_ : found->second;
}

Line line_of(const Table& table, const std::string& name, const std::string& column, int colour,
             bool dashed, double factor) {
  Line line{name, table.t_s(), table[column], colour, dashed};
  for (double& value : line.y) value *= factor;
  return line;
}

LineChart over_time(const std::string& title, const std::string& unit, std::vector<Line> lines,
                    const Range& range) {
  return {title, "time in s", unit, std::move(lines), range};
}

}  // namespace lss::cli::report
