// The daemon's drivers against the simulated vehicle, in virtual time: both were written from
// docs/icd-talaris.md, neither from the other.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "drivers/talaris/ar1000.h"
#include "drivers/talaris/crossbow.h"
#include "drivers/talaris/flow_camera.h"
#include "drivers/talaris/hopper_bus.h"
#include "drivers/talaris/landmark30.h"
#include "drivers/talaris/valves.h"
#include "tools/lss-sim/talaris/vehicle.h"

namespace lss::talaris {
namespace {

using canopen::NodeState;
using sim::talaris::ImuKind;
using sim::talaris::Stand;
using sim::talaris::TalarisOptions;

constexpr TimeNs kTurn = 50'000;  // of the threads
constexpr TimeNs kFrame = 200 * kMillisecond;

// A line's driver with its UART.
struct LineEnd {
  LineEnd(const sim::SerialLine& line, std::unique_ptr<SensorLine> made, TimeNs now)
      : uart({.baud = line.baud, .bits = line.bits, .paced = true}, *line.device),
        driver(std::move(made)) {
    EXPECT_EQ(driver->format().baud, line.baud);
    EXPECT_EQ(driver->format().bits(), line.bits);
    driver->restart(now);
  }
  void turn(TimeNs now, std::vector<TalarisSample>& samples) {
    for (auto said = driver->transmit(now); !said.empty(); said = driver->transmit(now)) {
      uart.from_master(said, now);
    }
    uart.advance(now);
    std::vector<LineByte> heard;
    for (const std::uint8_t byte : uart.take(now)) heard.push_back({.value = byte});
    if (!heard.empty()) driver->receive(heard, now);
    std::array<TalarisSample, SensorLine::kMaxSamples> taken;
    const std::size_t count = driver->take(taken);
    samples.insert(samples.end(), taken.begin(),
                   taken.begin() + static_cast<std::ptrdiff_t>(count));
    FrameTick tick;
    if (driver->take_tick(tick)) ticks.push_back(tick);
  }

  sim::Uart uart;
  std::unique_ptr<SensorLine> driver;
  std::vector<FrameTick> ticks;
};

class TalarisDrivers : public testing::Test {
 protected:
  void start(const TalarisOptions& options) {
    world_ = std::make_unique<sim::talaris::Talaris>(options);
    can_ = std::make_unique<sim::CanBus>(sim::CanBus::Parameters{}, *world_);
    const auto lines = world_->lines();
    std::unique_ptr<SensorLine> imu;
    if (options.imu.kind == ImuKind::crossbow) {
      imu = std::make_unique<Crossbow>(CrossbowParameters{});
    } else {
      imu = std::make_unique<LandMark30>(LandMark30Parameters{});
    }
    imu_ = std::make_unique<LineEnd>(lines[0], std::move(imu), now_);
    altimeter_ =
        std::make_unique<LineEnd>(lines[1], std::make_unique<Ar1000>(Ar1000Parameters{}), now_);
    if (options.camera.present)
      camera_ = std::make_unique<LineEnd>(
          lines[2], std::make_unique<FlowCamera>(FlowCameraParameters{}), now_);
    master_.restart(now_);
    valves_.reopened(now_);
    orders_.enabled = 0xFF;
    orders_.boot_allowed = true;
    run(1.5);
    samples_.clear();
  }
  void run(double seconds) {
    for (const TimeNs end = now_ + static_cast<TimeNs>(seconds * 1e9); now_ < end; now_ += kTurn) {
      if (now_ % kMillisecond == 0) world_->step();
      if (now_ % kFrame == 0) release();
      turn();
    }
  }
  void release() {
    orders_.issued_ns = orders_.boundary_ns = orders_.release_ns = now_;
    master_.release(orders_, now_);
    valves_.release(orders_, now_);
  }
  void turn() {
    imu_->turn(now_, samples_);
    altimeter_->turn(now_, samples_);
    if (camera_) camera_->turn(now_, samples_);
    for (CanFrame heard : can_->take(now_)) {
      heard.time_ns = now_;
      master_.receive({&heard, 1});
    }
    CanFrame said;
    while (valves_.due(now_, said)) {
      can_->from_master(said, now_);
      valves_.sent(true, now_);
    }
    while (master_.transmit(now_, said)) can_->from_master(said, now_);
    can_->advance(now_);
    std::array<TalarisSample, HopperBus::kMaxSamples> taken;
    const std::size_t count = master_.take(taken);
    samples_.insert(samples_.end(), taken.begin(),
                    taken.begin() + static_cast<std::ptrdiff_t>(count));
  }
  void inject(const char* text) {
    world_->set_fault(*sim::parse_fault(text, sim::talaris::fault_kinds()), true);
  }
  template <class Kind>
  std::vector<Kind> all() const {
    std::vector<Kind> found;
    for (const TalarisSample& sample : samples_) {
      if (const auto* one = std::get_if<Kind>(&sample.reading)) found.push_back(*one);
    }
    return found;
  }
  NodeState state(std::size_t node) { return master_.status().link[node].node.state; }

