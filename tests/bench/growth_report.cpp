#include <fmt/format.h>

#include "tests/bench/growth.h"
#include "tools/lss-cli/report/page.h"

namespace lss::bench {
namespace {

std::string number(double value) {
  if (!std::isfinite(value)) return "-";
  return std::abs(value) >= 100 ? fmt::format("{:.0f}", value) : fmt::format("{:.3g}", value);
}

const char* word(Met met) {
  constexpr const char* kWords[] = {"no", "yes", "undecided"};
  return kWords[static_cast<int>(met)];
}

// A line of a block of code; the last column is at its end.
template <class Values, class Cell>
std::string row(const std::string& name, const Values& values, Cell cell) {
  std::string line;
  for (const auto& value : values) line += fmt::format("{:>10}", cell(value));
  return fmt::format("    {:<46}{:>{}}\n", name, line, 70);
}

}  // namespace

std::string table(const std::vector<Growth>& all) {
  std::string text;
  for (const Growth& growth : all) {
    text += fmt::format("{}: {}, {}, by {}\n", growth.name, growth.cost, growth.unit, growth.what);
    for (const Point& point : growth.points)
      text += fmt::format("  {:>5} {:>9}\n", point.count, number(median(point.cost)));
    for (const Step& step : steps(growth))
      text += fmt::format(
          "  {:>5} to {:>4}: each more {} ({} to {}), {:.2f} of proportional: at most linear {}\n",
          step.from, step.to, number(step.each_more), number(step.least_more),
          number(step.most_more), step.of_proportional, word(step.met));
    if (!growth.note.empty()) text += "  " + growth.note + '\n';
  }
  return text;
}

std::string markdown(const std::vector<Growth>& all, const Machine& machine,
                     const std::string& command, const std::string& pictures) {
  std::string text = fmt::format(
      "# How cost grows\n\n"
      "For reviewers: what twice as much of something costs. Made by `{}`; do not edit. Method: "
      "[growth.cpp](../tests/bench/growth.cpp).\n\n"
      "- cost: median of the rounds; lowest and highest in the pictures\n"
      "- each more: what one more costs, between this count and the one before\n"
      "- linear: one more costs no more than in the step before, and the cost grows no more than "
      "the count; undecided when rounds differ by more than that\n\n"
      "{}, {} x {}, kernel {}, {}, load average at the start {}.\n\n",
      command, machine.date, machine.cpus, machine.cpu, machine.kernel, machine.preemption,
      machine.load);
  const auto open = [&] {
    std::string list;
    for (const Growth& growth : all) {
      for (const Step& step : steps(growth)) {
        if (step.met == Met::no)
          list += fmt::format("- {}: {} to {} {}\n", growth.cost, step.from, step.to, growth.what);
      }
    }
    return list;
  };
  const std::string worse = open();
  text += "Steps that are worse than linear:" + (worse.empty() ? " none.\n\n" : "\n\n" + worse) +
          (worse.empty() ? "" : "\n");
  for (const Growth& growth : all) {
    text += fmt::format("## {}, {}\n\n", growth.cost, growth.unit);
    if (!growth.note.empty()) text += growth.note + ".\n\n";
    if (growth.points.empty()) continue;
    text += fmt::format("![{} by {}]({}/growth-{}.svg)\n\n", growth.cost, growth.what, pictures,
                        growth.name);
    const std::vector<Step> all_steps = steps(growth);
    text += row(growth.what, growth.points, [](const Point& point) { return number(point.count); });
    text +=
        row("cost", growth.points, [](const Point& point) { return number(median(point.cost)); });
    text += row("each more", all_steps, [](const Step& step) { return number(step.each_more); });
    text += row("linear", all_steps, [](const Step& step) { return word(step.met); });
    text += '\n';
  }
  text.pop_back();
  return text;
}

std::string picture(const Growth& growth) {
  using namespace cli::report;
  Line measured, lowest, highest, linear;
  measured.name = "median";
  lowest.name = "lowest and highest round";
  linear.name = "linear from the first two";
  lowest.colour = highest.colour = 1;
  linear.colour = 2;
  lowest.dashed = highest.dashed = linear.dashed = true;
  for (const Point& point : growth.points) {
    for (Line* line : {&measured, &lowest, &highest, &linear}) line->x.push_back(point.count);
    measured.y.push_back(median(point.cost));
    lowest.y.push_back(quantile(point.cost, 0));
    highest.y.push_back(quantile(point.cost, 1));
    const double more = growth.points.size() < 2 ? 0 : steps(growth).front().each_more;
    linear.y.push_back(measured.y.front() + more * (point.count - measured.x.front()));
  }
  LineChart chart;
  chart.title = growth.cost + ", " + growth.unit;
  chart.x_label = growth.what;
  chart.y_label = growth.unit;
  chart.lines = {measured, lowest, highest, linear};
  return cli::report::picture(growth.cost, {chart});
}

}  // namespace lss::bench
