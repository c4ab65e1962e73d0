#include "tools/lss-cli/verbs/grammar.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

constexpr const char* kFooter =
    "Exit codes: 0 completed, 1 internal, 2 usage, 3 daemon unreachable, 4 unknown name, 5 "
    "rejected,\n"
    "6 accepted, then failed, 7 timed out, outcome unknown, 8 not authorised.\n\n"
    "Examples:\n"
    "  lss-cli status\n"
    "  lss-cli walk forward --speed high --for 20s\n"
    "  lss-cli run -e 'start; stand; walk forward --for 10s; stop'\n"
    "  lss-cli command list             of the vehicle that answers, also one unknown here\n"
    "  lss-cli walk --help\n";

constexpr std::size_t kSourceLength = 31;  // of lss::Command in lss.idl

// A bare number is in milliseconds, as the lease is everywhere else.
std::uint32_t parse_lease_ms(const std::string& text) {
  const bool bare =
      !text.empty() && std::ranges::all_of(text, [](char c) { return c >= '0' && c <= '9'; });
  const double ms = parse_duration_s(bare ? text + "ms" : text, "--lease") * 1000;
  if (ms < 1 || ms > 3.6e6)
    throw Failure(ExitCode::usage, fmt::format("--lease: '{}' is out of range", text));
  return static_cast<std::uint32_t>(ms);
}

bool is_verb_like(const std::string& word) { return !word.starts_with('-'); }

std::string see_help(const std::vector<CLI::App*>& verbs) {
  return fmt::format("see: lss-cli{} --help", verbs.empty() ? "" : " " + verbs.front()->get_name());
}

// What the verb still needs: CLI11 names it without what it is.
std::string still_needed(const CLI::App& verb) {
  for (const CLI::Option* option : verb.get_options()) {
    if (!option->get_required() || option->count() > 0) continue;
    return fmt::format("{} needs {}: {}", verb.get_name(),
                       option->get_positional() ? "one more word" : option->get_name(),
                       option->get_description());
  }
  return "";
}

}  // namespace

Grammar::Grammar(Scope scope, std::span<const Vehicle* const> of)
    : scope_(scope),
      vehicles_(of.begin(), of.end()),
      app_("Commands and watches a vehicle's locomotion (lssd) over DDS.", "lss-cli") {
  app_.require_subcommand(0, 1);
  app_.fallthrough();
  app_.footer(kFooter);
  if (scope == Scope::program) add_options();
  add_verbs(*this);
}

void Grammar::add_options() {
  app_.add_option("--domain", options_.domain, "DDS domain")
      ->envname("LSS_DOMAIN")
      ->check(CLI::Range(0, 230));
  app_.add_option("--vehicle", options_.vehicle_id,
                  "vehicle_id; needed when several share the domain (Env:LSS_VEHICLE, which estop "
                  "does not look at)");
  app_.add_option("--source", options_.source,
                  "who commands (default lss-cli:PID, with --detach lss-cli)")
      ->envname("LSS_SOURCE");
  app_.add_option("--enclave", options_.enclave,
                  "folder with certificates and permissions, for DDS Security")
      ->envname("LSS_ENCLAVE");
  app_.add_option("--timeout", timeout_,
                  "longest wait, for the daemon (default 3s) and for a command (default 2min)");
  app_.add_option(
      "--lease", lease_,
      "without a heartbeat for so long the vehicle stops (default 2s; a bare number: ms)");
  app_.add_flag("--json", options_.json, "one JSON document on stdout");
  app_.add_flag("--jsonl", options_.jsonl, "a stream of JSON documents, one per line")
      ->excludes("--json");
  app_.add_flag("--dry-run", options_.dry_run,
                "ask whether a command would be accepted, do nothing");
  app_.add_flag("--detach", options_.detach,
                "return when accepted; then lss-cli heartbeat keeps the lease");
  app_.add_flag("--wait", options_.wait, "with --detach: return when completed");
  app_.add_flag("--shm", options_.shared_memory, "telemetry by shared memory");
  app_.add_flag("--no-color", options_.no_color, "no colours (also: NO_COLOR)");
  app_.set_version_flag("--version", version_text());
}

