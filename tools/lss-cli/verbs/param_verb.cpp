// param: parameters that can be changed while the daemon runs.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>

#include "tools/lss-cli/session/parameters.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

constexpr double kWait_s = 3;

using Words = std::vector<std::string>;
using Items = std::vector<lss_Parameter>;

// The daemon's report on its parameters.
class Board {
 public:
  explicit Board(Session& session) : session_(session) {
    session.link().open_parameters();
    const Clock::time_point until = Clock::now() + seconds(kWait_s);
    while (!take() && Clock::now() < until) session.pump(until);
    if (!heard_) {
      throw Failure(ExitCode::timed_out, "no parameters came",
                    "does the daemon run, and is it as new as this lss-cli? see: lss-cli status");
    }
  }

  // The newest.
  const lss_Parameters& sample() {
    take();
    return sample_;
  }
  lss_Parameter find(const std::string& name) {
    Words names;
    for (const lss_Parameter& p : items(sample())) {
      names.emplace_back(text(p.name));
      if (names.back() == name) return p;
    }
    std::string advice = did_you_mean(name, names);
    if (advice.empty()) advice = "list them with: lss-cli param get";
    throw Failure(ExitCode::unknown_name,
                  fmt::format("{} has no parameter '{}'", session_.vehicle().name, name), advice);
  }
  // The named parameters, or all.
  Items find(const Words& names) {
    const std::span<const lss_Parameter> all = items(sample());
    if (names.empty()) return {all.begin(), all.end()};
    Items found;
    for (const std::string& name : names) found.push_back(find(name));
    return found;
  }

 private:
  bool take() {
    while (const std::optional<lss_Parameters> next = session_.link().next_parameters()) {
      sample_ = *next;
      heard_ = true;
    }
    return heard_;
  }

  Session& session_;
  lss_Parameters sample_{};
  bool heard_ = false;
};

std::string show(double value) { return fmt::format("{:.10g}", value); }

std::string with_unit(double value, const lss_Parameter& p) {
  const std::string_view unit = text(p.unit);
  return unit.empty() ? show(value) : fmt::format("{} {}", show(value), unit);
}

const char* change_name(const lss_Parameter& p) {
  return p.change == lss_CHANGE_ALWAYS ? "always" : "at rest";
}

ExitCode get(Context& context, const Words& names) {
  Session& session = context.session();
  Board board(session);
  const Items found = board.find(names);
  context.output.document(parameters_json(session.vehicle(), board.sample(), found));
  const Style& style = context.output.style();
  context.output.print(style.dim(fmt::format("{:<34} {:>14}  {:<22} {:>12} {:>12}  {}", "", "value",
                                             "range", "configured", "saved", "may be changed")) +
                       "\n");
  for (const lss_Parameter& p : found) {
    const std::string value = fmt::format("{:>14}", with_unit(p.value, p));
    context.output.print(
        fmt::format("{:<34} {}  {:<22} {:>12} {:>12}  {}\n", text(p.name),
                    is_kept(p) ? value : style.warning(value),
                    fmt::format("{} to {}{}", show(p.min), show(p.max), p.whole ? ", whole" : ""),
                    show(p.configured), is_saved(p) ? show(p.saved) : "-", change_name(p)));
    if (names.empty()) continue;
    const std::string help = help_of(session.vehicle(), text(p.name));
    if (!help.empty()) context.output.print(fmt::format("    {}\n", style.dim(help)));
  }
  return ExitCode::completed;
}

ExitCode diff(Context& context, const Words& names) {
  Session& session = context.session();
  Board board(session);
  Items found = board.find(names);
  std::erase_if(found, [](const lss_Parameter& p) { return is_configured(p) && is_kept(p); });
  context.output.document(parameters_json(session.vehicle(), board.sample(), found));
  const Style& style = context.output.style();
  bool unsaved = false;
  for (const lss_Parameter& p : found) {
    unsaved = unsaved || !is_kept(p);
    context.output.print(fmt::format("{:<34} {:>14}  configuration {}, saved {}{}\n", text(p.name),
                                     with_unit(p.value, p), show(p.configured),
                                     is_saved(p) ? show(p.saved) : "-",
                                     is_kept(p) ? "" : style.warning("  not saved")));
  }
  if (found.empty()) context.output.print("all as the configuration says\n");
  if (unsaved) context.output.note("lss-cli param save keeps them for the next start");
  return ExitCode::completed;
}

