// The cycle allocates nothing, and the same inputs give the same bits.

#include <gtest/gtest.h>

#include "daemon/vehicles/talaris/record.h"
#include "tests/support/allocations.h"
#include "world.h"

namespace lss::talaris {
namespace {

// The inputs of a hop from Idle to landing, with a script before it.
std::vector<lss::Inputs<Vehicle>> hop() {
  std::vector<lss::Inputs<Vehicle>> frames;
  World w;
  w.distort = [&](auto&) {};
  const auto keep = [&] {
    frames.push_back(w.in_);
    return false;
  };
  w.run_until(keep, 1);
  w.send(lss::CommandKind::start);
  w.run_until(keep, 1);
  w.send(CommandKind::script_begin, {1, 1});
  w.send(CommandKind::script_step, {1, 0, 0, 0, 3, 0.3});
  w.send(CommandKind::script_run, {1});
  w.run_until(keep, 7);
  w.send(CommandKind::edf_arm, {0});
  w.run_until(keep, 1);
  w.send(CommandKind::gnc, {0});
  w.run_until(keep, 0.2);
  w.send(CommandKind::gnc, {1});
  w.run_until(keep, 6);
  w.send(CommandKind::plan, {0, 2, 5, 0, 0});
  w.send(CommandKind::gnc, {2});
  w.run_until(keep, 30);
  EXPECT_NE(w.heard(EventId::landed), nullptr);
  return frames;
}

std::vector<std::uint8_t> bytes_of(const Vehicle::Command& command,
                                   const Vehicle::Telemetry& telemetry,
                                   const SupervisorState& state) {
  std::vector<std::uint8_t> bytes(65536);
  record::Writer writer(bytes);
  fields(writer, command);
  fields(writer, telemetry);
  fields(writer, state);
  EXPECT_TRUE(writer.fits());
  bytes.resize(writer.size());
  return bytes;
}

TEST(TalarisRealtime, TheCycleAllocatesNothing) {
  const auto frames = hop();
  Vehicle vehicle(quick());
  Supervisor supervisor(logic(), {});
  Outputs<Vehicle> out;
  const std::uint64_t before = testing_support::allocations();
  for (const auto& in : frames) cycle(vehicle, supervisor, in, out, [](Stage) {});
  EXPECT_EQ(testing_support::allocations(), before);
  EXPECT_EQ(Mode{out.telemetry.mode}, Mode::standby);
}

TEST(TalarisRealtime, TheSameInputsGiveTheSameBits) {
  const auto frames = hop();
  Vehicle a(quick()), b(quick());
  Supervisor sa(logic(), {}), sb(logic(), {});
  Outputs<Vehicle> oa, ob;
  for (const auto& in : frames) {
    cycle(a, sa, in, oa, [](Stage) {});
    cycle(b, sb, in, ob, [](Stage) {});
    ASSERT_EQ(bytes_of(oa.command, oa.telemetry, sa.state()),
              bytes_of(ob.command, ob.telemetry, sb.state()))
        << in.frame;
  }
}

}  // namespace
}  // namespace lss::talaris
