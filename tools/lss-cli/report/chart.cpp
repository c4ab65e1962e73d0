#include "tools/lss-cli/report/chart.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace lss::cli::report {
namespace {

// In the units of the picture; a page shows it 460 to 640 pixels wide.
constexpr double kTop = 22, kBottom = 40, kLeft = 56, kRight = 12;
constexpr double kPlotHeight = 170, kRowHeight = 22, kLetter = 6.5;
constexpr int kPixels = static_cast<int>(kWidth - kLeft - kRight);

struct Scale {
  double from = 0, to = 1, low = 0, high = 1;  // values, places
  double at(double value) const { return low + (value - from) / (to - from) * (high - low); }
};

// 1, 2 or 5 times a power of ten, so that there are about `wanted` of them.
double step_of(double span, int wanted) {
  const double raw = span / wanted;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

// The positions of grid lines. Computed by index: far from zero a step may be too small to add.
std::vector<double> ticks(const Scale& scale, double step) {
  constexpr int kMost = 50;
  std::vector<double> places;
  const double first = std::ceil(scale.from / step - 1e-9);
  for (int i = 0; i < kMost && (first + i) * step <= scale.to + step * 1e-6; ++i)
    places.push_back((first + i) * step);
  return places;
}

std::string number(double value, double step) {
  const int decimals = std::max(0, static_cast<int>(std::ceil(-std::log10(step) - 1e-9)));
  if (std::abs(value) < step / 2) value = 0;
  return fmt::format("{:.{}f}", value, std::min(decimals, 6));
}

// A little wider than its data, and never empty.
Range widened(double low, double high) {
  if (!(low <= high)) return {0, 1};
  const double least = std::max(1e-6, 0.02 * std::max(std::abs(low), std::abs(high)));
  const double more = std::max(0.06 * (high - low), (high - low) < least ? least : 0.0);
  // A range that begins at zero keeps zero as its end.
  return {low >= 0 && low - more < 0 ? 0 : low - more,
          high <= 0 && high + more > 0 ? 0 : high + more};
}

std::string text_at(double x, double y, std::string_view anchor, std::string_view text,
                    std::string_view look = "") {
  return fmt::format(R"(<text x="{:.1f}" y="{:.1f}" text-anchor="{}" class="{}">{}</text>)", x, y,
                     anchor, look, escaped(text));
}

std::string x_axis(const Scale& scale, double bottom, std::string_view label) {
  std::string svg;
  const double step = step_of(scale.to - scale.from, 6);
  for (const double v : ticks(scale, step)) {
    svg += fmt::format(R"(<line class="grid" x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2:.1f}"/>)",
                       scale.at(v), kTop, bottom);
    svg += text_at(scale.at(v), bottom + 15, "middle", number(v, step));
  }
  return svg + text_at((scale.low + scale.high) / 2, bottom + 32, "middle", label, "label");
}

// In front of it are the numbers of the axis.
double left_of(const Scale& scale, int wanted) {
  constexpr double kDigit = 7.7;  // of a wide font
  double left = kLeft;
  const double step = step_of(scale.to - scale.from, wanted);
  for (const double v : ticks(scale, step))
    left = std::max(left, kDigit * static_cast<double>(number(v, step).size()) + 10);
  return std::min(left, kWidth / 3);
}

std::string y_axis(const Scale& scale, std::string_view label, int wanted, double left = kLeft) {
  std::string svg = text_at(4, 13, "start", label, "label");
  const double step = step_of(scale.to - scale.from, wanted);
  for (const double v : ticks(scale, step)) {
    svg += fmt::format(R"(<line class="grid" x1="{0:.1f}" x2="{1}" y1="{2:.1f}" y2="{2:.1f}"/>)",
                       left, kWidth - kRight, scale.at(v));
    svg += text_at(left - 6, scale.at(v) + 4, "end", number(v, step));
  }
  return svg;
}

// Lowest and highest of each pixel's width, where there are more points than pixels.
std::string points(const Line& line, const Scale& x, const Scale& y) {
  std::string path;
  bool pen = false;
  const auto put = [&](double px, double py) {
    path += fmt::format("{}{:.1f} {:.1f}", pen ? "L" : "M", px, py);
    pen = true;
  };
  const std::size_t size = std::min(line.x.size(), line.y.size());
  const bool many = size > 4u * kPixels;
  for (std::size_t i = 0; i < size; ++i) {
    if (!std::isfinite(line.y[i]) || line.x[i] < x.from || line.x[i] > x.to) {
      pen = pen && !std::isfinite(line.y[i]) ? false : pen;
      continue;
    }
    const double px = x.at(line.x[i]);
    if (!many) {
      put(px, y.at(line.y[i]));
      continue;
    }
    double low = line.y[i], high = low;
    const double first = low;
    while (i + 1 < size && std::isfinite(line.y[i + 1]) && x.at(line.x[i + 1]) < px + 0.5) {
      ++i;
      low = std::min(low, line.y[i]);
      high = std::max(high, line.y[i]);
    }
    put(px, y.at(first));
    if (low < first) put(px, y.at(low));
    if (high > first) put(px, y.at(high));
  }
  return path;
}

std::string begin(const std::string& title, double height) {
  return fmt::format(
      "<figure><figcaption>{0}</figcaption><div class=\"scroll\"><svg viewBox=\"0 0 {1} {2:.0f}\" "
      "role=\"img\" aria-label=\"{0}\">",
      escaped(title), kWidth, height);
}

std::string legend(const std::vector<Look>& looks) {
  if (looks.empty()) return "";
  std::string html = "<ul class=\"legend\">";
  for (const Look& look : looks)
    html += fmt::format("<li><i class=\"{}\"></i>{}</li>", look.look, escaped(look.meaning));
  return html + "</ul>";
}

// The same number of units for the same length on both axes.
void equalise(Scale& x, Scale& y) {
  const double unit =
      std::max((x.to - x.from) / (x.high - x.low), (y.to - y.from) / (y.low - y.high));
  const auto widen = [&](Scale& s) {
    const double middle = (s.from + s.to) / 2, half = unit * std::abs(s.high - s.low) / 2;
    s.from = middle - half;
    s.to = middle + half;
  };
  widen(x);
  widen(y);
}

Range range_of(const std::vector<Line>& lines, bool of_x, const Range& within) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const Line& line : lines) {
    const std::vector<double>& values = of_x ? line.x : line.y;
    for (std::size_t i = 0; i < values.size(); ++i) {
      if (!std::isfinite(values[i]) || i >= line.x.size()) continue;
      if (!of_x && std::isfinite(within.from) && (line.x[i] < within.from || line.x[i] > within.to))
        continue;
      low = std::min(low, values[i]);
      high = std::max(high, values[i]);
    }
  }
  return low <= high ? Range{low, high} : Range{0, 1};
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&': html += "&amp;"; break;
      case '<': html += "&lt;"; break;
      case '>': html += "&gt;"; break;
      case '"': html += "&quot;"; break;
      default: html += c;
    }
  }
  return html;
}

