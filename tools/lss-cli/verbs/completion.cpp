// completion: scripts for shells. They ask lss-cli itself for the next words (Grammar::candidates).

#include <fmt/format.h>

#include "tools/lss-cli/verbs/recording_verbs.h"
#include "tools/lss-cli/verbs/serve_verb.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

constexpr const char* kBash = R"bash(# lss-cli completion; use: source <(lss-cli completion bash)
_lss_cli() {
  local IFS=$'\n'
  COMPREPLY=($("${COMP_WORDS[0]}" __complete "${COMP_WORDS[@]:1:COMP_CWORD}" 2>/dev/null))
}
complete -o default -F _lss_cli lss-cli
)bash";

constexpr const char* kZsh = R"zsh(#compdef lss-cli
# lss-cli completion; use: source <(lss-cli completion zsh), or as _lss-cli in a folder of fpath
_lss_cli() {
  local -a found
  found=(${(f)"$("${words[1]}" __complete "${(@)words[2,CURRENT]}" 2>/dev/null)"})
  (( ${#found} )) && compadd -a found || _files
}
if [ "${funcstack[1]}" = "_lss-cli" ]; then
  _lss_cli "$@"
else
  compdef _lss_cli lss-cli
fi
)zsh";

constexpr const char* kFish = R"fish(# lss-cli completion; use: lss-cli completion fish | source
function __lss_cli_candidates
  set -l words (commandline -opc) (commandline -ct)
  $words[1] __complete $words[2..-1] 2>/dev/null
end
complete -c lss-cli -f -a '(__lss_cli_candidates)'
)fish";

const char* script(const std::string& shell) {
  if (shell == "bash") return kBash;
  if (shell == "zsh") return kZsh;
  if (shell == "fish") return kFish;
  throw Failure(ExitCode::unknown_name, fmt::format("there is no completion for '{}'", shell),
                "there is for bash, zsh and fish");
}

ExitCode run_version(Context& context) {
  context.output.document({{"version", LSS_VERSION}});
  context.output.print(version_text() + "\n");
  return ExitCode::completed;
}

}  // namespace

std::string version_text() { return "lss-cli " LSS_VERSION; }

void add_completion_verbs(Grammar& grammar) {
  if (grammar.scope() == Grammar::Scope::program) {
    CLI::App& sub = grammar.verb("completion", "script for bash, zsh or fish",
                                 "  source <(lss-cli completion bash)\n");
    auto shell = std::make_shared<std::string>();
    sub.add_option("shell", *shell, "bash, zsh or fish")->required();
    grammar.values(sub, "", {"bash", "zsh", "fish"});
    grammar.on(sub, [shell](Context& context) {
      context.output.print(script(*shell));
      return ExitCode::completed;
    });
  }
  grammar.on(grammar.verb("version", "of lss-cli"), run_version);
}

void add_verbs(Grammar& grammar) {
  add_status_verbs(grammar);
  add_command_verbs(grammar);
  add_param_verb(grammar);
  add_event_verbs(grammar);
  add_dictionary_verbs(grammar);
  add_timing_verbs(grammar);
  add_log_verbs(grammar);
  add_record_verb(grammar);
  add_plot_verb(grammar);
  add_report_verb(grammar);
  add_sequence_verbs(grammar);
  add_serve_verb(grammar);
  add_doctor_verbs(grammar);
  add_keystore_verb(grammar);
  add_completion_verbs(grammar);
}

}  // namespace lss::cli
