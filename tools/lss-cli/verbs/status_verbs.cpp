// status, health, watch and data: how the vehicle is; fleet: how all of them are.

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
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
  session.complete({&common_command(CommandKind::request_data), {}});
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

std::string fleet_line(const lss_Status& status, const Style& style) {
  const bool operational = status.state == lss_STATE_OPERATIONAL;
  const std::string state =
      fmt::format("{:<13}", operational ? std::string(text(status.mode_name))
                                        : std::string(state_name(status.state)));
  const std::string faults = fmt::format(
      "{:<10}", status.fault_count == 0   ? "no fault"
                : status.fault_count == 1 ? "1 fault"
                                          : fmt::format("{} faults", status.fault_count));
  const std::string_view holder = text(status.authority);
  return fmt::format("{:<16} {:<9} {} {} {}, {}\n", text(status.vehicle_id), text(status.vehicle),
                     status.state == lss_STATE_FATAL_ERROR ? style.bad(state)
                     : operational                         ? style.good(state)
                                                           : state,
                     status.fault_count > 0 ? style.bad(faults) : faults,
                     holder.empty() ? "nobody commands" : fmt::format("{} commands", holder),
                     status.recording ? "recording" : "not recording");
}

// Nothing of a vehicle but its status: it may be one that this program was built without.
ExitCode run_fleet(Context& context) {
  Link& link = context.link();
  link.may_be_described();  // waits for the first answer
  link.listen();
  std::vector<const lss_Status*> all;
  for (const auto& [guid, daemon] : link.daemons().all()) {
    if (daemon.heard) all.push_back(&daemon.status);
  }
  if (all.empty()) throw link.unreachable("");
  std::ranges::sort(all, std::less(), [](const lss_Status* s) { return text(s->vehicle_id); });
  nlohmann::json list = nlohmann::json::array();
  for (const lss_Status* status : all) {
    const std::string_view holder = text(status->authority);
    context.output.print(fleet_line(*status, context.output.style()));
    list.push_back({{"vehicle_id", text(status->vehicle_id)},
                    {"vehicle", text(status->vehicle)},
                    {"state", state_name(status->state)},
                    {"mode", text(status->mode_name)},
                    {"fault_count", status->fault_count},
                    {"authority", holder.empty() ? nlohmann::json() : nlohmann::json(holder)},
                    {"airborne", status->airborne},
                    {"recording", status->recording},
                    {"version", text(status->version)},
                    {"instance", instance_json(status->instance)}});
  }
  const std::size_t silent = link.daemons().all().size() + link.daemons().missing() - all.size();
  if (silent > 0) context.output.note(fmt::format("{} more did not say their names", silent));
  context.output.document({{"vehicles", std::move(list)}, {"without_status", silent}});
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
    winsize size{};
    const bool known = ::ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_row > 0;
    std::string text = "\x1b[H";
    for (const char c : fitted(screen, known ? size.ws_row : 24u, known ? size.ws_col : 80u))
      text += c == '\n' ? "\x1b[K\n" : std::string(1, c);
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
                     "\nCtrl-C to leave");
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
  grammar.on(grammar.verb("fleet", "every vehicle on the domain, a line each", R"(
  lss-cli fleet
  lss-cli --json fleet | jq '.vehicles[].vehicle_id'
Exit code 3: none answered.
)"),
             run_fleet);
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
