#pragma once

// The verbs, and the parser that turns a line into an action: the arguments of the program, or a
// line of `run` and `shell`. Also lists the possible next words, for completion. Main thread;
// contacts no daemon, except parse(Context&). Errors in a line are thrown: usage, or unknown_name
// with the nearest verb.

#include <CLI/CLI.hpp>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/session/context.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli {

using Action = std::function<ExitCode(Context&)>;

class Grammar {
 public:
  enum class Scope {
    program,   // with the options of all verbs
    sequence,  // a line of run or shell
  };
  // With the verbs of these vehicles, which must outlive it.
  explicit Grammar(Scope scope, std::span<const Vehicle* const> of = cli::vehicles());
  Grammar(const Grammar&) = delete;
  Grammar& operator=(const Grammar&) = delete;

  // For adding verbs. Examples are lines; the first may be empty.
  CLI::App& verb(const std::string& name, const std::string& summary,
                 std::string_view examples = "");
  // `check` throws an error in the words before any action.
  void on(CLI::App& verb, Action action, std::function<void()> check = {});
  // The possible values of an option ("--speed"), or bare words ("").
  void values(const CLI::App& verb, const std::string& option,
              const std::vector<std::string>& values);
  Scope scope() const { return scope_; }
  std::span<const Vehicle* const> vehicles() const { return vehicles_; }
  bool has(const std::string& verb) const { return values_.contains(verb); }

  // The words after the program's name. Help is an action too.
  Action parse(std::vector<std::string> words);
  const Options& options() const { return options_; }
  // After an error of parse(): a vehicle that is not on the roster may understand these words.
  bool may_be_of_another() const;

  // The possible replacements of the last word, which may be empty.
  std::vector<std::string> candidates(const std::vector<std::string>& words) const;

 private:
  void add_options();
  void check_options();
  std::vector<std::string> verb_names() const;
  Failure unknown(const std::vector<std::string>& words) const;

  Scope scope_;
  std::vector<const Vehicle*> vehicles_;
  CLI::App app_;
  Options options_;
  std::string timeout_, lease_;
  Action action_;
  bool misunderstood_ = false;  // words, not values of options
  std::map<std::string, std::map<std::string, std::vector<std::string>>> values_;
};

// Whose verbs are understood: those of the roster, or of the vehicle that its daemon describes.
std::vector<const Vehicle*> vehicles_of(Context& context);

// A line with the action that it is.
struct Parsed {
  std::unique_ptr<Grammar> grammar;  // owns the data of the action
  Action action;
};

// With the verbs of the vehicle on the line when this program was built without it; its daemon is
// asked only for words that are not understood without it.
Parsed parse(Context& context, Grammar::Scope scope, const std::vector<std::string>& words);

// An option that is a list, divided by commas.
void add_list(CLI::App& verb, const std::string& option, std::vector<std::string>& list,
              const std::string& help);
// Options --from and --to: times since the beginning of a file, in seconds.
void add_span(CLI::App& verb, recording::Filter& filter, const std::string& since);

// An option that is a time; in seconds, empty when it is not given.
std::shared_ptr<std::optional<double>> add_duration(CLI::App& verb, const std::string& option,
                                                    const std::string& help);

}  // namespace lss::cli
