#pragma once

// Charts as SVG within a page or a picture. Colours come from its style sheet (page.cpp). Pure
// functions.

#include <limits>
#include <string>
#include <string_view>
#include <vector>

namespace lss::cli::report {

inline constexpr double kUnset = std::numeric_limits<double>::quiet_NaN();
inline constexpr int kColours = 8;

// The time range of a chart.
struct Range {
  double from = kUnset, to = kUnset;
};

struct Line {
  std::string name;
  std::vector<double> x, y;  // NaN interrupts the line
  int colour = 0;            // 0..7
  bool dashed = false;
};

struct LineChart {
  std::string title, x_label, y_label;
  std::vector<Line> lines;
  Range x;
  bool equal = false;  // a map: one scale for both
};

// Start, end, and look: "c0".."c7" a colour of lines, "good", "warn", "bad", "idle".
struct Bar {
  double from = 0, to = 0;
  std::string look, tip;
};

struct Row {
  std::string label;
  std::vector<Bar> bars;
};

struct Look {
  std::string look, meaning;
};

struct RowChart {
  std::string title, x_label;
  std::vector<Row> rows;
  Range x;
  std::vector<Look> legend;
};

// Shares over a logarithmic axis: bar i from edge i to edge i + 1.
struct Histogram {
  std::string title, x_label;
  std::vector<double> edges, shares;
};

// A chart without title: what is inside of an <svg> of kWidth and `height`, in units of the
// drawing.
inline constexpr double kWidth = 560;
struct Drawing {
  std::string svg;
  double height;
  std::vector<Look> legend;
};
Drawing drawing(const LineChart& chart);

// Each returns a <figure> with title and legend.
std::string figure(const LineChart& chart);
std::string figure(const RowChart& chart);
std::string figure(const Histogram& chart);

// For text within HTML.
std::string escaped(std::string_view text);

// Adjoining samples of the same value as one bar each; values without a look have none.
std::vector<Bar> bars_of(const std::vector<double>& t_s, const std::vector<double>& values,
                         const std::vector<Look>& looks);

}  // namespace lss::cli::report
