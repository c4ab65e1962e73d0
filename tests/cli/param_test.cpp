// lss-cli param, against a stand-in for the daemon.

#include "tests/cli/program_test.h"

namespace lss::cli::test {
namespace {

using Param = ProgramTest;

json parameters(const Ended& ended) { return json::parse(ended.out)["parameters"]; }

TEST_F(Param, GetShowsValueRangeAndWhatIsSaved) {
  FakeDaemon daemon(domain());
  const Ended all = run({"param", "get"});
  ASSERT_EQ(all.code, 0) << all.err;
  EXPECT_THAT(all.out, HasSubstr("limits.current_A"));
  EXPECT_THAT(all.out, HasSubstr("0.05 to 1.7"));
  EXPECT_THAT(all.out, HasSubstr("at rest"));
  const Ended one = run({"param", "get", "gait.flight_s"});
  EXPECT_THAT(one.out, Not(HasSubstr("limits.current_A")));
  EXPECT_THAT(one.out, HasSubstr("a leg in the air"));
  EXPECT_THAT(daemon.kinds(), IsEmpty());  // no command was sent
}

TEST_F(Param, JsonHasTheKeysThatProgramsRelyOn) {
  FakeDaemon daemon(domain());
  const json all = parameters(run({"--json", "param", "get"}));
  ASSERT_EQ(all.size(), 3U);
  const json& p = all[0];
  EXPECT_EQ(p["name"], "limits.current_A");
  EXPECT_EQ(p["value"], 1.2);
  EXPECT_EQ(p["unit"], "A");
  EXPECT_EQ(p["min"], 0.05);
  EXPECT_EQ(p["max"], 1.7);
  EXPECT_EQ(p["configured"], 1.2);
  EXPECT_TRUE(p["saved"].is_null());
  EXPECT_EQ(p["change"], "always");
  EXPECT_EQ(all[1]["change"], "at_rest");
}

TEST_F(Param, SetSendsNameAndValueAndSaysHowToKeepIt) {
  FakeDaemon daemon(domain());
  const Ended ended = run({"param", "set", "limits.current_A", "1.5A", "gait.flight_s", "4"});
  ASSERT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(daemon.kinds(), ElementsAre(kSetParameter, kSetParameter));
  const lss_Command last = daemon.last(kSetParameter);
  EXPECT_STREQ(last.name, "gait.flight_s");
  EXPECT_EQ(last.parameter[0], 4);
  EXPECT_THAT(ended.out, HasSubstr("limits.current_A: 1.2 to 1.5 A"));
  EXPECT_THAT(ended.err, HasSubstr("lss-cli param save"));
}

TEST_F(Param, DiffSaveAndResetAreAWayThereAndBack) {
  FakeDaemon daemon(domain());
  EXPECT_THAT(run({"param", "diff"}).out, HasSubstr("all as the configuration says"));
  ASSERT_EQ(run({"param", "set", "solve.rounds", "7"}).code, 0);
  const Ended unsaved = run({"param", "diff"});
  EXPECT_THAT(unsaved.out, HasSubstr("configuration 10, saved -  not saved"));
  ASSERT_EQ(run({"param", "save"}).code, 0);
  const json saved = parameters(run({"--json", "param", "diff"}));
  ASSERT_EQ(saved.size(), 1U);
  EXPECT_EQ(saved[0]["saved"], 7);
  EXPECT_THAT(run({"param", "diff"}).out, Not(HasSubstr("not saved")));
  ASSERT_EQ(run({"param", "reset"}).code, 0);
  EXPECT_STREQ(daemon.last(kSetParameter).name, "solve.rounds");
  EXPECT_EQ(daemon.last(kSetParameter).parameter[0], 10);
  // As configured, but the next start would take the saved value.
  EXPECT_THAT(run({"param", "diff"}).out, HasSubstr("saved 7  not saved"));
  ASSERT_EQ(run({"param", "save"}).code, 0);
  EXPECT_EQ(parameters(run({"--json", "param", "diff"})).size(), 0U);
}

TEST_F(Param, AnUnknownNameIsNotSentAndGuessed) {
  FakeDaemon daemon(domain());
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"param", "set", "limits.curent_A", "1"},
        std::vector<std::string>{"param", "get", "limits.curent_A"},
        std::vector<std::string>{"param", "set", "gait.flight_s", "4", "limits.curent_A", "1"}}) {
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, 4);
    EXPECT_THAT(ended.err, HasSubstr("did you mean limits.current_A?"));
  }
  EXPECT_THAT(daemon.kinds(), IsEmpty());
}

TEST_F(Param, WhatIsNoCommandLineIsUsage) {
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{"param"}, std::vector<std::string>{"param", "put"},
        std::vector<std::string>{"param", "set", "gait.flight_s"},
        std::vector<std::string>{"param", "set"}, std::vector<std::string>{"param", "save", "x"}})
    EXPECT_EQ(run(words).code, 2) << words.back();
  FakeDaemon daemon(domain());
  for (const char* value : {"much", "1.5s", "nan", "1.5 A A"}) {
    const Ended ended = run({"param", "set", "limits.current_A", value});
    EXPECT_EQ(ended.code, 2) << value;
    EXPECT_THAT(ended.err, HasSubstr("no number in A"));
  }
}

TEST_F(Param, ARefusalAndAFailureHaveTheirExitCodes) {
  FakeDaemon daemon(domain());
  daemon.trouble(kSetParameter, {Trouble::Kind::reject, Reason::not_in_state});
  EXPECT_EQ(run({"param", "set", "gait.flight_s", "4"}).code, 5);
  daemon.trouble(kSaveParameters, {Trouble::Kind::reject, Reason::not_authorised});
  EXPECT_EQ(run({"param", "save"}).code, 8);
}

TEST_F(Param, StatusShowsACopyThatIsNotGoodAndHealthIsStill0) {
  FakeDaemon daemon(domain());
  EXPECT_EQ(json::parse(run({"--json", "status"}).out)["saved_parameters"], "none");
  daemon.saved_parameters(lss_SAVED_ONE_COPY);
  ASSERT_TRUE(await([&] {
    return json::parse(run({"--json", "status"}).out)["saved_parameters"] == "one_copy";
  }));
  EXPECT_THAT(run({"status"}).out, HasSubstr("one copy of the saved parameters is not good"));
  EXPECT_EQ(run({"health"}).code, 0);  // a warning
}

}  // namespace
}  // namespace lss::cli::test