// "1.5", "1.5A", "1.5 A".
double parse(const std::string& typed, const lss_Parameter& p) {
  char* end = nullptr;
  const double value = std::strtod(typed.c_str(), &end);
  std::string_view rest(end);
  while (rest.starts_with(' ')) rest.remove_prefix(1);
  if (end == typed.c_str() || !std::isfinite(value) || (!rest.empty() && rest != text(p.unit))) {
    throw Failure(ExitCode::usage,
                  fmt::format("{}: '{}' is no number{}", text(p.name), typed,
                              text(p.unit).empty() ? "" : fmt::format(" in {}", text(p.unit))));
  }
  return value;
}

void change(Context& context, const lss_Parameter& before, double value) {
  Session& session = context.session();
  const Invocation command{.info = &common_command(CommandKind::set_parameter),
                           .parameter = {value},
                           .name = std::string(text(before.name))};
  if (context.options.dry_run) return session.dry_run(command);
  session.complete(command);
  context.output.print(fmt::format("{}: {} to {}\n", text(before.name), show(before.value),
                                   with_unit(value, before)));
}

void say_how_to_keep(Context& context) {
  if (!context.options.dry_run)
    context.output.note("until the daemon ends; lss-cli param save keeps it");
}

ExitCode set(Context& context, const Words& words) {
  Board board(context.session());
  std::vector<std::pair<lss_Parameter, double>> wanted;
  for (std::size_t i = 0; i + 1 < words.size(); i += 2) {
    const lss_Parameter before = board.find(words[i]);
    wanted.emplace_back(before, parse(words[i + 1], before));
  }
  for (const auto& [before, value] : wanted) change(context, before, value);
  say_how_to_keep(context);
  return ExitCode::completed;
}

ExitCode reset(Context& context, const Words& names) {
  Board board(context.session());
  std::size_t changed = 0;
  for (const lss_Parameter& p : board.find(names)) {
    if (is_configured(p)) continue;
    change(context, p, p.configured);
    ++changed;
  }
  if (changed == 0) {
    context.output.print("all as the configuration says\n");
  } else {
    say_how_to_keep(context);
  }
  return ExitCode::completed;
}

ExitCode save(Context& context) {
  Session& session = context.session();
  const Invocation command{&common_command(CommandKind::save_parameters), {}};
  if (context.options.dry_run) {
    session.dry_run(command);
  } else {
    session.complete(command);
  }
  return ExitCode::completed;
}

struct Typed {
  std::string what;
  Words words;
};

void check(const Typed& typed) {
  const bool pairs = typed.what == "set" && !typed.words.empty() && typed.words.size() % 2 == 0;
  const bool names = typed.what == "get" || typed.what == "diff" || typed.what == "reset";
  if (pairs || names || (typed.what == "save" && typed.words.empty())) return;
  throw no_form(fmt::format("param {} {}", typed.what, fmt::join(typed.words, " ")),
                "param get [NAME...], set NAME VALUE [NAME VALUE...], diff [NAME...], save, or "
                "reset [NAME...]");
}

}  // namespace

void add_param_verb(Grammar& grammar) {
  CLI::App& sub = grammar.verb("param", "parameters: get, set, diff, save, reset", R"(
  lss-cli param get                          all, with range and what is saved
  lss-cli param set limits.current_A 1.0     in force at once, until the daemon ends
  lss-cli param diff                         what is not as configured, or not saved
  lss-cli param save                         keeps them for the next start
  lss-cli param reset limits.current_A       as configured again
)");
  auto typed = std::make_shared<Typed>();
  sub.add_option("what", typed->what, "get, set, diff, save or reset")->required();
  sub.add_option("words", typed->words, "names; of set: names and values");
  grammar.values(sub, "", {"get", "set", "diff", "save", "reset"});
  for (const Vehicle* vehicle : grammar.vehicles()) {
    Words names;
    for (const TunableInfo& t : vehicle->tunables) names.emplace_back(t.name);
    for (const char* before : {"get", "set", "diff", "reset"}) grammar.values(sub, before, names);
    grammar.values(sub, "", names);
  }
  grammar.on(
      sub,
      [typed](Context& context) {
        if (typed->what == "get") return get(context, typed->words);
        if (typed->what == "set") return set(context, typed->words);
        if (typed->what == "diff") return diff(context, typed->words);
        if (typed->what == "reset") return reset(context, typed->words);
        return save(context);
      },
      [typed] { check(*typed); });
}

}  // namespace lss::cli
