// Every failure of the Ardito thesis' section 19 in the closed loop: diagnosis, number of frames
// and reaction, compared with the thesis' own figures (19.2; 19.1 where marked).

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "idl/angles.h"
#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

using F = WheelFailure;

using Inject = void (*)(WheelFaults&);
void h_tm(WheelFaults& f) { f.hall = Broken::zero; }
void e_tm(WheelFaults& f) { f.motor_encoder = Broken::zero; }
void e_trg(WheelFaults& f) { f.reduction_encoder = Broken::zero; }
void tm(WheelFaults& f) { f.motor_blocked = true; }
void trg(WheelFaults& f) { f.reduction = true; }

struct Part {
  const char* name;
  Inject inject;
  F found;
  double thesis_s;  // detection
};
struct Row {
  std::vector<Part> parts;
  F state;              // latched in the end
  bool isolated;        // clutch open, motor stopped
  bool error;           // to the locomotion controller
  double mitigation_s;  // the thesis', after detection; 0: none needed
};

// The first to break, then the second or third.
const Part kHall{"H-TM", h_tm, F::motor_sensor, 0.1},
    kMotorEncoder{"E-TM", e_tm, F::motor_sensor, 0.1},
    kGearEncoder{"E-TRG", e_trg, F::reduction_encoder, 0.1}, kMotor{"TM", tm, F::motor, 0.1},
    kGear{"TRG", trg, F::reduction, 0.6}, kGearEncoderToo{"E-TRG", e_trg, F::two_sensors, 0.1},
    kMotorEncoderToo{"E-TM", e_tm, F::two_sensors, 0.2},
    kLastSensor{"E-TRG", e_trg, F::all_sensors, 0.1};

const std::vector<Row> kRows = {
    {{kHall}, F::motor_sensor, false, false, 0},
    {{kMotorEncoder}, F::motor_sensor, false, false, 0},
    {{kGearEncoder}, F::reduction_encoder, false, false, 0},
    {{kMotor}, F::motor, true, false, 0.5},
    {{kGear}, F::reduction, true, true, 0.5},
    {{kHall, kMotor}, F::motor, true, false, 1.2},
    {{kHall, kGear}, F::reduction, true, true, 0.5},
    {{kHall, kGearEncoderToo}, F::two_sensors, false, false, 0},
    {{kHall, kMotorEncoderToo}, F::two_sensors, false, false, 0},
    {{kMotorEncoder, kGearEncoderToo}, F::two_sensors, false, false, 0},
    {{kMotorEncoder, kMotor}, F::motor, true, false, 0.5},
    {{kMotorEncoder, kGear}, F::reduction, true, true, 0.5},
    {{kGearEncoder, kMotor}, F::motor, true, false, 0.6},
    {{kGearEncoder, kGear}, F::reduction, true, true, 0.5},
    {{kHall, kMotorEncoderToo, kLastSensor}, F::all_sensors, true, true, 0.3},
};

bool is_isolated(const Command& c, std::size_t wheel) {
  return !contains(c.clutches_engaged, wheel) && contains(c.motors_stopped, wheel);
}

struct Worst {
  std::vector<int> detection;  // frames
  int mitigation = 0;  // frames after detection until the clutch is open and the motor stopped
  int error = 0;       // frames after detection
};

void run_row(const Row& row, unsigned seed, std::size_t wheel, double speed, Worst& worst) {
  Rover rover = driving_rover(seed, speed);
  const auto others_are_fine = [&](const Command& c) {
    for (std::size_t i = 0; i < kWheels; ++i) {
      if (i != wheel && c.wheel_failure[i] != F::none) return false;
    }
    return true;
  };
  worst.detection.resize(row.parts.size());
  for (std::size_t n = 0; n < row.parts.size(); ++n) {
    if (n > 0) rover.run(2);
    row.parts[n].inject(rover.wheel_faults[wheel]);
    const int frames = frames_until(
        rover, 30, [&](const Command& c) { return c.wheel_suspect[wheel] == row.parts[n].found; });
    worst.detection[n] = std::max(worst.detection[n], frames);
  }
  if (row.isolated) {
    const int frames =
        is_isolated(rover.command, wheel)
            ? 0
            : frames_until(rover, 30, [&](auto& c) { return is_isolated(c, wheel); });
    worst.mitigation = std::max(worst.mitigation, frames);
    if (row.error) {
      worst.error = std::max(
          worst.error, frames + frames_until(rover, 30, [](auto& c) { return c.error == 1; }));
    }
  }
  rover.run(3);
  EXPECT_EQ(rover.command.wheel_failure[wheel], row.state);
  EXPECT_EQ(is_isolated(rover.command, wheel), row.isolated);
  EXPECT_EQ(rover.command.error, row.error ? 1U : 0U);
  EXPECT_TRUE(others_are_fine(rover.command)) << "wheel " << wheel << " seed " << seed;
  // five wheels drive on; an error stops the rover
  EXPECT_EQ(rover.command.mode, row.error ? Mode::stop : Mode::running);
  if (!row.error) {
    EXPECT_NEAR(std::abs(rover.true_speed_m_s()), std::abs(speed), 0.08);
  }
}

