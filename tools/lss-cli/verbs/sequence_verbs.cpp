// run and shell: many verbs under one heartbeat; wait between them.

#include <fmt/format.h>

#include <filesystem>

#include "drivers/lockstep/lockstep.h"
#include "tools/lss-cli/verbs/shell.h"
#include "tools/lss-cli/verbs/steps.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

void add_run(Grammar& grammar) {
  CLI::App& sub =
      grammar.verb("run", "many verbs under one heartbeat; then it lies down and stops", R"(
  lss-cli run patrol.lss
  lss-cli run -e 'start; stand; walk forward --for 10s; stop'
  lss-cli run -e 'walk forward low; wait 20s; walk --heading 45; wait 10s'
)");
  auto file = std::make_shared<std::string>();
  auto text = std::make_shared<std::string>();
  auto stay = std::make_shared<bool>(false);
  CLI::Option* named = sub.add_option(
      "file", *file, "a verb per line, or several divided by ';'; # begins a comment");
  sub.add_option("-e,--execute", *text, "the verbs themselves")->excludes(named);
  sub.add_flag("--stay", *stay, "leave it at the end as it is (the lease stops it)");
  auto lockstep = std::make_shared<bool>(false);
  auto folder = std::make_shared<std::string>("/run/lss");
  CLI::Option* simulated = sub.add_flag("--lockstep", *lockstep,
                                        "in the simulated time of lss-sim --lockstep: each command "
                                        "lands in the same frame every time");
  sub.add_option("--dir", *folder, "folder of the simulator and of lssd")
      ->needs(simulated)
      ->capture_default_str();
  grammar.on(sub, [=](Context& context) {
    if (file->empty() && text->empty())
      throw Failure(ExitCode::usage, "run what?", "name a FILE, or -e 'VERB; VERB'");
    const std::string name = file->empty() ? "-e" : *file;
    context.options.lockstep = *lockstep;
    const std::vector<Step> steps =
        parse_steps(context, file->empty() ? *text : read_input(*file), name);
    if (*lockstep) {
      if (!std::filesystem::exists(std::filesystem::path(*folder) / "lockstep"))
        throw Failure(ExitCode::unreachable, "no simulated time in " + *folder,
                      "start lss-sim VEHICLE --lockstep with this folder as its --dir");
      context.session().take_part(*folder);
    }
    return run_steps(context, steps, *stay);
  });
}

// While it exists, the client waits at the speed of the simulator.
class AtSpeed {
 public:
  explicit AtSpeed(lockstep::Client* client) : client_(client) {
    if (client_ != nullptr) client_->wait_at_speed(true);
  }
  ~AtSpeed() {
    if (client_ != nullptr) client_->wait_at_speed(false);
  }
  AtSpeed(const AtSpeed&) = delete;
  AtSpeed& operator=(const AtSpeed&) = delete;

 private:
  lockstep::Client* client_;
};

void add_wait(Grammar& grammar) {
  CLI::App& sub = grammar.verb("wait", "let time pass, with the heartbeat", "  wait 10s\n");
  const auto time_s = add_duration(sub, "time", "how long");
  sub.get_option("time")->required();
  auto at_speed = std::make_shared<bool>(false);
  sub.add_flag("--at-speed", *at_speed,
               "in simulated time: at lss-sim's --speed, not at its --client-speed");
  grammar.on(sub, [=](Context& context) {
    const Clock::time_point end = Clock::now() + seconds(**time_s);
    Session& session = context.session();
    const AtSpeed slow(*at_speed ? session.simulation() : nullptr);
    const bool attached = session.attached();
    while (Clock::now() < end) {
      session.pump(end);
      if (attached) session.check_in_force();
    }
    return ExitCode::completed;
  });
}

}  // namespace

void add_sequence_verbs(Grammar& grammar) {
  if (grammar.scope() == Grammar::Scope::sequence) {
    add_wait(grammar);
    return;
  }
  add_run(grammar);
  grammar.on(grammar.verb("shell",
                          "verbs typed one by one under one heartbeat, with history and completion",
                          "  lss-cli shell\n"),
             run_shell);
}

}  // namespace lss::cli
