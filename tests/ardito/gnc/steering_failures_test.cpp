// Failures of steering systems (Ardito thesis 19) in the closed loop, beside the thesis' figures.

#include <gtest/gtest.h>

#include <functional>
#include <vector>

#include "idl/angles.h"
#include "tests/ardito/gnc/rover.h"

namespace lss::gnc::ardito::test {
namespace {

// Found when the steering moves, so the clock starts with a turn of the wheels.
struct SteeringRow {
  const char* name;
  std::vector<void (*)(SteeringFaults&)> inject;
  SteeringFailure state;
  std::vector<double> thesis_s;
  bool error;
};
void sm(SteeringFaults& f) { f.motor = true; }
void e_sm(SteeringFaults& f) { f.motor_encoder = Broken::stuck; }
void e_srg(SteeringFaults& f) { f.reduction_encoder = Broken::stuck; }

TEST(SteeringFailures, EachRowOfTheThesisIsNoLaterThanTheThesis) {
  using S = SteeringFailure;
  const std::vector<SteeringRow> rows = {
      {"SM or SRG", {sm}, S::critical, {1.0}, true},
      {"E-SM", {e_sm}, S::motor_encoder, {3.4}, false},
      {"E-SRG", {e_srg}, S::reduction_encoder, {3.8}, false},
      {"E-SM + E-SRG", {e_sm, e_srg}, S::both_encoders, {3.3, 0.9}, true},
      {"E-SM + SM", {e_sm, sm}, S::both_encoders, {5.7, 1.9}, true},
      {"E-SRG + SM", {e_srg, sm}, S::both_encoders, {3.9, 0.9}, true},
  };
  std::printf("%-16s frames until found, thesis s; error after\n", "steering");
  for (const SteeringRow& row : rows) {
    SCOPED_TRACE(row.name);
    std::vector<int> worst(row.inject.size(), 0);
    int error = 0;
    for (std::size_t steered = 0; steered < kSteered; ++steered) {
      for (unsigned seed = 1; seed <= 3; ++seed) {
        Rover rover = driving_rover(seed, 0.5, -3);
        double sigma = 3;
        for (std::size_t n = 0; n < row.inject.size(); ++n) {
          row.inject[n](rover.steering_faults[steered]);
          rover.request.sigma_rad = sigma * kDegree;
          sigma = -sigma;
          const S before = rover.command.steering_failure[steered];
          worst[n] = std::max(worst[n], frames_until(rover, 60, [&](const Command& c) {
                                return c.steering_suspect[steered] > before;
                              }));
          if (n + 1 < row.inject.size()) rover.run(4);
        }
        if (row.error) {
          error = std::max(error, frames_until(rover, 30, [](auto& c) { return c.error == 1; }));
        }
        rover.run(2);
        EXPECT_EQ(rover.command.steering_failure[steered], row.state);
        EXPECT_EQ(rover.command.error, row.error ? 1U : 0U);
        for (std::size_t i = 0; i < kSteered; ++i) {
          if (i != steered) {
            EXPECT_EQ(rover.command.steering_failure[i], S::none);
          }
        }
      }
    }
    std::printf("%-16s", row.name);
    for (std::size_t n = 0; n < worst.size(); ++n) {
      std::printf(" %d (%.1f)", worst[n], row.thesis_s[n]);
      EXPECT_LE(worst[n] * kFrame_s, row.thesis_s[n]);
    }
    std::printf("; %d\n", error);
    EXPECT_LE(error, 5);
  }
}

TEST(SteeringFailures, AWheelWithOneEncoderIsSteeredOnWithTheOther) {
  for (const auto inject : {e_sm, e_srg}) {
    Rover rover = driving_rover(5, 0.5);
    inject(rover.steering_faults[2]);
    for (const double sigma_deg : {3.0, -4.0, 2.0}) {
      rover.request.sigma_rad = sigma_deg * kDegree;
      rover.run(6);
      const PlaneWheels wanted = ackermann({direction(sigma_deg * kDegree), 1}, Geometry{});
      EXPECT_NEAR(rover.true_steering_rad()[2], wanted.steering_rad[4], 0.02);
    }
    EXPECT_EQ(rover.command.error, 0U);
  }
}

}  // namespace
}  // namespace lss::gnc::ardito::test
