#pragma once

// Columns of a recorded topic as numbers over time, for plots and reports. Read once, kept in
// memory. One thread.

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/chart.h"

namespace lss::cli::report {

// Some columns of one topic. Times: publication, in s since the start of the recording.
class Table {
 public:
  // `columns` with `*`; columns that the topic lacks are left out. Empty without the topic.
  Table(const recording::Recording& recording, std::string_view topic,
        const std::vector<std::string>& columns, const recording::Filter& filter = {});

  const std::vector<double>& t_s() const { return t_s_; }
  bool empty() const { return t_s_.empty(); }
  std::size_t size() const { return t_s_.size(); }
  // As many as size(); NaN when there is none of that name.
  const std::vector<double>& operator[](const std::string& column) const;
  const std::vector<std::string>& names() const { return names_; }  // in the order of the type

 private:
  std::vector<double> t_s_, none_;
  std::vector<std::string> names_;
  std::map<std::string, std::vector<double>> values_;
};

// A column over time, times a factor.
Line line_of(const Table& table, const std::string& name, const std::string& column, int colour,
             bool dashed = false, double factor = 1);
// `unit`: the label of the other axis.
LineChart over_time(const std::string& title, const std::string& unit, std::vector<Line> lines = {},
                    const Range& range = {});

}  // namespace lss::cli::report
