#include "tools/lss-cli/verbs/grammar.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace lss::cli {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Words = std::vector<std::string>;

std::vector<std::string> candidates(const Words& words) {
  return Grammar(Grammar::Scope::program).candidates(words);
}

TEST(Grammar, OptionsOfTheProgramMayStandBeforeAndAfterTheVerb) {
  for (const Words& words :
       {Words{"--json", "--domain", "7", "status"}, Words{"status", "--domain", "7", "--json"}}) {
    Grammar grammar(Grammar::Scope::program);
    EXPECT_TRUE(grammar.parse(words));
    EXPECT_TRUE(grammar.options().json);
    EXPECT_EQ(grammar.options().domain, 7);
  }
}

TEST(Grammar, TimesMayCarryTheirUnitAndABareLeaseIsInMilliseconds) {
  Grammar grammar(Grammar::Scope::program);
  grammar.parse({"--timeout", "500ms", "--lease", "750", "stand"});
  EXPECT_DOUBLE_EQ(grammar.options().find_timeout_s(), 0.5);
  EXPECT_EQ(grammar.options().lease_ms, 750U);
  Grammar other(Grammar::Scope::program);
  other.parse({"--lease", "3s", "stand"});
  EXPECT_EQ(other.options().lease_ms, 3000U);
}

TEST(Grammar, AVerbAsParameterIsTheParameter) {
  EXPECT_TRUE(Grammar(Grammar::Scope::program).parse({"start", "stand"}));
  EXPECT_TRUE(Grammar(Grammar::Scope::program).parse({"start", "walk"}));
}

Failure refusal(const Words& words) {
  try {
    Grammar(Grammar::Scope::program).parse(words);
  } catch (const Failure& e) {
    return e;
  }
  return Failure(ExitCode::completed, "was taken");
}

TEST(Grammar, WrongLinesHaveTheirExitCodeAndASuggestion) {
  EXPECT_EQ(refusal({"wlak"}).code(), ExitCode::unknown_name);
  EXPECT_THAT(refusal({"wlak"}).advice(), HasSubstr("walk"));
  EXPECT_EQ(refusal({"wlak", "--help"}).code(), ExitCode::unknown_name);
  EXPECT_THAT(refusal({"--json", "stauts"}).advice(), HasSubstr("status"));
  EXPECT_THAT(refusal({"walk", "--sped", "high"}).advice(), HasSubstr("--speed"));
  EXPECT_EQ(refusal({"walk", "--sped", "high"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({"--domain", "300", "status"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({"--json", "--jsonl", "status"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({"--source", std::string(32, 'x'), "stand"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({"--lease", "soon", "stand"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal({"status", "now"}).code(), ExitCode::usage);
}

TEST(Grammar, WhatIsMissingIsSaidWithItsMeaning) {
  EXPECT_STREQ(refusal({"param"}).what(),
               "param needs one more word: get, set, diff, save or reset");
  EXPECT_STREQ(refusal({"keystore", "create"}).what(),
               "keystore needs one more word: the keystore");
  EXPECT_THAT(refusal({"serve"}).what(), HasSubstr("serve needs --socket: path"));
  EXPECT_STREQ(refusal({"param", "set"}).what(), "cannot understand: param set");
  EXPECT_THAT(refusal({"param", "set"}).advice(), HasSubstr("set NAME VALUE"));
  EXPECT_EQ(refusal({"status", "--bogus"}).advice(), "see: lss-cli status --help");
}

TEST(Grammar, OnlyWordsThatAVehicleMayKnowAreAskedOfAnother) {
  const auto asks = [](const Words& words) {
    Grammar grammar(Grammar::Scope::program);
    EXPECT_THROW(grammar.parse(words), Failure);
    return grammar.may_be_of_another();
  };
  EXPECT_TRUE(asks({"wlak"}));
  EXPECT_TRUE(asks({"--domain", "7", "hover", "--help"}));
  EXPECT_TRUE(asks({"walk", "--gear", "2"}));
  EXPECT_TRUE(asks({"walk", "--heading", "120"}));
  EXPECT_FALSE(asks({"status", "now"}));
  EXPECT_FALSE(asks({"--domain", "300", "wlak"}));
  EXPECT_FALSE(asks({}));
  Grammar grammar(Grammar::Scope::program);
  EXPECT_THROW(grammar.parse({"hover", "--domain", "7", "--timeout", "2s"}), Failure);
  EXPECT_EQ(grammar.options().domain, 7);
  EXPECT_EQ(grammar.options().timeout_s, 2);
}

TEST(Grammar, OfNoVehicleHasTheVerbsThatEveryoneHas) {
  Grammar grammar(Grammar::Scope::program, {});
  EXPECT_TRUE(grammar.has("status"));
  EXPECT_FALSE(grammar.has("walk"));
  EXPECT_THROW(grammar.parse({"walk"}), Failure);
}

TEST(Completion, VerbsOptionsAndValuesAreCompletedWhereTheyMayStand) {
  EXPECT_THAT(candidates({"wa"}), ElementsAre("walk", "watch"));
  EXPECT_THAT(candidates({""}), Contains("status"));
  EXPECT_THAT(candidates({"walk", "--sp"}), ElementsAre("--speed"));
  EXPECT_THAT(candidates({"walk", "--speed", ""}), ElementsAre("high", "low", "medium", "zero"));
  EXPECT_THAT(candidates({"walk", "b"}), ElementsAre("backward"));
  EXPECT_THAT(candidates({"leg", "R"}), ElementsAre("RF", "RH", "RM"));
  EXPECT_THAT(candidates({"command", "describe", "sta"}), ElementsAre("stand", "start"));
  EXPECT_THAT(candidates({"--json", "sta"}), ElementsAre("stand", "start", "status"));
  EXPECT_THAT(candidates({"status", "--js"}), ElementsAre("--json", "--jsonl"));
  EXPECT_THAT(candidates({"param", "s"}), Contains("save"));
  EXPECT_THAT(candidates({"param", "set", "limits.cur"}),
              ElementsAre("limits.current_A", "limits.current_time_ms"));
  EXPECT_THAT(candidates({"zzz"}), IsEmpty());
  EXPECT_THAT(candidates({}), Not(IsEmpty()));
}

}  // namespace
}  // namespace lss::cli