TEST(Failures, EachRowOfTheThesisIsNoLaterThanTheThesis) {
  std::printf("%-22s %-22s %-18s mitigation, error after\n", "failure", "frames until found",
              "thesis, s");
  for (const Row& row : kRows) {
    std::string name, thesis;
    for (const Part& part : row.parts) {
      name += (name.empty() ? "" : " + ") + std::string(part.name);
      char text[16];
      std::snprintf(text, sizeof text, "%s%.1f", thesis.empty() ? "" : " + ", part.thesis_s);
      thesis += text;
    }
    SCOPED_TRACE(name);
    Worst worst;
    for (unsigned seed = 1; seed <= 3; ++seed) {
      for (std::size_t wheel = 0; wheel < kWheels; ++wheel) {
        run_row(row, seed, wheel, 0.6, worst);
        run_row(row, seed, wheel, -0.5, worst);
      }
    }
    std::string frames;
    for (std::size_t n = 0; n < row.parts.size(); ++n) {
      frames += (n > 0 ? " + " : "") + std::to_string(worst.detection[n]);
      EXPECT_LE(worst.detection[n] * kFrame_s, row.parts[n].thesis_s + 1e-9) << row.parts[n].name;
    }
    EXPECT_LE(worst.mitigation * kFrame_s, row.mitigation_s + 1e-9);
    std::printf("%-22s %-22s %-18s %d (thesis %.1f s), %d\n", name.c_str(), frames.c_str(),
                thesis.c_str(), worst.mitigation, row.mitigation_s, worst.error);
  }
}

TEST(Failures, ASensorThatStandsStillIsFoundWhenTheSpeedChanges) {
  for (const auto member :
       {&WheelFaults::motor_encoder, &WheelFaults::hall, &WheelFaults::reduction_encoder}) {
    Rover rover = driving_rover(4, 0.3);
    rover.wheel_faults[3].*member = Broken::stuck;
    rover.run(3);
    EXPECT_EQ(rover.command.wheel_failure[3], F::none);
    rover.request.speed = 0.8;
    rover.run(5);
    const F expected =
        member == &WheelFaults::reduction_encoder ? F::reduction_encoder : F::motor_sensor;
    EXPECT_EQ(rover.command.wheel_failure[3], expected);
    EXPECT_EQ(rover.command.clutches_engaged, kAllWheels);
    EXPECT_NEAR(rover.true_speed_m_s(), 0.8, 0.05);
  }
}

TEST(Failures, FoundInCurvesAndOnTheSpotToo) {
  for (const bool parking : {true, false}) {
    for (const auto& [inject, found] :
         std::vector<std::pair<Inject, F>>{{h_tm, F::motor_sensor}, {tm, F::motor}}) {
      Rover rover(3);
      rover.request.run = true;
      rover.request.speed = 1;
      rover.request.sigma_rad = 4 * kDegree;
      rover.request.parking = parking;
      ASSERT_TRUE(rover.settle(30));
      rover.run(3);
      inject(rover.wheel_faults[4]);
      EXPECT_LE(frames_until(rover, 20, [&](auto& c) { return c.wheel_failure[4] == found; }), 6);
      EXPECT_EQ(rover.command.error, 0U);
    }
  }
}

// The rover against a wall: all wheels stall. No motor has failed.
TEST(Failures, WhenAllWheelsStallNoMotorIsBlamed) {
  Rover rover = driving_rover(2, 0.6);
  for (WheelFaults& f : rover.wheel_faults) f.motor_blocked = true;
  rover.run(5);
  EXPECT_EQ(rover.command.wheel_suspect[0], F::motor);
  EXPECT_EQ(rover.command.clutches_engaged, kAllWheels);
}

