// lss-cli: the command line of the Locomotion Sub-System. See docs/cli.md.

#include <fmt/format.h>

#include <algorithm>
#include <clocale>
#include <string>
#include <vector>

#include "tools/lss-cli/verbs/grammar.h"

namespace {

using namespace lss::cli;

// For the scripts of `lss-cli completion`.
int complete(std::vector<std::string> words) {
  words.erase(words.begin());
  for (const std::string& word : Grammar(Grammar::Scope::program).candidates(words))
    fmt::print("{}\n", word);
  return 0;
}

ExitCode perform(Context& context, const Action& action) {
  std::optional<Failure> failure;
  ExitCode code = ExitCode::completed;
  try {
    code = action(context);
  } catch (const Failure& e) {
    failure = e;
  } catch (const Interrupted&) {
    failure = Failure(ExitCode::timed_out, "interrupted");
  } catch (const std::exception& e) {
    failure = Failure(ExitCode::internal, e.what());
  }
  if (failure) {
    code = failure->code();
    context.output.fail(*failure);
  }
  context.warn();
  context.output.finish(code, failure ? &*failure : nullptr, context.report());
  return code;
}

int run(const std::vector<std::string>& words) {
  Grammar grammar(Grammar::Scope::program);
  Action action;
  Options options;
  Parsed other;
  try {
    action = grammar.parse(words);
    options = grammar.options();
  } catch (const Failure& e) {
    options = grammar.options();
    options.json = std::ranges::count(words, "--json") > 0;
    action = [&, e](Context& context) {
      if (!grammar.may_be_of_another()) throw e;
      other = parse(context, Grammar::Scope::program, words);
      return other.action(context);
    };
  }
  Context context(options);
  return static_cast<int>(perform(context, action));
}

}  // namespace

int main(int argc, char** argv) {
  std::setlocale(LC_CTYPE, "");
  const std::vector<std::string> words(argv + 1, argv + argc);
  if (!words.empty() && words.front() == "__complete") return complete(words);
  return run(words);
}