Drawing drawing(const LineChart& chart) {
  const double bottom = kTop + kPlotHeight;
  Range xs = chart.x;
  if (!std::isfinite(xs.from)) xs = range_of(chart.lines, true, {});
  if (xs.to - xs.from < 1e-9) xs.to = xs.from + 1;
  const Range seen = range_of(chart.lines, false, chart.equal ? Range{} : chart.x);
  const Range ys = widened(seen.from, seen.to);
  constexpr int kTicks = 4;
  Scale y{ys.from, ys.to, bottom, kTop};
  Scale x{xs.from, xs.to, left_of(y, kTicks), kWidth - kRight};
  if (chart.equal) equalise(x, y);
  Drawing result{y_axis(y, chart.y_label, kTicks, x.low) + x_axis(x, bottom, chart.x_label),
                 bottom + kBottom,
                 {}};
  for (const Line& line : chart.lines) {
    const std::string look =
        fmt::format("c{}{}", line.colour % kColours, line.dashed ? " dashed" : "");
    result.svg += fmt::format(R"(<path class="line {}" d="{}"/>)", look, points(line, x, y));
    result.legend.push_back({look, line.name});
  }
  return result;
}

std::string figure(const LineChart& chart) {
  const Drawing drawn = drawing(chart);
  return begin(chart.title, drawn.height) + drawn.svg + "</svg></div>" + legend(drawn.legend) +
         "</figure>";
}