TEST(Failures, RetryClosesTheClutchAgainAndTheWheelDrives) {
  Rover rover = driving_rover(2, 0.6);
  rover.wheel_faults[1].motor_blocked = true;
  rover.run(2);
  ASSERT_TRUE(is_isolated(rover.command, 1));
  rover.wheel_faults[1] = {};
  rover.run(2);
  EXPECT_TRUE(is_isolated(rover.command, 1));  // latched: nothing heals by itself
  rover.request.retry_wheels = only(1);
  rover.step();
  rover.request.retry_wheels = 0;
  rover.run(4);
  EXPECT_EQ(rover.command.wheel_failure[1], F::none);
  EXPECT_EQ(rover.command.clutches_engaged, kAllWheels);
  EXPECT_NEAR(rover.command.wheel_rad_s[1], 4, 0.3);
}

TEST(Failures, AcceptedWheelRaisesNoErrorAndThreeLostOnesDo) {
  Rover rover = driving_rover(2, 0.6);
  trg(rover.wheel_faults[5]);
  rover.run(3);
  ASSERT_EQ(rover.command.error, 1U);
  rover.request.accept_lost_wheels = only(5);
  rover.run(8);
  EXPECT_EQ(rover.command.error, 0U);
  EXPECT_EQ(rover.command.mode, Mode::running);
  EXPECT_NEAR(rover.true_speed_m_s(), 0.6, 0.06);
  tm(rover.wheel_faults[0]);
  rover.run(2);
  EXPECT_EQ(rover.command.error, 0U);
  tm(rover.wheel_faults[3]);
  rover.run(2);
  EXPECT_EQ(rover.command.error, 1U);
  EXPECT_NE(rover.command.faults & kTooFewWheels, 0U);
}

TEST(Failures, WithoutPowerNothingIsConcluded) {
  Rover rover = driving_rover(2, 0.6);
  rover.request.powered = false;
  for (WheelFaults& f : rover.wheel_faults) f.motor_dead = true;
  rover.run(5);
  for (std::size_t i = 0; i < kWheels; ++i) EXPECT_EQ(rover.command.wheel_failure[i], F::none);
  EXPECT_EQ(rover.command.clutches_engaged, kAllWheels);
  EXPECT_EQ(rover.command.mode, Mode::stop);
}

// E20: printed, states 5, 6 and the default close clutches that 3, 4 or 8 opened.
RC_GTEST_PROP(Failures, WhatWasLatchedStaysLatched, ()) {
  Rover rover(static_cast<unsigned>(*rc::gen::inRange(0, 1000000)));
  rover.request.run = true;
  rover.request.speed = 0.6;
  rover.settle();
  WheelSet open = 0, stopped = 0;
  PerWheel<std::uint32_t> sensors{};
  PerSteered<std::uint32_t> encoders{};
  for (int n = 0; n < 12; ++n) {
    WheelFaults& f = rover.wheel_faults[*rc::gen::inRange<std::size_t>(0, kWheels)];
    SteeringFaults& s = rover.steering_faults[*rc::gen::inRange<std::size_t>(0, kSteered)];
    switch (*rc::gen::inRange(0, 9)) {
      case 0: f.hall = *rc::gen::element(Broken::no, Broken::zero, Broken::stuck); break;
      case 1: f.motor_encoder = *rc::gen::element(Broken::no, Broken::zero, Broken::stuck); break;
      case 2: f.reduction_encoder = *rc::gen::element(Broken::no, Broken::zero); break;
      case 3: f.motor_blocked = !f.motor_blocked; break;
      case 4: f.reduction = !f.reduction; break;
      case 5: f.clutch = !f.clutch; break;
      case 6: s.motor_encoder = *rc::gen::element(Broken::no, Broken::stuck); break;
      case 7: s.motor = !s.motor; break;
      default: rover.request.speed = *rc::gen::inRange(-10, 11) * 0.1; break;
    }
    for (int frame = 0; frame < 15; ++frame) {
      rover.step();
      const Command& c = rover.command;
      RC_ASSERT((c.clutches_engaged & open) == 0U);
      RC_ASSERT((c.motors_stopped & stopped) == stopped);
      RC_ASSERT((c.motors_stopped & c.clutches_engaged) == 0U);
      open = kAllWheels & ~c.clutches_engaged;
      stopped = c.motors_stopped;
      for (std::size_t i = 0; i < kWheels; ++i) {
        RC_ASSERT((c.sensors_lost[i] & sensors[i]) == sensors[i]);
        sensors[i] = c.sensors_lost[i];
        if (contains(stopped, i)) RC_ASSERT(c.wheel_rad_s[i] == 0);
      }
      for (std::size_t i = 0; i < kSteered; ++i) {
        RC_ASSERT((c.encoders_lost[i] & encoders[i]) == encoders[i]);
        encoders[i] = c.encoders_lost[i];
      }
    }
  }
}

}  // namespace
}  // namespace lss::gnc::ardito::test
