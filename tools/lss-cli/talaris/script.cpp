#include "tools/lss-cli/talaris/script.h"

#include <fmt/format.h>

#include <algorithm>

#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/sequence.h"

namespace lss::cli::talaris {
namespace {

using lss::talaris::StepKind;

constexpr const char* kForm =
    "a line is: TIME valves NUMBERS for TIME, TIME fans NUMBERS throttle SHARE, or TIME fans "
    "NUMBERS rpm SPEED";
constexpr std::uint64_t kAllValves = (1u << lss::talaris::kValveCount) - 1;
constexpr std::uint64_t kAllFans = (1u << lss::talaris::kFanCount) - 1;

double which(const std::string& word, std::uint64_t all, const char* what) {
  return word == "all" ? static_cast<double>(all) : parse_set(word, all, what);
}

ScriptStep read(const Line& line) {
  const std::vector<std::string>& words = line.words;
  if (words.size() != 5) throw Failure(ExitCode::usage, "there must be five words", kForm);
  ScriptStep step{.line = line.number, .at_s = parse_quantity(words[0], "s", "time")};
  const std::string &what = words[1], &how = words[3], &value = words[4];
  if (what == "valves" && how == "for") {
    step.kind = StepKind::pulse;
    step.which = which(words[2], kAllValves, "valves");
    step.value = parse_quantity(value, "s", "for");
  } else if (what == "fans" && (how == "throttle" || how == "rpm")) {
    step.kind = how == "rpm" ? StepKind::rpm : StepKind::throttle;
    step.which = which(words[2], kAllFans, "fans");
    step.value = parse_quantity(value, how == "rpm" ? "rpm" : "", how);
  } else {
    throw Failure(ExitCode::usage, fmt::format("do not know '{} ... {}'", what, how), kForm);
  }
  return step;
}

}  // namespace

std::vector<ScriptStep> parse_script(std::string_view text, const std::string& name) {
  std::vector<ScriptStep> steps;
  for (const Line& line : parse_sequence(text, name)) {
    try {
      steps.push_back(read(line));
      if (steps.size() > 1 && steps.back().at_s < steps[steps.size() - 2].at_s)
        throw Failure(ExitCode::usage, "goes back in time", "sort the lines by their times");
    } catch (const Failure& e) {
      throw Failure(e.code(), fmt::format("{}:{}: {}", name, line.number, e.what()), e.advice());
    }
  }
  if (steps.empty())
    throw Failure(ExitCode::usage, fmt::format("{} has no line to do", name), kForm);
  if (steps.size() > static_cast<std::size_t>(lss::talaris::kMaxScriptSteps)) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} has {} lines, the daemon takes {}", name, steps.size(),
                              lss::talaris::kMaxScriptSteps),
                  "divide it into several");
  }
  return steps;
}

double duration_s(const std::vector<ScriptStep>& script) {
  double end_s = 0;
  for (const ScriptStep& step : script)
    end_s = std::max(end_s, step.at_s + (step.kind == StepKind::pulse ? step.value : 0));
  return lss::talaris::kScriptLead_s + end_s;
}

}  // namespace lss::cli::talaris
