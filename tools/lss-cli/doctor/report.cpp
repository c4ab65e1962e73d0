#include "tools/lss-cli/doctor/report.h"

#include <fmt/format.h>

#include <algorithm>

namespace lss::cli::doctor {
namespace {

constexpr std::size_t kResultWidth = 7, kNarrowest = 30;

std::size_t count(const Findings& findings, Result result) {
  return static_cast<std::size_t>(std::ranges::count(findings, result, &Finding::result));
}

std::string painted(Result result, const Style& style) {
  const std::string name = fmt::format("{:<{}}", result_name(result), kResultWidth);
  switch (result) {
    case Result::good: return style.good(name);
    case Result::warning: return style.warning(name);
    case Result::problem: return style.bad(name);
    case Result::note: break;
  }
  return style.dim(name);
}

// Lines of at most `width`, broken at blanks.
std::vector<std::string> wrap(std::string_view text, std::size_t width) {
  std::vector<std::string> lines;
  while (text.size() > width) {
    std::size_t cut = text.rfind(' ', width);
    if (cut == std::string_view::npos || cut == 0) cut = text.find(' ', width);
    if (cut == std::string_view::npos) break;
    lines.emplace_back(text.substr(0, cut));
    text.remove_prefix(cut + 1);
  }
  lines.emplace_back(text);
  return lines;
}

std::string plural(std::size_t number, const char* word) {
  return fmt::format("{} {}{}", number == 0 ? "no" : std::to_string(number), word,
                     number == 1 ? "" : "s");
}

}  // namespace

const char* result_name(Result result) {
  static constexpr const char* kNames[] = {"good", "note", "warning", "problem"};
  return kNames[static_cast<unsigned>(result)];
}

bool has_problem(const Findings& findings) { return count(findings, Result::problem) > 0; }

std::string report_text(const Findings& findings, const Style& style, const Layout& layout) {
  std::size_t name_width = 0;
  for (const Finding& finding : findings) name_width = std::max(name_width, finding.name.size());
  const std::size_t indent = kResultWidth + 2 + name_width + 2;
  const std::size_t room = std::max(kNarrowest, layout.width - std::min(layout.width, indent));
  const std::string margin(indent, ' ');

  std::string text;
  for (const Finding& finding : findings) {
    text += fmt::format("{}  {:<{}}  ", painted(finding.result, style), finding.name, name_width);
    std::string_view before;  // the first line stands behind the name
    for (const std::string& line : wrap(finding.found, room)) {
      text += fmt::format("{}{}\n", before, line);
      before = margin;
    }
    if (finding.result != Result::good || layout.explain) {
      for (const std::string& line : wrap(finding.meaning, room))
        text += fmt::format("{}{}\n", margin, style.dim(line));
    }
    if (finding.remedy.empty()) continue;
    std::string_view arrow = "-> ";
    for (const std::string& line : wrap(finding.remedy, room - arrow.size())) {
      text += fmt::format("{}{}{}\n", margin, arrow, line);
      arrow = "   ";
    }
  }
  const std::string problems = plural(count(findings, Result::problem), "problem");
  return text + fmt::format("{}, {}, {}\n",
                            has_problem(findings) ? style.bad(problems) : style.good(problems),
                            plural(count(findings, Result::warning), "warning"),
                            plural(count(findings, Result::note), "note"));
}

nlohmann::json report_json(const Findings& findings) {
  nlohmann::json checks = nlohmann::json::array();
  for (const Finding& finding : findings) {
    checks.push_back({{"name", finding.name},
                      {"result", result_name(finding.result)},
                      {"found", finding.found},
                      {"meaning", finding.meaning},
                      {"remedy", finding.remedy}});
  }
  return {{"checks", std::move(checks)},
          {"problems", count(findings, Result::problem)},
          {"warnings", count(findings, Result::warning)}};
}

}  // namespace lss::cli::doctor
