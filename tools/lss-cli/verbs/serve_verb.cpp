// serve: the socket of an OBC that polls.

#include "tools/lss-cli/verbs/serve_verb.h"

#include <fmt/format.h>

#include "tools/lss-cli/verbs/poll_server.h"

namespace lss::cli {
namespace {

constexpr const char* kSource = "obc";

ExitCode run_serve(Context& context, const std::string& path, const std::string& group) {
  const Options& options = context.options;
  if (options.machine() || options.dry_run || options.detach || options.wait) {
    throw Failure(ExitCode::usage, "serve has no --json, --jsonl, --dry-run, --detach and --wait",
                  "replies are JSON always");
  }
  if (context.options.source.empty()) context.options.source = kSource;
  // Before there is a socket: no request waits for the daemon.
  Link& link = context.session().link();
  link.open_commands(context.options.source);
  obc::Socket socket(path, group);
  PollServer server(context, socket);
  context.output.note(fmt::format("{} is served at {} for {}", text(link.status().vehicle_id), path,
                                  link.source()));
  server.run();
  return ExitCode::completed;
}

}  // namespace

void add_serve_verb(Grammar& grammar) {
  if (grammar.scope() == Grammar::Scope::sequence) return;
  CLI::App& sub =
      grammar.verb("serve", "answers an OBC that polls a socket, with a CRC in each line", R"(
  lss-cli --vehicle zebro-1 serve --socket /run/lss-obc/zebro-1 --group obc
  lss-cli --lease 5s serve --socket /run/lss-obc/zebro-1     for an OBC that polls slowly
Request 'CRC SEQUENCE WORDS', reply 'CRC SEQUENCE JSON': docs/cli.md. It moves nothing by
itself: when requests end for the lease, the vehicle stops.
)");
  auto path = std::make_shared<std::string>();
  auto group = std::make_shared<std::string>();
  sub.add_option("--socket", *path, "path of the Unix socket to make")->required();
  sub.add_option("--group", *group, "whose members may connect (default: of this process)");
  grammar.on(sub, [path, group](Context& context) { return run_serve(context, *path, *group); });
}

}  // namespace lss::cli
