// The failure that the Ardito thesis could not find: a clutch that transmits nothing, found by the
// current of its motor (part VII) and proven by a probe.

#include <gtest/gtest.h>

#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

int frames_until_isolated(Rover& rover, std::size_t wheel, int most) {
  return frames_until(rover, most,
                      [&](const Command& c) { return contains(c.motors_stopped, wheel); });
}

struct Row {
  const char* name;
  void (*inject)(WheelFaults&);
  WheelFailure state;
  int most;  // frames; the thesis: 4.8 s TC, 1.6 s H-TM + TC (19.1), the others not at all
};

TEST(Clutch, IsFoundAlsoWithFailedSensors) {
  const Row rows[] = {
      {"TC", [](WheelFaults&) {}, WheelFailure::clutch, 16},
      {"H-TM + TC", [](WheelFaults& f) { f.hall = Broken::zero; }, WheelFailure::clutch_and_sensor,
       16},
      {"E-TM + TC", [](WheelFaults& f) { f.motor_encoder = Broken::zero; },
       WheelFailure::clutch_and_sensor, 16},
      {"E-TRG + TC", [](WheelFaults& f) { f.reduction_encoder = Broken::zero; },
       WheelFailure::clutch, 26},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    int worst = 0, worst_other = 0;
    for (unsigned seed = 1; seed <= 20; ++seed) {
      const std::size_t wheel = seed % kWheels;
      Rover rover = driving_rover(seed, seed % 2 == 0 ? 0.7 : -0.4);
      row.inject(rover.wheel_faults[wheel]);
      rover.run(2);
      while (rover.command.probing != 0) rover.step();
      rover.wheel_faults[wheel].clutch = true;
      const int frames = frames_until_isolated(rover, wheel, 100);
      // a wheel that was just probed is left alone for a while
      (frames <= row.most ? worst : worst_other) =
          std::max(frames, frames <= row.most ? worst : worst_other);
      EXPECT_EQ(rover.command.wheel_failure[wheel], row.state);
      rover.run(3);
      EXPECT_EQ(rover.command.error, 0U);
      EXPECT_EQ(rover.command.mode, Mode::running);
      EXPECT_EQ(rover.command.motors_stopped, only(wheel));
    }
    std::printf("%-12s %d frames; %d with a pause after a probe\n", row.name, worst, worst_other);
    EXPECT_LE(worst_other, row.most + 4);
  }
}

TEST(Clutch, ThenAStuckWheelIsFoundToo) {
  Rover rover = driving_rover(2, 0.7);
  rover.wheel_faults[4].clutch = true;
  ASSERT_LE(frames_until_isolated(rover, 4, 60), 60);
  rover.run(1);
  rover.wheel_faults[4].reduction = true;
  rover.step();
  EXPECT_EQ(rover.command.wheel_suspect[4], WheelFailure::reduction);
  rover.run(0.6);
  EXPECT_EQ(rover.command.wheel_failure[4], WheelFailure::reduction);
  EXPECT_EQ(rover.command.error, 1U);
}

TEST(Clutch, AMotorWithoutTorqueThatIsDraggedAlongIsAMotorFailure) {
  for (unsigned seed = 1; seed <= 6; ++seed) {
    Rover rover = driving_rover(seed, 0.7);
    while (rover.command.probing != 0) rover.step();
    rover.wheel_faults[2].motor_dead = true;
    EXPECT_LE(frames_until_isolated(rover, 2, 80), 20);
    EXPECT_EQ(rover.command.wheel_failure[2], WheelFailure::motor);
    rover.run(1);
    EXPECT_EQ(rover.command.error, 0U);
  }
}

// A wheel in the air also runs at no load; its clutch is closed and must stay so.
TEST(Clutch, AWheelInTheAirIsProbedAndKept) {
  Parameters parameters;
  parameters.probe_pause_frames = 10;
  Rover rover(3, parameters);
  rover.noise.load = 0;
  rover.drive_load = 0;
  rover.request.run = true;
  rover.request.speed = 0.7;
  ASSERT_TRUE(rover.settle(30));
  rover.run(5);
  EXPECT_EQ(rover.command.probing, 0U);  // no wheel is loaded: no conclusion is possible
  int probes = 0;
  rover.tamper = [](Measured& m) {  // the others work
    for (std::size_t i = 1; i < kWheels; ++i) m.wheels[i].current.value += 0.3;
  };
  for (int n = 0; n < 300; ++n) {
    rover.step();
    if (rover.command.probing != 0) ++probes;
    ASSERT_EQ(rover.command.clutches_engaged, kAllWheels);
  }
  EXPECT_GT(probes, 50);
}

TEST(Clutch, AProbeIsNeverFasterThanAsked) {
  const Parameters p;
  EXPECT_NEAR(probe_speed_rad_s(5, p), 4, 1e-12);
  EXPECT_NEAR(probe_speed_rad_s(-5, p), -4, 1e-12);
  EXPECT_NEAR(probe_speed_rad_s(0.5, p), 0.5 - p.probe_rad_s, 1e-12);
  EXPECT_EQ(probe_speed_rad_s(0.1, p), 0);
}

}  // namespace
}  // namespace lss::gnc::ardito::test