std::string figure(const RowChart& chart) {
  const double bottom = kTop + kRowHeight * static_cast<double>(chart.rows.size());
  Range xs = chart.x;
  if (!std::isfinite(xs.from)) {
    for (const Row& row : chart.rows) {
      for (const Bar& bar : row.bars) {
        xs.from = std::isfinite(xs.from) ? std::min(xs.from, bar.from) : bar.from;
        xs.to = std::isfinite(xs.to) ? std::max(xs.to, bar.to) : bar.to;
      }
    }
  }
  if (!std::isfinite(xs.from)) xs = {0, 1};
  if (xs.to - xs.from < 1e-9) xs.to = xs.from + 1;
  // The full names of rows are in front of them.
  double left = kLeft;
  for (const Row& row : chart.rows)
    left = std::max(left, kLetter * static_cast<double>(row.label.size()) + 12);
  const Scale x{xs.from, xs.to, left, kWidth - kRight};
  std::string html = begin(chart.title, bottom + kBottom) + x_axis(x, bottom, chart.x_label);
  double top = kTop;
  for (const Row& row : chart.rows) {
    html += text_at(left - 6, top + kRowHeight / 2 + 4, "end", row.label);
    for (const Bar& bar : row.bars) {
      const double from = std::max(bar.from, xs.from), to = std::min(bar.to, xs.to);
      if (from >= to) continue;
      html += fmt::format(
          R"(<rect class="{}" x="{:.2f}" y="{:.1f}" width="{:.2f}" height="{:.1f}"><title>{}</title></rect>)",
          bar.look, x.at(from), top + 3, std::max(0.6, x.at(to) - x.at(from)), kRowHeight - 6,
          escaped(bar.tip));
    }
    top += kRowHeight;
  }
  return html + "</svg></div>" + legend(chart.legend) + "</figure>";
}

std::string figure(const Histogram& chart) {
  const double bottom = kTop + kPlotHeight * 0.7;
  std::size_t first = 0, last = chart.shares.size();
  while (first < last && chart.shares[first] <= 0) ++first;
  while (last > first && chart.shares[last - 1] <= 0) --last;
  std::string html = begin(chart.title, bottom + kBottom);
  if (first == last) return html + "</svg></div></figure>";
  // Whole decades.
  const double from = std::floor(std::log10(std::max(chart.edges[first], 0.1)));
  const double to = std::max(from + 1, std::ceil(std::log10(chart.edges[last])));
  const Scale x{from, to, kLeft, kWidth - kRight};
  const double most = *std::ranges::max_element(chart.shares);
  const Scale y{0, most * 108, bottom, kTop};
  html += y_axis(y, "% of the frames", 3);
  for (double decade = from; decade <= to; ++decade) {
    html += fmt::format(R"(<line class="grid" x1="{0:.1f}" x2="{0:.1f}" y1="{1}" y2="{2:.1f}"/>)",
                        x.at(decade), kTop, bottom);
    html += text_at(x.at(decade), bottom + 15, "middle", fmt::format("{:g}", std::pow(10, decade)));
  }
  html += text_at((kLeft + kWidth - kRight) / 2, bottom + 32, "middle", chart.x_label, "label");
  for (std::size_t i = first; i < last; ++i) {
    if (chart.shares[i] <= 0) continue;
    const double left = x.at(std::max(from, std::log10(std::max(chart.edges[i], 1e-3))));
    const double right = x.at(std::log10(chart.edges[i + 1]));
    const double height =
        std::max(1.0, bottom - y.at(chart.shares[i] * 100));  // a count of one is visible, too
    html += fmt::format(
        R"(<rect class="c0" x="{:.1f}" y="{:.1f}" width="{:.1f}" height="{:.1f}"><title>{:.3g} to {:.3g}: {:.3g} %</title></rect>)",
        left, bottom - height, std::max(0.8, right - left - 0.6), height, chart.edges[i],
        chart.edges[i + 1], chart.shares[i] * 100);
  }
  return html + "</svg></div></figure>";
}

std::vector<Bar> bars_of(const std::vector<double>& t_s, const std::vector<double>& values,
                         const std::vector<Look>& looks) {
  std::vector<Bar> bars;
  const std::size_t size = std::min(t_s.size(), values.size());
  for (std::size_t i = 0; i < size;) {
    std::size_t end = i + 1;
    while (end < size && values[end] == values[i]) ++end;
    const bool known = values[i] >= 0 && values[i] < static_cast<double>(looks.size());
    const std::size_t index = known ? static_cast<std::size_t>(values[i]) : 0;
    if (known && !looks[index].look.empty()) {
      const double to = end < size ? t_s[end] : t_s[size - 1];
      bars.push_back({t_s[i], to, looks[index].look,
                      fmt::format("{} {:.2f} to {:.2f} s", looks[index].meaning, t_s[i], to)});
    }
    i = end;
  }
  return bars;
}

}  // namespace lss::cli::report
