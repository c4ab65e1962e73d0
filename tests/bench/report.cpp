#include "tests/bench/report.h"

#include <fmt/format.h>
#include <sys/utsname.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <thread>

#include "tests/bench/programs.h"
#include "tests/support/stamp.h"

namespace lss::bench {
namespace {

std::string number(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size >= 100) return fmt::format("{:.0f}", value);
  if (size >= 10) return fmt::format("{:.1f}", value);
  if (size == 0) return "0";
  return fmt::format("{:.3f}", value);
}

std::string goal(const Figure& f) {
  if (!std::isfinite(f.goal)) return "-";
  return "<= " + number(f.goal) + (f.absolute ? f.unit == "1" ? "" : " " + f.unit : "x");
}

std::string met(const Figure& f) {
  constexpr const char* kWords[] = {"no", "yes", "undecided"};
  const std::optional<Met> is = f.met();
  return is ? kWords[static_cast<int>(*is)] : "-";
}

using Cells = std::array<std::string, 9>;
const Cells kHead{"row", "figure", "unit", "value", "reference", "ratio", "A/A", "goal", "met"};

Cells cells(const Figure& f) {
  return {f.row,
          f.name,
          f.unit,
          number(f.value),
          number(f.reference),
          number(f.ratio),
          number(f.aa_ratio),
          goal(f),
          met(f)};
}

nlohmann::json finite(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

// Each note once; figures have its number.
std::vector<std::string> notes(const Figures& figures) {
  std::vector<std::string> list;
  for (const Figure& f : figures) {
    if (!f.remark().empty() && std::find(list.begin(), list.end(), f.remark()) == list.end())
      list.push_back(f.remark());
  }
  return list;
}

std::string first_line_after(const std::string& text, const std::string& key) {
  const std::size_t at = text.find(key);
  if (at == std::string::npos) return "unknown";
  const std::size_t from = text.find(':', at) + 2;
  return text.substr(from, text.find('\n', from) - from);
}

}  // namespace

std::string table(const Figures& figures) {
  std::vector<Cells> rows{kHead};
  for (const Figure& f : figures) rows.push_back(cells(f));
  std::array<std::size_t, std::tuple_size_v<Cells>> width{};
  for (const Cells& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) width[i] = std::max(width[i], row[i].size());
  }
  std::string text;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    std::string line;
    for (std::size_t i = 0; i < rows[r].size(); ++i) {
      const bool right = i >= 3 && i <= 6;
      line += right ? fmt::format("{:>{}}  ", rows[r][i], width[i])
                    : fmt::format("{:<{}}  ", rows[r][i], width[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + '\n';
    if (r > 0 && !figures[r - 1].remark().empty()) text += "     " + figures[r - 1].remark() + '\n';
  }
  return text;
}

std::string json(const Figures& figures) {
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Figure& f : figures) {
    const std::optional<Met> is = f.met();
    list.push_back({{"row", f.row},
                    {"figure", f.name},
                    {"unit", f.unit},
                    {"value", finite(f.value)},
                    {"reference", finite(f.reference)},
                    {"ratio", finite(f.ratio)},
                    {"aa_ratio", finite(f.aa_ratio)},
                    {"goal", finite(f.goal)},
                    {"met", is ? nlohmann::json(met(f)) : nlohmann::json(nullptr)},
                    {"note", f.remark()}});
  }
  return list.dump(2) + '\n';
}

Machine this_machine() {
  utsname system{};
  ::uname(&system);
  std::string governor = read_file("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor");
  governor.erase(std::remove(governor.begin(), governor.end(), '\n'), governor.end());
  const std::string load = read_file("/proc/loadavg");
  return {.cpu = first_line_after(read_file("/proc/cpuinfo"), "model name"),
          .kernel = system.release,
          .preemption = preemption(system.version),
          .governor = governor.empty() ? "none to be seen (as in a virtual machine)" : governor,
          .date = testing_support::stamp(std::filesystem::read_symlink("/proc/self/exe")),
          .load = load.substr(0, load.find(' ')),
          .cpus = std::thread::hardware_concurrency()};
}

std::string markdown(const Figures& figures, const Machine& machine, const std::string& command) {
  std::string text = fmt::format(
      "# Performance\n\n"
      "For reviewers: what costs how much, against a reference. Made by `{}`; do not edit. Method: "
      "[tests/bench](../tests/bench/), a file for each row.\n\n"
      "- ratio: median of at least five, against a reference of the same minutes and CPU\n"
      "- A/A: the reference against itself, the uncertainty of the ratio\n"
      "- goal: with yes (met), no, or undecided (nearer to the ratio than A/A is to 1)\n\n"
      "| machine | |\n|---|---|\n| date | {} |\n| CPU | {} x {} |\n| kernel | {}, {} |\n| governor "
      "| {} |\n"
      "| load average at the start | {} |\n\n",
      command, machine.date, machine.cpus, machine.cpu, machine.kernel, machine.preemption,
      machine.governor, machine.load);
  Figures shown;  // the others only explain these
  for (const Figure& f : figures) {
    if (f.failed || f.met() || !std::isfinite(f.value) || f.name.ends_with("p99") || f.in_document)
      shown.push_back(f);
  }
  const std::vector<std::string> remarks = notes(shown);
  const auto rows = [&](const char* title, bool open) {
    text += fmt::format(
        "## {}\n\n| figure | value | reference | ratio | A/A | goal "
        "|\n|---|---:|---:|---:|---:|---|\n",
        title);
    for (const Figure& f : shown) {
      if ((f.failed || f.met().value_or(Met::yes) != Met::yes) != open) continue;
      const auto note = std::find(remarks.begin(), remarks.end(), f.remark()) - remarks.begin() + 1;
      text += fmt::format("| {}, {}{}{} | {} | {} | {} | {} | {} |\n", f.row, f.name,
                          f.unit.empty() || f.unit == "1" ? "" : ", " + f.unit,
                          f.remark().empty() ? "" : fmt::format(" [{}]", note), number(f.value),
                          number(f.reference), number(f.ratio), number(f.aa_ratio),
                          f.met() ? goal(f) + ": " + met(f) : "-");
    }
    text += '\n';
  };
  rows("Goals that are not met, or undecided", true);
  rows("Goals that are met, and figures without a goal", false);
  text += "## Notes\n\n";
  for (std::size_t i = 0; i < remarks.size(); ++i)
    text += fmt::format("{}. {}\n", i + 1, remarks[i]);
  return text;
}

}  // namespace lss::bench
