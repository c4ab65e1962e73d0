#include "tools/lss-cli/verbs/steps.h"

#include <fmt/format.h>

#include <fstream>
#include <iostream>

namespace lss::cli {

namespace {

// Limits of the input: size of a file, and number of verbs, because each has a parser.
constexpr std::size_t kMostBytes = 1'000'000, kMostSteps = 1000;

}  // namespace

std::string read_input(const std::string& name) {
  std::ifstream file;
  if (name != "-") file.open(name);
  if (!file)
    throw Failure(ExitCode::usage, fmt::format("cannot read {}", name),
                  "name a file, or - for stdin");
  std::istream& in = name == "-" ? std::cin : file;
  std::string text(kMostBytes + 1, '\0');
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(in.gcount()));
  if (text.size() > kMostBytes)
    throw Failure(ExitCode::usage, fmt::format("{} is larger than {} bytes", name, kMostBytes),
                  "divide it into several");
  return text;
}

std::vector<Step> parse_steps(Context& context, std::string_view text, const std::string& name) {
  std::vector<Step> steps;
  for (const Line& line : parse_sequence(text, name)) {
    if (steps.size() == kMostSteps)
      throw Failure(ExitCode::usage, fmt::format("{} has more than {} verbs", name, kMostSteps),
                    "divide it into several");
    Step step{name.empty() ? "" : fmt::format("{}:{}: ", name, line.number), {}};
    try {
      step.parsed = parse(context, Grammar::Scope::sequence, line.words);
    } catch (const Failure& e) {
      throw Failure(e.code(), step.where + e.what(), e.advice());
    }
    steps.push_back(std::move(step));
  }
  return steps;
}

void run_step(Context& context, const Step& step) {
  ExitCode code = ExitCode::completed;
  try {
    if (context.was_interrupted()) throw Interrupted();  // of the step before it was the proper end
    code = step.parsed.action(context);
  } catch (const Failure& e) {
    throw Failure(e.code(), step.where + e.what(), e.advice());
  } catch (const Interrupted&) {
    stop_attached(context, "interrupted");
    throw Failure(ExitCode::failed, step.where + "interrupted");
  }
  if (code != ExitCode::completed) throw Failure(code, step.where + "ends here");
}

ExitCode run_steps(Context& context, const std::vector<Step>& steps, bool stay) {
  context.in_sequence = true;
  for (const Step& step : steps) {
    try {
      run_step(context, step);
    } catch (const Failure& e) {
      stop_attached(context, e.what());
      throw;
    }
  }
  if (!stay) stop_attached(context, "the sequence is done");
  return ExitCode::completed;
}

void stop_attached(Context& context, const std::string& why) {
  if (context.connected() && !context.options.detach) context.session().safe_stop(why);
}

}  // namespace lss::cli
