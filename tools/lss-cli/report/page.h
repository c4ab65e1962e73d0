#pragma once

// One self-contained HTML page: sections of figures and tables, light or dark like the reader's
// system, in one column on a phone. Takes plain text and escapes it. Pure.

#include <string>
#include <vector>

#include "tools/lss-cli/report/chart.h"

namespace lss::cli::report {

struct Cells {
  std::vector<std::string> cells;
  std::string look;  // "bad", "warn" or empty
};

class Page {
 public:
  Page(const std::string& title, const std::string& subtitle);

  void section(const std::string& title, const std::string& explanation = "");
  template <class Chart>
  void add(const Chart& chart) {
    figure_html(figure(chart));
  }
  void table(const std::vector<std::string>& heads, const std::vector<Cells>& rows);
  void note(const std::string& text);

  std::string html() const;

 private:
  void figure_html(const std::string& html);
  void end_figures();

  std::string title_, body_;
  bool figures_ = false;
};

// Charts below one another with their legends, as one SVG file in light colours.
std::string picture(const std::string& title, const std::vector<LineChart>& charts);

}  // namespace lss::cli::report