CLI::App& Grammar::verb(const std::string& name, const std::string& summary,
                        std::string_view examples) {
  CLI::App* sub = app_.add_subcommand(name, summary);
  if (examples.starts_with('\n')) examples.remove_prefix(1);
  sub->footer(examples.empty() ? "" : "Examples:\n" + std::string(examples));
  values_[name];
  return *sub;
}

void Grammar::on(CLI::App& verb, Action action, std::function<void()> check) {
  verb.callback([this, action = std::move(action), check = std::move(check)] {
    misunderstood_ = true;
    if (check) check();
    misunderstood_ = false;
    action_ = action;
  });
}

std::shared_ptr<std::optional<double>> add_duration(CLI::App& verb, const std::string& option,
                                                    const std::string& help) {
  auto seconds = std::make_shared<std::optional<double>>();
  const std::string what = verb.get_name() + " " + option;
  verb.add_option_function<std::string>(
      option, [seconds, what](const std::string& text) { *seconds = parse_duration_s(text, what); },
      help);
  return seconds;
}

void Grammar::values(const CLI::App& verb, const std::string& option,
                     const std::vector<std::string>& values) {
  std::vector<std::string>& list = values_[verb.get_name()][option];
  list.insert(list.end(), values.begin(), values.end());
}

std::vector<std::string> Grammar::verb_names() const {
  std::vector<std::string> names;
  for (const CLI::App* sub : app_.get_subcommands({})) {
    if (!sub->get_group().empty()) names.push_back(sub->get_name());
  }
  return names;
}

Failure Grammar::unknown(const std::vector<std::string>& words) const {
  for (const std::string& word : words) {
    if (!is_verb_like(word)) continue;
    if (!app_.get_subcommands().empty()) {
      return Failure(ExitCode::usage, fmt::format("do not know what '{}' is for", word),
                     see_help(app_.get_subcommands()));
    }
    std::string advice = did_you_mean(word, verb_names());
    return Failure(ExitCode::unknown_name, fmt::format("there is no verb '{}'", word),
                   advice.empty() ? "list them with: lss-cli --help" : advice);
  }
  std::vector<std::string> options;
  for (const CLI::Option* option : app_.get_options()) options.push_back(option->get_name());
  for (const CLI::App* sub : app_.get_subcommands()) {
    for (const CLI::Option* option : sub->get_options()) options.push_back(option->get_name());
  }
  const std::string word = words.empty() ? "" : words.front();
  const std::string advice = did_you_mean(word, options);
  return Failure(ExitCode::usage, fmt::format("there is no option '{}'", word),
                 advice.empty() ? see_help(app_.get_subcommands()) : advice);
}

void Grammar::check_options() {
  options_.vehicle_typed = !options_.vehicle_id.empty();
  const char* vehicle = std::getenv("LSS_VEHICLE");
  if (!options_.vehicle_typed && vehicle != nullptr) options_.vehicle_id = vehicle;
  if (!timeout_.empty()) options_.timeout_s = parse_duration_s(timeout_, "--timeout");
  if (!lease_.empty()) options_.lease_ms = parse_lease_ms(lease_);
  const bool printable =
      std::ranges::all_of(options_.source, [](char c) { return c >= ' ' && c <= '~'; });
  if (options_.source.size() > kSourceLength || !printable) {
    // A forgotten LSS_SOURCE must not prevent a stop.
    if (app_.got_subcommand(common_command(CommandKind::emergency_stop).name))
      return options_.source.clear();
    throw Failure(ExitCode::usage,
                  fmt::format("--source: '{}' must be at most {} printable characters",
                              options_.source, kSourceLength));
  }
}

bool Grammar::may_be_of_another() const {
  if (!misunderstood_) return false;
  const std::vector<CLI::App*> subs = app_.get_subcommands();
  return subs.empty() || !Grammar(scope_, {}).has(subs.front()->get_name());
}

