#include "tools/lss-cli/session/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "idl/angles.h"
#include "idl/zebro/commands.h"
#include "tools/lss-cli/session/vehicle.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;
using Named = std::map<std::string, std::string>;

const Vehicle& zebro_built() { return *find_vehicle("zebro"); }

Invocation read(const char* command, const Words& words, const Named& named = {}) {
  return read_invocation(find_command(zebro_built(), command), zebro_built(), words, named);
}

Failure refusal(const char* command, const Words& words, const Named& named = {}) {
  try {
    read(command, words, named);
  } catch (const Failure& e) {
    return e;
  }
  return {ExitCode::completed, "was taken"};
}

// A script's number is one of four thousand million: they are not tried out.
TEST(Commands, EachOfEveryVehicleSaysWhereItIsAllowedAtOnce) {
  for (const Vehicle* vehicle : vehicles()) {
    for (const CommandInfo* info : commands_of(*vehicle))
      EXPECT_FALSE(vehicle->allowed(*info).empty()) << vehicle->name << " " << info->name;
  }
}

TEST(Commands, WhatIsNotGivenHasTheDefaultOfTheTable) {
  const Invocation walk = read("walk", {});
  EXPECT_EQ(walk.parameter[0], 1);  // forward
  EXPECT_EQ(walk.parameter[1], 0);
  EXPECT_EQ(walk.parameter[2], 2);  // medium
}

TEST(Commands, BareWordsFindTheParameterThatKnowsThem) {
  const Invocation walk = read("walk", {"high", "backward", "-30"});
  EXPECT_EQ(walk.parameter[0], 0);
  EXPECT_NEAR(walk.parameter[1], -30 * kDegree, 1e-12);
  EXPECT_EQ(walk.parameter[2], 3);
}

TEST(Commands, NamedParametersAndBareWordsMeanTheSame) {
  EXPECT_EQ(read("walk", {}, {{"direction", "backward"}, {"speed", "low"}}).parameter,
            read("walk", {"backward", "low"}).parameter);
}

TEST(Commands, RequiredParametersComeInTheirOrder) {
  const Invocation leg = read("leg", {"RM", "90", "backward"}, {{"duration", "500ms"}});
  EXPECT_EQ(leg.parameter[0], 4);
  EXPECT_NEAR(leg.parameter[1], 90 * kDegree, 1e-12);
  EXPECT_EQ(leg.parameter[2], 0.5);
  EXPECT_EQ(leg.parameter[3], 0);
}

TEST(Commands, ModulesHaveNames) {
  EXPECT_EQ(read("reset", {"panel"}).parameter[0], 7);
  EXPECT_EQ(read("reset", {"all"}).parameter[0], 0);
  EXPECT_EQ(read("reset", {"controller"}).parameter[0], -1);
  EXPECT_EQ(read("reset", {"3"}).parameter[0], 3);
  EXPECT_EQ(refusal("leg", {"panel", "0"}).code(), ExitCode::usage);  // is no leg
}

