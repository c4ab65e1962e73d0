// The program as shells see it, without a daemon.

#include "tests/cli/program_test.h"

#include <unistd.h>

#include <cstdlib>
#include <fstream>

namespace lss::cli::test {
namespace {

using ProgramAlone = ProgramTest;

TEST_F(ProgramAlone, HelpOfEveryVerbHasAnExampleOfItself) {
  const Ended help = run({"--help"});
  EXPECT_EQ(help.code, 0);
  for (const char* verb :
       {"status",    "health", "start",  "stop",    "stand", "lay-down", "stow",
        "walk",      "leg",    "panel",  "estop",   "solve", "reset",    "data",
        "watch",     "events", "timing", "command", "run",   "shell",    "completion",
        "heartbeat", "doctor", "log",    "param",   "serve"}) {
    EXPECT_THAT(help.out, HasSubstr(std::string("\n  ") + verb));
    const Ended own = run({verb, "--help"});
    EXPECT_EQ(own.code, 0);
    EXPECT_THAT(own.out, HasSubstr("Examples:")) << verb;
    EXPECT_THAT(own.out, HasSubstr(verb));
  }
}

TEST_F(ProgramAlone, MistakesHaveTheirCodeWhenNobodyAnswers) {
  EXPECT_EQ(run({"--timeout", "0.2", "wlak", "forward"}).code, 4);
  EXPECT_EQ(run({"--timeout", "0.2", "command", "describe", "wlak"}).code, 4);
  EXPECT_EQ(run({"completion", "tcsh"}).code, 4);
  EXPECT_EQ(run({"--timeout", "0.2", "walk", "--heading", "120"}).code, 2);
  EXPECT_EQ(run({"--timeout", "0.2", "stand", "--for", "3s"}).code, 2);
  EXPECT_EQ(run({"run"}).code, 2);
  EXPECT_EQ(run({"run", "/nowhere/patrol.lss"}).code, 2);
  EXPECT_EQ(run({"--enclave", "/nowhere/pilot", "status"}).code, 2);
  EXPECT_EQ(run({}).code, 2);
}

TEST_F(ProgramAlone, AMistakeIsADocumentTooWhenJsonIsAskedFor) {
  const Ended ended = run({"--json", "--timeout", "0.2", "wlak"});
  const nlohmann::json document = nlohmann::json::parse(ended.out);
  EXPECT_EQ(document["exit_code"], 4);
  EXPECT_EQ(document["error"]["advice"], "did you mean walk?");
}

TEST_F(ProgramAlone, CompletionScriptsAreGoodShell) {
  for (const char* shell : {"bash", "zsh", "fish"}) {
    const Ended script = run({"completion", shell});
    EXPECT_EQ(script.code, 0);
    EXPECT_THAT(script.out, HasSubstr("__complete"));
    if (std::system((std::string("command -v ") + shell + " > /dev/null").c_str()) != 0) continue;
    const std::string name = testing::TempDir() + "lss-completion-" + std::to_string(getpid());
    std::ofstream(name) << script.out;
    EXPECT_EQ(std::system((std::string(shell) + " -n " + name).c_str()), 0) << shell;
    unlink(name.c_str());
  }
}

TEST_F(ProgramAlone, BashCompletesWithTheScript) {
  const std::string line =
      "source <(\"" LSS_CLI "\" completion bash); COMP_WORDS=(\"" LSS_CLI
      "\" walk --speed m); COMP_CWORD=3; _lss_cli; test \"${COMPREPLY[*]}\" = medium";
  EXPECT_EQ(std::system(("bash -c '" + line + "'").c_str()), 0);
}

TEST_F(ProgramAlone, VersionIsReportedAsWordAndOption) {
  EXPECT_EQ(run({"version"}).out, run({"--version"}).out);
  EXPECT_EQ(nlohmann::json::parse(run({"--json", "version"}).out)["schema_version"], 2);
}

}  // namespace
}  // namespace lss::cli::test