  TimeNs now_ = 100 * kSecond;
  std::unique_ptr<sim::talaris::Talaris> world_;
  std::unique_ptr<sim::CanBus> can_;
  std::unique_ptr<LineEnd> imu_, altimeter_, camera_;
  HopperBus master_{HopperBusParameters{}};
  ValveSequencer valves_;
  TalarisOrders orders_;
  std::vector<TalarisSample> samples_;
};

TEST_F(TalarisDrivers, NodesComeUpAndSayHowTheyAre) {
  start({});
  EXPECT_EQ(state(kValveNode), NodeState::operational);
  EXPECT_EQ(state(kFanNode), NodeState::operational);
  run(2);
  const auto gas = all<GasState>();
  ASSERT_NEAR(static_cast<double>(gas.size()), 10, 1);
  EXPECT_NEAR(gas.back().tank_Pa, 31.026e6, 6e4);
  EXPECT_NEAR(gas.back().regulated_Pa, 4.137e6, 3e4);
  EXPECT_NEAR(gas.back().voltage_V, 51.8, 0.2);
  EXPECT_NEAR(static_cast<double>(all<FanSpeeds>().size()), 100, 2);
}

TEST_F(TalarisDrivers, NoPacketOfTheImuIsLostAndEveryFortiethIsAFrame) {
  start({});
  imu_->ticks.clear();
  run(4);
  const auto packets = all<ImuPacket>();
  EXPECT_NEAR(static_cast<double>(packets.size()), 800, 1);
  EXPECT_NEAR(packets.back().force_m_s2[0], 9.80665, 0.2);
  EXPECT_EQ(imu_->driver->status().counters.lost, 0u);
  EXPECT_EQ(imu_->driver->status().counters.bad_check, 0u);
  ASSERT_EQ(imu_->ticks.size(), 20u);
  for (std::size_t i = 1; i < 20; ++i) {
    EXPECT_NEAR(static_cast<double>(imu_->ticks[i].time_ns - imu_->ticks[i - 1].time_ns), 200e6,
                1e6);
  }
}

TEST_F(TalarisDrivers, TheAltimeterReadsWhatItStandsAt) {
  start({.plant = {.stand = Stand::sled, .wall_m = 7}});
  run(3);
  const auto ranges = all<Range>();
  EXPECT_NEAR(static_cast<double>(ranges.size()), 30, 2);
  for (const Range& range : ranges) {
    EXPECT_EQ(range.error, 0);
    EXPECT_NEAR(range.range_m, 7, 0.02);
  }
  inject("altimeter-error:17");
  samples_.clear();
  run(0.5);
  EXPECT_EQ(all<Range>().back().error, 17);
}

TEST_F(TalarisDrivers, TheCrossbowAnswersAHundredPollsASecond) {
  start({.imu = {.kind = ImuKind::crossbow}});
  imu_->ticks.clear();
  run(2);
  const auto packets = all<ImuPacket>();
  EXPECT_NEAR(static_cast<double>(packets.size()), 200, 3);
  EXPECT_NEAR(packets.back().force_m_s2[0], 9.80665, 0.2);
  EXPECT_NEAR(static_cast<double>(imu_->ticks.size()), 10, 1);
}

TEST_F(TalarisDrivers, PulsesMoveItByThrustTimesOnTime) {
  start({.plant = {.stand = Stand::rail, .friction_m_s2 = 0}});
  for (const std::size_t valve : {1u, 7u}) {
    orders_.pulse[valve] = {.delay_ns = 55 * kMillisecond, .on_ns = 90 * kMillisecond};
  }
  run(1);  // five frames
  orders_.pulse = {};
  run(0.4);
  EXPECT_NEAR(world_->plant().body().velocity_m_s.z(), 5 * 2 * 58 * 0.090 / 45, 0.015);
  EXPECT_EQ(valves_.counters().pulses[1], 5u);
  EXPECT_EQ(world_->valve_node().gaps(), 0u);
  EXPECT_EQ(world_->gas().open(), 0);
}

TEST_F(TalarisDrivers, AValveThatIsHeldStaysOpen) {
  start({.plant = {.stand = Stand::load}});
  orders_.hold[2] = {.open = true, .until_ns = now_ + 3 * kSecond};
  run(0.3);
  for (int i = 0; i < 25; ++i) {
    run(0.1);
    ASSERT_EQ(world_->gas().open(), 0x04);
  }
  run(0.5);
  EXPECT_EQ(world_->gas().open(), 0);
}

TEST_F(TalarisDrivers, FansStartUpAndTurn) {
  start({});
  orders_.fan_us.fill(2000);
  run(0.4);
  orders_.fan_us.fill(1000);
  run(0.4);
  EXPECT_TRUE(world_->fans().armed(0));
  EXPECT_EQ(world_->fans().rpm(0), 0);
  orders_.fan_us.fill(1500);
  run(2);
  EXPECT_NEAR(all<FanSpeeds>().back().rpm[3], 16'500, 101);
}

TEST_F(TalarisDrivers, WithoutTheDaemonValvesShutAndFansSlowDown) {
  start({.fans = {.started = true}});
  orders_.hold[0] = {.open = true, .until_ns = now_ + 30 * kSecond};
  orders_.fan_us.fill(1400);
  run(0.5);
  ASSERT_EQ(world_->valve_node().outputs(), 0x01);
  for (int i = 0; i < 120; ++i) world_->step();
  EXPECT_EQ(world_->valve_node().outputs(), 0);
  EXPECT_LT(world_->fan_node().pulse_us()[0], 1400) << "slows down";
  for (int i = 0; i < 800; ++i) world_->step();  // 400 us at 500 us/s
  EXPECT_EQ(world_->fan_node().pulse_us()[0], 1000);
}

TEST_F(TalarisDrivers, FaultsArriveAsWhatTheyAre) {
  start({});
  inject("imu-counter-jump:7");
  run(0.1);
  EXPECT_EQ(imu_->driver->status().counters.lost, 7u);
  inject("imu-checksum:0.2");
  run(1);
  EXPECT_GT(imu_->driver->status().counters.bad_check, 10u);
  inject("node-silent:0x21");
  orders_.boot_allowed = false;
  run(0.5);
  EXPECT_NE(state(kFanNode), NodeState::operational);
  EXPECT_EQ(state(kValveNode), NodeState::operational);
}

// It stands, then slides: the ground passes the other way.
TEST_F(TalarisDrivers, TheCameraSaysHowFarTheGroundPassed) {
  TalarisOptions options{.camera = {.present = true, .noise_rad_s = 0}};
  start(options);
  run(1);
  ASSERT_NEAR(static_cast<double>(all<Flow>().size()), 20, 1);
  for (const Flow& flow : all<Flow>()) {
    EXPECT_TRUE(flow.usable);
    EXPECT_NEAR(flow.angle_rad[0], 0, 2e-3) << "it stands";
  }
  samples_.clear();
  inject("push:400:30");
  const auto before = world_->plant().body().position_m;
  run(0.5);
  const auto moved = world_->plant().body().position_m - before;
  std::array<double, 2> passed{};
  for (const Flow& flow : all<Flow>()) {
    for (std::size_t i = 0; i < 2; ++i) passed[i] += flow.angle_rad[i];
  }
  const double depth_m = *world_->range_m();
  ASSERT_GT(std::abs(moved.y()), 0.02);
  EXPECT_NEAR(passed[0], -moved.y() / depth_m, 0.3 * std::abs(moved.y() / depth_m));
  EXPECT_NEAR(passed[1], -moved.z() / depth_m, 0.3 * std::abs(moved.z() / depth_m));
}

}  // namespace
}  // namespace lss::talaris