Action Grammar::parse(std::vector<std::string> words) {
  action_ = nullptr;
  misunderstood_ = false;
  std::vector<std::string> reversed(words.rbegin(), words.rend());  // as CLI11 wants them
  try {
    app_.parse(reversed);
  } catch (const CLI::Success& e) {  // help or version was requested
    const auto is_help = [](const std::string& word) { return word == "--help" || word == "-h"; };
    const bool of_a_verb =
        app_.get_subcommands().empty() && std::ranges::any_of(app_.remaining(true), is_verb_like);
    if (of_a_verb && std::erase_if(words, is_help) > 0) return parse(std::move(words));
    const std::string text =
        e.get_name() == "CallForVersion" ? std::string(e.what()) + "\n" : app_.help();
    return [text](Context&) {
      std::fputs(text.c_str(), stdout);
      return ExitCode::completed;
    };
  } catch (const CLI::ExtrasError&) {
    misunderstood_ = true;
    check_options();
    throw unknown(app_.remaining(true));
  } catch (const Failure&) {  // of a verb's own check
    check_options();
    throw;
  } catch (const CLI::ParseError& e) {
    const std::vector<CLI::App*> subs = app_.get_subcommands();
    std::string text =
        subs.empty() || e.get_name() != "RequiredError" ? "" : still_needed(*subs.front());
    if (text.empty()) text = e.what();
    throw Failure(ExitCode::usage, text, see_help(subs));
  }
  check_options();
  if (action_ == nullptr) {
    throw Failure(ExitCode::usage, "no verb given", "list the verbs with: lss-cli --help");
  }
  return action_;
}

std::vector<const Vehicle*> vehicles_of(Context& context) {
  if (context.connected() && context.session().link().is_described())
    return {&context.session().vehicle()};
  return {vehicles().begin(), vehicles().end()};
}

Parsed parse(Context& context, Grammar::Scope scope, const std::vector<std::string>& words) {
  auto grammar = std::make_unique<Grammar>(scope, vehicles_of(context));
  try {
    Action action = grammar->parse(words);
    return {std::move(grammar), std::move(action)};
  } catch (const Failure&) {
    const bool asked = context.connected();
    if (asked || !grammar->may_be_of_another() || context.described() == nullptr) throw;
  }
  grammar = std::make_unique<Grammar>(scope, vehicles_of(context));
  Action action = grammar->parse(words);
  return {std::move(grammar), std::move(action)};
}

void add_list(CLI::App& verb, const std::string& option, std::vector<std::string>& list,
              const std::string& help) {
  verb.add_option(option, list, help)->delimiter(',')->allow_extra_args(false);
}

void add_span(CLI::App& verb, recording::Filter& filter, const std::string& since) {
  const auto add = [&](const char* option, double& value) {
    verb.add_option_function<std::string>(
        option,
        [&value, option](const std::string& text) { value = parse_quantity(text, "s", option); },
        since);
  };
  add("--from", filter.from_s);
  add("--to", filter.until_s);
}

std::vector<std::string> Grammar::candidates(const std::vector<std::string>& words) const {
  const std::string last = words.empty() ? "" : words.back();
  const std::string before = words.size() < 2 ? "" : words[words.size() - 2];
  const auto is_verb = [&](const std::string& word) { return values_.contains(word); };
  const auto verb =
      words.empty() ? words.end() : std::find_if(words.begin(), words.end() - 1, is_verb);
  std::vector<std::string> all;
  if (words.empty() || verb == words.end() - 1 || verb == words.end()) {
    all = verb_names();
  } else if (const auto& known = values_.at(*verb); known.contains(before)) {
    all = known.at(before);
  } else {
    if (known.contains("")) all = known.at("");
    for (const CLI::Option* option : app_.get_subcommand(*verb)->get_options()) {
      if (!option->get_lnames().empty()) all.push_back("--" + option->get_lnames().front());
    }
  }
  if (last.starts_with('-')) {
    for (const CLI::Option* option : app_.get_options())
      all.push_back("--" + option->get_lnames().front());
  }
  std::erase_if(all, [&](const std::string& word) { return !word.starts_with(last); });
  std::ranges::sort(all);
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

}  // namespace lss::cli
