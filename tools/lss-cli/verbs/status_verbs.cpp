// status, health, watch and data: how the vehicle is.

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

// Of all daemons that publish for the vehicle.
nlohmann::json daemons_json(const Session& session) {
  nlohmann::json list = nlohmann::json::array();
  for (const lss_Instance& instance : session.link().instances())
    list.push_back(instance_json(instance));
  return list;
}

ExitCode run_status(Context& context) {
  Session& session = context.session();
  const void* telemetry = session.telemetry();
  const lss_Status& status = session.status();
  nlohmann::json document = status_json(session.vehicle(), status, telemetry);
  document["daemons"] = daemons_json(session);
  context.output.document(std::move(document));
  if (const auto conflict = name_conflict(status, session.link().instances()))
    context.output.print(problem_lines({*conflict}, context.output.style()));
  context.output.print(status_screen(session.vehicle(), status, telemetry, context.output.style()));
  return ExitCode::completed;
}

ExitCode run_health(Context& context) {
  Session& session = context.session();
  const void* telemetry = session.telemetry();
  const lss_Status& status = session.status();
  std::vector<Problem> list = problems(session.vehicle(), status, telemetry);
  if (auto conflict = name_conflict(status, session.link().instances()))
    list.insert(list.begin(), std::move(*conflict));
  const bool healthy = list.empty() || !list.front().error;  // errors stand first
  nlohmann::json found = nlohmann::json::array();
  const Style& style = context.output.style();
  context.output.print(
      fmt::format("{} {}\n", text(status.vehicle_id),
                  healthy ? style.good("is healthy") : style.bad("is not healthy")));
  for (const Problem& problem : list) {
    found.push_back({{"severity", problem.error ? "error" : "warning"},
                     {"text", problem.text},
                     {"advice", problem.advice}});
  }
  context.output.print(problem_lines(list, style));
  context.output.document({{"vehicle_id", text(status.vehicle_id)},
                           {"state", state_name(status.state)},
                           {"healthy", healthy},
                           {"problems", std::move(found)}});
  return healthy ? ExitCode::completed : ExitCode::failed;
}

ExitCode run_data(Context& context) {
  Session& session = context.session();
  session.open_telemetry();
  session.complete(with_defaults(
      find_command(session.vehicle(), static_cast<std::uint16_t>(CommandKind::request_data))));
  const void* telemetry = session.telemetry();
  if (telemetry == nullptr) {
    throw Failure(ExitCode::timed_out, "the daemon acknowledged, but no telemetry came",
                  "is its telemetry on shared memory only? see: lss-cli status");
  }
  const Vehicle& vehicle = session.vehicle();
  context.output.document(status_json(vehicle, session.status(), telemetry));
  const Style& style = context.output.style();
  context.output.print(vehicle.screen(telemetry, style) + "\n");
  context.output.print(vehicle.details(telemetry, style));
  return ExitCode::completed;
}

// The terminal while a screen is redrawn in place; restored at the end.
class FullScreen {
 public:
  FullScreen() { put("\x1b[?1049h\x1b[?25l"); }
  ~FullScreen() { put("\x1b[?25h\x1b[?1049l"); }
  FullScreen(const FullScreen&) = delete;
  FullScreen& operator=(const FullScreen&) = delete;

  // Overwritten line by line, so that nothing flickers.
  void draw(std::string_view screen) {
    std::string text = "\x1b[H";
    for (const char c : screen) text += c == '\n' ? "\x1b[K\n" : std::string(1, c);
    put(text + "\x1b[J");
  }

 private:
  static void put(const std::string& text) {
    std::fwrite(text.data(), 1, text.size(), stdout);
    std::fflush(stdout);
  }
};

ExitCode run_watch(Context& context, std::optional<double> for_s) {
  Session& session = context.session();
  session.telemetry();
  const Output& output = context.output;
  std::optional<FullScreen> screen;
  if (output.terminal()) screen.emplace();
  const double period_s = screen ? 0.1 : 1;
  const Clock::time_point end = for_s ? Clock::now() + seconds(*for_s) : Clock::time_point::max();
  try {
    while (Clock::now() < end) {
      const lss_Status& status = session.link().status();
      const void* telemetry = session.link().telemetry();
      if (screen) {
        screen->draw(status_screen(session.vehicle(), status, telemetry, output.style()) +
                     "\nCtrl-C to leave\n");
      } else {
        context.output.print(status_line(session.vehicle(), status, telemetry) + "\n");
        context.output.record(status_json(session.vehicle(), status, telemetry));
      }
      const Clock::time_point next = std::min(end, Clock::now() + seconds(period_s));
      while (Clock::now() < next) session.pump(next);
    }
  } catch (const Interrupted&) {
  }
  return ExitCode::completed;
}

}  // namespace

void add_status_verbs(Grammar& grammar) {
  grammar.on(grammar.verb("status", "how the vehicle is, what is wrong first",
                          "  lss-cli status\n  lss-cli --json status | jq .telemetry\n"),
             run_status);
  grammar.on(grammar.verb("health", "0 when all is well, else 6 and what is wrong",
                          "  lss-cli health || lss-cli solve\n"),
             run_health);
  CLI::App& watch =
      grammar.verb("watch", "status, updated continuously",
                   "  lss-cli watch\n  lss-cli --jsonl watch --for 1min > log.jsonl\n");
  const auto for_s = add_duration(watch, "--for", "how long (default: until Ctrl-C)");
  grammar.on(watch, [for_s](Context& context) {
    if (context.options.json) throw Failure(ExitCode::usage, "watch is a stream", "use --jsonl");
    return run_watch(context, *for_s);
  });
  grammar.on(grammar.verb("data", "ask for one sample of everything measured",
                          "  lss-cli data\n  lss-cli --json data\n"),
             run_data);
}

}  // namespace lss::cli
