// A vehicle made of the shared parts, the example scout, driven by the daemon's CANopen master over
// a paced bus in virtual time: two programs written from one contract understand one another.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "drivers/canopen/master.h"
#include "tools/lss-sim/canopen/wire.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss::sim {

std::unique_ptr<VehicleKind> make_scout_kind();

namespace {

using canopen::DriveState;
using canopen::NodeState;

constexpr double kRpm_m_s = 2 * std::numbers::pi / 60 / 50 * 0.10;  // of the motor, to the tread

canopen::NodeParameters drive(std::uint8_t node) {
  return {node,
          0x0002'0192,
          {{{0x1015, 0, 2, 100},
            {0x1029, 1, 1, 0},
            {0x6007, 0, 2, 3},
            {0x605A, 0, 2, 6},
            {0x6060, 0, 1, 3},
            {0x6083, 0, 4, 8000},
            {0x6084, 0, 4, 8000},
            {0x6085, 0, 4, 8000}}},
          {{{1, canopen::kEvent, 0, 0, {0x6040'0010, 0x60FF'0020}}}},
          {{{1, canopen::kOnSync, 0, 0, {0x6041'0010, 0x606C'0020, 0x6078'0010}}}}};
}

canopen::MasterParameters both_drives() {
  canopen::MasterParameters parameters;
  parameters.nodes[0] = drive(1);
  parameters.nodes[1] = drive(2);
  return parameters;
}

// The vehicle and a master that leads each drive to operation enabled, one step a cycle of 100 ms.
class World {
 public:
  explicit World(unsigned seed = 1) : vehicle_(make_scout_kind()->make(seed)) {
    master_.restart(now_, now_);
  }

  void run(double seconds) {
    const TimeNs end = now_ + static_cast<TimeNs>(seconds * kSecond);
    for (; now_ < end; now_ += kMillisecond) {
      if (now_ % (100 * kMillisecond) == 0) order();
      vehicle_->step();
      exchange();
    }
  }
  void inject(const char* text, bool attach = true) {
    const auto fault = parse_fault(text, kinds_);
    ASSERT_TRUE(fault) << fault.error();
    vehicle_->set_fault(*fault, attach);
  }
  void drive_at(double left_m_s, double right_m_s) {
    rpm = {std::lround(left_m_s / kRpm_m_s), std::lround(right_m_s / kRpm_m_s)};
  }

  const canopen::NodeStatus& status(std::size_t node) const { return master_.status(node); }
  DriveState state(std::size_t node) const { return canopen::drive_state(statusword[node]); }
  double truth(const char* key, std::size_t i) const {
    return vehicle_->truth().at(key).at(i).get<double>();
  }
  std::string power(std::size_t node) const { return vehicle_->truth().at("power").at(node); }
  std::string all_truth() const { return vehicle_->truth().dump(); }
  Vehicle& vehicle() { return *vehicle_; }
  const std::vector<FaultKind>& kinds() const { return kinds_; }

  std::array<std::int64_t, 2> rpm{};  // orders
  bool speaking = true;
  std::array<std::optional<std::uint16_t>, 2> controlword;  // instead of the way to enabled
  std::array<std::uint16_t, 2> statusword{};
  std::array<double, 2> said_rpm{}, said_per_mille{};

 private:
  void order() {
    for (std::size_t i = 0; i < 2; ++i) {
      const std::uint16_t control = controlword[i].value_or(canopen::towards_enabled(state(i)));
      std::array<std::uint8_t, 6> data;
      nodes::to_little_endian(control, std::span(data).first(2));
      nodes::to_little_endian(static_cast<std::uint32_t>(rpm[i]), std::span(data).subspan(2));
      master_.send_rpdo(i, 1, data);
    }
  }
  void exchange() {
    for (TimeNs t = now_; t < now_ + kMillisecond; t += 100 * kMicrosecond) {
      CanFrame frame;
      while (speaking && master_.transmit(t, frame)) bus_.from_master(frame, t);
      bus_.advance(t);
      for (CanFrame heard : bus_.take(t)) {
        heard.time_ns = t;
        master_.receive(heard);
      }
      for (canopen::PdoSample sample; master_.take(sample);) keep(sample);
    }
  }
  void keep(const canopen::PdoSample& sample) {
    const std::span data(sample.data);
    statusword.at(sample.node) = static_cast<std::uint16_t>(nodes::little_endian(data.first(2)));
    said_rpm.at(sample.node) =
        static_cast<double>(nodes::to_signed(nodes::little_endian(data.subspan(2, 4)), 4));
    said_per_mille.at(sample.node) =
        static_cast<double>(nodes::to_signed(nodes::little_endian(data.subspan(6, 2)), 2));
  }

  TimeNs now_ = 10 * kSecond;
  std::unique_ptr<VehicleKind> kind_ = make_scout_kind();
  std::vector<FaultKind> kinds_ = fault_kinds_of(*kind_);
  std::unique_ptr<Vehicle> vehicle_;
  CanBus bus_{{.paced = true}, *vehicle_->can_buses().front().device};
  canopen::Master master_{both_drives()};
};

class Scout : public testing::Test {
 protected:
  void enable() {
    world_.run(2);
    for (const std::size_t i : {0u, 1u}) {
      ASSERT_EQ(world_.status(i).state, NodeState::operational) << i;
      ASSERT_EQ(world_.state(i), DriveState::operation_enabled) << i;
    }
  }
  void enable_and_drive(double left_m_s, double right_m_s) {
    enable();
    world_.drive_at(left_m_s, right_m_s);
    world_.run(1.5);
  }

  World world_;
};

TEST_F(Scout, BothDrivesBootAreConfiguredAndEnabled) {
  enable();
  EXPECT_EQ(world_.power(0), "enabled");
  EXPECT_EQ(world_.power(1), "enabled");
  EXPECT_EQ(world_.status(0).found_type, 0x0002'0192u);
  EXPECT_EQ(world_.status(0).emcys, 0u);
}

TEST_F(Scout, DrivesAheadAtTheOrderedSpeedAndSaysSo) {
  enable_and_drive(0.3, 0.3);
  const double from_m = world_.truth("position_m", 0);
  world_.run(2);
  EXPECT_NEAR(world_.truth("position_m", 0) - from_m, 0.6, 0.005);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0.3, 0.001);
  EXPECT_NEAR(world_.truth("wheel_rad_s", 0), 3, 0.01);
  for (const std::size_t i : {0u, 1u}) {
    EXPECT_NEAR(world_.said_rpm[i], 0.3 / kRpm_m_s, 12);
    EXPECT_NEAR(world_.said_per_mille[i], 120, 25);
  }
}

TEST_F(Scout, TurnsToTheLeftWhenTheRightWheelIsFaster) {
  enable_and_drive(-0.1, 0.1);
  world_.run(1);
  EXPECT_NEAR(world_.truth("position_m", 0), 0, 1e-3);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0, 1e-6);
  EXPECT_LT(world_.said_rpm[0], -400);
  // Half a radian a second, from about 0.1 s on.
  const double yaw_rad =
      2 * std::atan2(world_.truth("attitude_wxyz", 3), world_.truth("attitude_wxyz", 0));
  EXPECT_NEAR(yaw_rad, 0.5 * 2.4, 0.05);
}

TEST_F(Scout, ALostMasterStopsBothWheelsByTheirRamps) {
  enable_and_drive(0.5, 0.5);
  world_.speaking = false;
  world_.run(0.15);
  EXPECT_GT(world_.truth("velocity_m_s", 0), 0.49);
  world_.run(1);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0, 1e-3);
  EXPECT_EQ(world_.power(0), "quick stop");
  EXPECT_EQ(world_.power(1), "quick stop");
  world_.speaking = true;
  world_.drive_at(0, 0);
  world_.run(0.5);
  EXPECT_EQ(world_.status(0).emcy_code, 0u) << "the heartbeat is back";
  EXPECT_GE(world_.status(0).emcys, 2u) << "0x8130 and its end";
  world_.run(2);
  EXPECT_EQ(world_.state(0), DriveState::operation_enabled);
}

TEST_F(Scout, AQuickStopHoldsUntilItIsLeft) {
  enable_and_drive(0.5, 0.5);
  world_.controlword = {canopen::kQuickStop, canopen::kQuickStop};
  world_.run(1);
  EXPECT_EQ(world_.state(1), DriveState::quick_stop_active);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0, 1e-3);
  world_.drive_at(0.2, 0.2);
  world_.controlword = {};
  world_.run(2);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0.2, 1e-3);
}

TEST_F(Scout, AnErrorIsReportedAndItsEnd) {
  enable();
  world_.inject("emcy:0x02:0x4310");
  world_.run(0.1);
  EXPECT_EQ(world_.status(1).emcy_code, 0x4310);
  EXPECT_EQ(world_.status(1).emcy_register, 0x09);
  EXPECT_EQ(world_.status(0).emcys, 0u);
  world_.inject("emcy:0x02:0x4310", false);
  world_.run(0.1);
  EXPECT_EQ(world_.status(1).emcy_code, 0);
}

TEST_F(Scout, AFaultStopsItsDriveUntilTheRisingEdgeOfFaultReset) {
  enable_and_drive(0.3, 0.3);
  world_.inject("drive-fault:0x01");
  world_.run(0.5);
  EXPECT_EQ(world_.state(0), DriveState::fault);
  EXPECT_EQ(world_.state(1), DriveState::operation_enabled);
  EXPECT_EQ(world_.status(0).emcy_code, 0x2310);
  EXPECT_EQ(world_.power(0), "fault");
  EXPECT_NEAR(world_.truth("wheel_rad_s", 0), 0, 1e-2);
  world_.drive_at(0, 0);
  world_.controlword[0] = canopen::kFaultReset;
  world_.run(0.2);
  EXPECT_EQ(world_.state(0), DriveState::switch_on_disabled);
  world_.controlword[0] = {};
  world_.run(0.5);
  EXPECT_EQ(world_.state(0), DriveState::operation_enabled);
}

TEST_F(Scout, ABlockedWheelStandsAndItsCurrentRises) {
  enable_and_drive(0.3, 0.3);
  world_.inject("wheel-blocked:left");
  world_.run(1);
  EXPECT_NEAR(world_.said_rpm[0], 0, 3);
  EXPECT_NEAR(world_.said_per_mille[0], 1500, 25);
  EXPECT_NEAR(world_.said_rpm[1], 0.3 / kRpm_m_s, 12);
  EXPECT_NEAR(world_.truth("velocity_m_s", 0), 0.15 * std::cos(0.75), 0.08) << "it turns";
  world_.inject("wheel-blocked:left", false);
  world_.run(1);
  EXPECT_NEAR(world_.said_rpm[0], 0.3 / kRpm_m_s, 12);
}

TEST_F(Scout, ASilentNodeIsLostAndStopsByItself) {
  enable_and_drive(0.3, 0.3);
  world_.inject("node-silent:0x02");
  world_.run(1.5);
  EXPECT_NE(world_.status(1).state, NodeState::operational);
  EXPECT_NEAR(world_.truth("wheel_rad_s", 1), 0, 1e-2);
  EXPECT_NEAR(world_.truth("wheel_rad_s", 0), 3, 1e-2);
}

TEST_F(Scout, AnotherDeviceAndARefusedConfigurationAreKnown) {
  world_.inject("wrong-device-type:0x01");
  world_.inject("sdo-abort:0x02:0x08000022");
  world_.run(2);
  EXPECT_EQ(world_.status(0).state, NodeState::wrong_device);
  EXPECT_EQ(world_.status(1).abort_code, 0x0800'0022u);
}

TEST_F(Scout, ABabblingNodeDoesNotSilenceTheOther) {
  enable_and_drive(0.3, 0.3);
  world_.inject("babble:0x01");
  world_.run(0.5);
  EXPECT_EQ(world_.status(0).state, NodeState::babbling);
  EXPECT_EQ(world_.status(1).state, NodeState::operational);
}

TEST_F(Scout, ValuesOfANodeCanBeStuckOrWrong) {
  enable_and_drive(0.3, 0.3);
  world_.inject("encoder-jump:0x01:1:200");
  world_.inject("stuck:0x02:1");
  const double held = world_.said_rpm[1];
  world_.drive_at(0.1, 0.1);
  world_.run(1);
  EXPECT_NEAR(world_.said_rpm[0], 0.1 / kRpm_m_s + 200, 12);
  EXPECT_EQ(world_.said_rpm[1], held);
}

TEST_F(Scout, EveryKindOfFaultCanBeAttachedAndClearedWhileItDrives) {
  enable_and_drive(0.3, 0.3);
  for (const FaultKind& kind : make_scout_kind()->fault_kinds()) {
    Fault fault{.kind = &kind, .values = {}, .clear = false};
    for (const FaultArgument& argument : kind.arguments) {
      fault.values.push_back(argument.choices.empty() ? std::min(argument.max, 1.0)
                                                      : argument.choices.front());
    }
    world_.vehicle().set_fault(fault, true);
    EXPECT_TRUE(world_.vehicle().in_force(fault)) << kind.name;
    world_.run(0.1);
    if (!kind.momentary) world_.vehicle().set_fault(fault, false);
    world_.run(0.1);
  }
  EXPECT_TRUE(std::isfinite(world_.truth("position_m", 0)));
}

TEST_F(Scout, FaultsAreWrittenWithTheWordsOfTheirSides) {
  EXPECT_EQ(to_text(*parse_fault("wheel-blocked:right", world_.kinds())), "wheel-blocked:right");
  const auto wrong = parse_fault("wheel-blocked:both", world_.kinds());
  ASSERT_FALSE(wrong);
  EXPECT_THAT(wrong.error(), testing::HasSubstr("one of left, right"));
  EXPECT_FALSE(parse_fault("wheel-blocked:1", world_.kinds()));
  EXPECT_FALSE(parse_fault("node-silent:0x03", world_.kinds()));
  EXPECT_THAT(describe(make_scout_kind()->fault_kinds()),
              testing::HasSubstr("WHEEL: side, one of left, right"));
}

TEST_F(Scout, TheSameSeedGivesTheSameBits) {
  World other(1), different(2);
  for (World* world : {&world_, &other, &different}) {
    world->drive_at(0.3, 0.2);
    world->inject("foreign-frames");
    world->run(4);
  }
  EXPECT_EQ(world_.all_truth(), other.all_truth());
  EXPECT_EQ(world_.said_rpm, other.said_rpm);
  EXPECT_EQ(world_.said_per_mille, other.said_per_mille);
  EXPECT_NE(world_.said_per_mille, different.said_per_mille);
}

}  // namespace
}  // namespace lss::sim
