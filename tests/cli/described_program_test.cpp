// A vehicle that lss-cli was built without, beside those that it was built with: against a stand-in
// for the daemon, which describes Lunar Zebro under another name and with another walk.

#include "tests/cli/program_test.h"
#include "tests/cli/strider.h"

namespace lss::cli::test {
namespace {

class DescribedProgram : public ProgramTest {
 protected:
  FakeDaemon daemon_{domain(), strider()};
};

TEST_F(DescribedProgram, HasTheVerbsAndParametersOfItsDictionary) {
  const Ended ended = run({"stride", "--length", "0.3", "--for", "300ms"});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(daemon_.kinds(), ElementsAre(kStart, kWalk, kStop));
  EXPECT_DOUBLE_EQ(daemon_.last(kWalk).parameter[1], 0.3);
  EXPECT_THAT(ended.out, HasSubstr("stride forward length 0.3 m"));

  const Ended help = run({"stride", "--help"});
  EXPECT_EQ(help.code, 0) << help.err;
  EXPECT_THAT(help.out, HasSubstr("--length"));
  EXPECT_THAT(help.out, HasSubstr("--for"));
  EXPECT_THAT(help.out, Not(HasSubstr("--stay")));

  const Ended far = run({"stride", "--length", "2"});
  EXPECT_EQ(far.code, 2);
  EXPECT_THAT(far.err, HasSubstr("stride --length: 2 m is out of range"));
  EXPECT_THAT(far.err, HasSubstr("0.1 m to 0.5 m"));
}

TEST_F(DescribedProgram, HasNoVerbsOfOtherVehicles) {
  const Ended walk = run({"walk", "--heading", "200"});
  EXPECT_EQ(walk.code, 4);
  EXPECT_THAT(walk.err, HasSubstr("there is no verb 'walk'"));
  EXPECT_THAT(run({"walk"}).err, HasSubstr("strider has no command 'walk'"));
  EXPECT_THAT(run({"strde"}).err, HasSubstr("did you mean stride?"));
  EXPECT_THAT(run({"command", "describe", "strde"}).err, HasSubstr("did you mean stride?"));
  EXPECT_EQ(run({"run", "-e", "start; strde"}).code, 4);
  EXPECT_TRUE(daemon_.kinds().empty());
}

TEST_F(DescribedProgram, ShowsItsStatusAndIsStopped) {
  const json status = json::parse(run({"--json", "status"}).out);
  EXPECT_EQ(status["vehicle"], "strider");
  EXPECT_EQ(status["telemetry"]["modules"][2]["temperature_degC"], 21.5);
  EXPECT_EQ(status["telemetry"]["state"], "Idle");
  EXPECT_EQ(run({"health"}).code, 0);
  EXPECT_THAT(run({"data"}).out, HasSubstr("temperature"));
  EXPECT_EQ(run({"run", "-e", "start; stride backward; wait 200ms; stop"}).code, 0);
  EXPECT_THAT(run({"shell"}, "start\nstride --length 0.5 --for 100ms\nstop\n").err,
              Not(HasSubstr("no verb")));
  EXPECT_EQ(run({"estop", "strider-1"}).code, 0);
  EXPECT_EQ(daemon_.state(), lss_STATE_FATAL_ERROR);
}

TEST_F(DescribedProgram, WithoutADictionaryThatCanBeReadSaysWhatToDo) {
  const FakeDaemon other(domain(),
                         Birth{.vehicle_id = "crane-1", .vehicle = "crane", .dictionary = "{}"});
  const Ended ended = run({"--vehicle", "crane-1", "status"});
  EXPECT_EQ(ended.code, 4);
  EXPECT_THAT(ended.err, HasSubstr("crane-1 is of the type 'crane'"));
  EXPECT_THAT(ended.err, HasSubstr("cannot be read"));
}

}  // namespace
}  // namespace lss::cli::test