TEST(Commands, EveryMistakeIsAUsageErrorThatSaysWhatIsPossible) {
  EXPECT_THAT(refusal("walk", {"forwrd"}).advice(), HasSubstr("forward"));
  EXPECT_THAT(refusal("walk", {}, {{"speed", "hihg"}}).advice(), HasSubstr("high"));
  EXPECT_THAT(refusal("walk", {}, {{"heading", "91"}}).advice(), HasSubstr("-90 deg to 90 deg"));
  EXPECT_THAT(refusal("leg", {"1"}).what(), HasSubstr("position"));
  EXPECT_EQ(refusal("leg", {"1.5", "0"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal("leg", {"7", "0"}).code(), ExitCode::usage);
  EXPECT_THAT(refusal("leg", {"XX", "0"}).what(), HasSubstr("'XX' is none of: LF, RF, LM"));
  EXPECT_THAT(refusal("reset", {"XX"}).advice(), HasSubstr("LH, RH, panel, all, controller"));
  EXPECT_EQ(refusal("panel", {}).code(), ExitCode::usage);
  EXPECT_EQ(refusal("panel", {"open"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal("stand", {"up"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal("stop", {"yes"}).code(), ExitCode::usage);  // yes to what?
  EXPECT_EQ(refusal("walk", {"forward", "backward"}).code(), ExitCode::usage);
  EXPECT_EQ(refusal("walk", {}, {{"heading", "nan"}}).code(), ExitCode::usage);
}

TEST(Commands, AnUnknownCommandSuggestsTheNearest) {
  try {
    find_command(zebro_built(), "stnad");
    FAIL() << "was found";
  } catch (const Failure& e) {
    EXPECT_EQ(e.code(), ExitCode::unknown_name);
    EXPECT_THAT(e.advice(), HasSubstr("stand"));
  }
}

TEST(Commands, EveryCommandOfTheTableIsDescribedWithAllItsParameters) {
  for (const CommandInfo* info : commands_of(zebro_built())) {
    const std::string text = describe(*info, zebro_built());
    EXPECT_THAT(text, HasSubstr(info->name));
    for (const ParameterInfo& p : info->parameters)
      EXPECT_THAT(text, HasSubstr(std::string("--") + p.name));
    const nlohmann::json document = to_json(*info, zebro_built());
    EXPECT_EQ(document["parameters"].size(), info->parameters.size());
    EXPECT_FALSE(document["allowed"].empty()) << "from the rows of the controller";
  }
}

TEST(Commands, SaysWhereACommandIsAllowedAndWhatItNeeds) {
  const std::string start = describe(find_command(zebro_built(), "start"), zebro_built());
  EXPECT_THAT(start, HasSubstr("in: Idle\n"));
  EXPECT_THAT(start, HasSubstr("all modules answer, the OBC sends heartbeats, the panel is in"));
  EXPECT_THAT(describe(find_command(zebro_built(), "walk"), zebro_built()),
              HasSubstr("in: Operational Standing, Walking\n"));
  EXPECT_THAT(describe(find_command(zebro_built(), "estop"), zebro_built()),
              HasSubstr("in: every state\n"));
}

// The state before a command decides which commands must precede it.
struct From {
  lss_State state;
  lss::zebro::Mode mode;
  const char* wanted;
  std::vector<std::string> first;
};

class Prepare : public testing::TestWithParam<From> {};

TEST_P(Prepare, DoesWhatMustComeFirst) {
  lss_Status status{};
  status.state = GetParam().state;
  status.mode = static_cast<std::uint8_t>(GetParam().mode);
  const Invocation wanted{&find_command(zebro_built(), GetParam().wanted), {}};
  std::vector<std::string> first;
  for (const Invocation& step : zebro_built().prepare(status, wanted))
    first.emplace_back(step.info->name);
  EXPECT_EQ(first, GetParam().first);
}

using lss::zebro::Mode;
INSTANTIATE_TEST_SUITE_P(
    Zebro, Prepare,
    testing::Values(From{lss_STATE_IDLE, Mode::none, "walk", {"start", "stand"}},
                    From{lss_STATE_IDLE, Mode::none, "stand", {"start"}},
                    From{lss_STATE_IDLE, Mode::none, "leg", {"start"}},
                    From{lss_STATE_IDLE, Mode::none, "stop", {}},
                    From{lss_STATE_IDLE, Mode::none, "panel", {}},
                    From{lss_STATE_IDLE, Mode::none, "start", {}},
                    From{lss_STATE_FATAL_ERROR, Mode::none, "walk", {}},
                    From{lss_STATE_OPERATIONAL, Mode::holding, "walk", {"stand"}},
                    From{lss_STATE_OPERATIONAL, Mode::standing, "walk", {}},
                    From{lss_STATE_OPERATIONAL, Mode::walking, "walk", {}},
                    From{lss_STATE_OPERATIONAL, Mode::standing_up, "walk", {"stand"}},
                    From{lss_STATE_OPERATIONAL, Mode::lying_down, "walk", {"lay-down", "stand"}},
                    From{lss_STATE_OPERATIONAL, Mode::stowing, "lay-down", {"stow"}},
                    From{lss_STATE_OPERATIONAL, Mode::standing_up, "stow", {"stand"}},
                    From{lss_STATE_OPERATIONAL, Mode::walking, "leg", {"stand"}}));

}  // namespace
}  // namespace lss::cli
