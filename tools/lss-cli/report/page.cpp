#include "tools/lss-cli/report/page.h"

#include <fmt/format.h>

namespace lss::cli::report {
namespace {

struct Colour {
  const char *name, *light, *dark;
};
constexpr Colour kColours[] = {
    {"paper", "#fcfcfb", "#161615"}, {"card", "#ffffff", "#1e1e1c"}, {"ink", "#1b1b19", "#f2f1ec"},
    {"soft", "#5c5b57", "#b4b2aa"},  {"grid", "#e4e3de", "#383733"}, {"c0", "#2a78d6", "#4d94e8"},
    {"c1", "#eb6834", "#f08355"},    {"c2", "#1baf7a", "#2fc48f"},   {"c3", "#c98a00", "#e0a92e"},
    {"c4", "#4a3aa7", "#9085e9"},    {"c5", "#d9363e", "#ee6a6a"},   {"c6", "#007a33", "#3fb56a"},
    {"c7", "#d6609a", "#e07fae"},    {"good", "#1baf7a", "#2fc48f"}, {"warn", "#eda100", "#e0a92e"},
    {"bad", "#d03b3b", "#ee6a6a"},   {"idle", "#d9d8d2", "#45443f"}};

constexpr const char* kChartStyle = R"css(
text{font:12px system-ui,sans-serif;fill:var(--soft)}text.label{fill:var(--ink)}
.grid{stroke:var(--grid);stroke-width:1}.line{fill:none;stroke-width:1.6;stroke-linejoin:round}
.dashed{stroke-dasharray:5 3}
)css";

constexpr const char* kStyle = R"css(
*{box-sizing:border-box}
body{margin:0 auto;max-width:82rem;padding:1rem;background:var(--paper);color:var(--ink);
font:15px/1.45 system-ui,sans-serif;overflow-wrap:anywhere}
h1{font-size:1.5rem;margin:.2rem 0}h2{font-size:1.15rem;margin:1.6rem 0 .3rem}
p{margin:.2rem 0 .6rem;color:var(--soft);max-width:60rem}
.figures{display:grid;gap:.8rem;grid-template-columns:repeat(auto-fill,minmax(min(100%,30rem),1fr))}
figure{margin:0;padding:.7rem .8rem;background:var(--card);border:1px solid var(--grid);border-radius:6px;min-width:0}
figcaption{font-weight:600;margin-bottom:.2rem}
.scroll{overflow-x:auto}svg{display:block;width:100%;min-width:460px;max-width:720px;height:auto}
.legend{list-style:none;display:flex;flex-wrap:wrap;gap:.15rem .9rem;margin:.3rem 0 0;padding:0;font-size:.85rem}
.legend i{display:inline-block;width:1em;height:.7em;border-radius:2px;margin-right:.35em}
.legend i.dashed{opacity:.55}
.table{overflow-x:auto}table{border-collapse:collapse;font-size:.88rem;width:100%}
th,td{text-align:left;padding:.2rem .7rem .2rem 0;border-bottom:1px solid var(--grid);vertical-align:top}
th{color:var(--soft);font-weight:500}td{font-variant-numeric:tabular-nums}
tr.bad td{color:var(--bad)}tr.warn td{color:var(--c3)}
)css";

// By name: lines are drawn, rectangles and legends are filled.
std::string looks() {
  std::string css;
  for (const Colour& colour : kColours) {
    css += fmt::format(
        "path.{0}{{stroke:var(--{0})}}rect.{0}{{fill:var(--{0})}}"
        "i.{0}{{background:var(--{0})}}\n",
        colour.name);
  }
  return css;
}

std::string variables(const char* Colour::*scheme) {
  std::string css;
  for (const Colour& colour : kColours) css += fmt::format("--{}:{};", colour.name, colour.*scheme);
  return ":root{" + css + "}";
}

// For programs that draw SVG but know no variables.
std::string in_light_colours(std::string css) {
  for (const Colour& colour : kColours) {
    const std::string variable = fmt::format("var(--{})", colour.name);
    for (std::size_t at = 0; (at = css.find(variable)) != std::string::npos;)
      css.replace(at, variable.size(), colour.light);
  }
  return css;
}

}  // namespace

Page::Page(const std::string& title, const std::string& subtitle) : title_(title) {
  body_ = fmt::format("<h1>{}</h1><p>{}</p>\n", escaped(title), escaped(subtitle));
}

void Page::end_figures() {
  if (figures_) body_ += "</div>\n";
  figures_ = false;
}

void Page::section(const std::string& title, const std::string& explanation) {
  end_figures();
  body_ += fmt::format("<h2>{}</h2>\n", escaped(title));
  if (!explanation.empty()) note(explanation);
}

void Page::note(const std::string& text) {
  end_figures();
  body_ += fmt::format("<p>{}</p>\n", escaped(text));
}

void Page::figure_html(const std::string& html) {
  if (!figures_) body_ += "<div class=\"figures\">\n";
  figures_ = true;
  body_ += html + "\n";
}

void Page::table(const std::vector<std::string>& heads, const std::vector<Cells>& rows) {
  end_figures();
  body_ += "<div class=\"table\"><table><tr>";
  for (const std::string& head : heads) body_ += "<th>" + escaped(head) + "</th>";
  body_ += "</tr>\n";
  for (const Cells& row : rows) {
    body_ += fmt::format("<tr class=\"{}\">", row.look);
    for (const std::string& cell : row.cells) body_ += "<td>" + escaped(cell) + "</td>";
    body_ += "</tr>\n";
  }
  body_ += "</table></div>\n";
}

std::string Page::html() const {
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width,initial-scale=1\">"
      "<title>{}</title><style>:root{{color-scheme:light dark}}{}\n"
      "@media(prefers-color-scheme:dark){{{}}}{}{}{}</style></head>\n<body>\n{}{}</body></html>\n",
      escaped(title_), variables(&Colour::light), variables(&Colour::dark), kStyle, kChartStyle,
      looks(), body_, figures_ ? "</div>\n" : "");
}

std::string picture(const std::string& title, const std::vector<LineChart>& charts) {
  constexpr double kLine = 17, kLeft = 12, kWidth_px = 960;
  const auto label = [](double x, double y, const std::string& text) {
    return fmt::format("<text class=\"label\" x=\"{}\" y=\"{}\">{}</text>\n", x, y, escaped(text));
  };
  double y = 1.5 * kLine;
  std::string body = label(kLeft, y, title);
  for (const LineChart& chart : charts) {
    const Drawing drawn = drawing(chart);
    body += fmt::format("<g transform=\"translate(0 {})\">{}</g>\n", y + kLine / 2, drawn.svg);
    y += drawn.height + 1.5 * kLine;
    for (const Look& look : drawn.legend) {
      body += fmt::format(R"(<rect class="{}" x="{}" y="{}" width="14" height="9"/>)", look.look,
                          kLeft, y - 9);
      body += label(kLeft + 20, y, look.meaning);
      y += kLine;
    }
  }
  return fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0} {1}\" width=\"{2}\" "
      "height=\"{3:.0f}\"><style>{4}</style><rect class=\"card\" width=\"{0}\" "
      "height=\"{1}\"/>\n{5}</svg>\n",
      kWidth, y, kWidth_px, y * kWidth_px / kWidth, in_light_colours(kChartStyle + looks()), body);
}

}  // namespace lss::cli::report
