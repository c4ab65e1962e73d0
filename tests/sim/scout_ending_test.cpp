// The daemon of the example scout ends at any moment of a drive and leaves a rover that stands with
// its motors off: daemon, bus, drives and wheels in virtual time.

#include <gtest/gtest.h>

#include <memory>

#include "examples/scout/vehicle.h"
#include "tests/support/virtual_chain.h"
#include "tools/lss-sim/frame/runner.h"

namespace lss {

namespace sim {
std::unique_ptr<VehicleKind> make_scout_kind();
}

namespace scout {
namespace {

class Chain final : public testing_support::VirtualChain<Vehicle, Mode, Parameters> {
 public:
  Chain()
      : VirtualChain(logic(), *sim::make_scout_kind(),
                     {.file = LSS_CONFIG,
                      .vehicle = "scout",
                      .read = read_parameters,
                      .complete =
                          [](Parameters& parameters, const config::Config& config) {
                            parameters = kit::with_frame(parameters, config);
                          },
                      .lease_ms = 10'000}) {
    next_frame_ns_ = kBegin + 20 * kMillisecond;
    master_.restart(now_ns_);
    report_.open = report_.was_open = true;
  }

  bool drive(double speed_m_s) {
    const auto contact = [this] {
      return supervisor().controller.unheard == 0 && supervisor().controller.silent == 0;
    };
    if (!run_until(contact, 5)) return false;
    send(kStartCommand);
    if (!run_until(Mode::ready, 5)) return false;
    send(kDriveCommand, {speed_m_s, 0});
    return run_until(Mode::driving, 1);
  }
  std::string power(std::size_t drive) const { return world_->truth().at("power").at(drive); }
  double speed_m_s() const { return world_->truth().at("velocity_m_s").at(0); }

 private:
  TimeNs next_event() override {
    return std::min({step_ns_, line_.next_wake(), std::max(master_.next_wake(), now_ns_ + 1),
                     next_frame_ns_, release_ns_, heartbeat_ns_});
  }
  void dispatch() override {
    if (now_ns_ >= step_ns_) {
      world_->step();
      step_ns_ += sim::kStepNs;
    }
    beat_when_due();
    if (now_ns_ >= release_ns_) {
      release_ns_ = kNever;
      master_.release(due(), now_ns_);
    }
    testing_support::turn_can(line_, master_, report_, samples_, now_ns_,
                              [this](const CanFrame& frame) { send_can(line_, frame); });
    if (now_ns_ >= next_frame_ns_)
      run_clock_frame(report_,
                      [this](Vehicle::Sample& out) { return samples_.pop(out, in_.time_ns); });
  }
  void act(const sim::Fault& fault, bool attach) override { world_->set_fault(fault, attach); }
  bool in_force(const sim::Fault& fault) const override { return world_->in_force(fault); }
  void all_stop() override { master_.all_stop(now_ns_); }

  std::unique_ptr<sim::Vehicle> world_ = sim::make_scout_kind()->make(1);
  sim::CanBus line_{{.paced = true, .seed = 2}, *world_->can_buses().front().device};
  canopen::VelocityBus master_{parameters_.bus};
  Vehicle::BusReport report_{};
  SampleQueue<Vehicle::Sample> samples_;
};

TEST(ScoutEnding, InAnyFrameOfADriveLeavesItAtRestWithMotorsOff) {
  for (int frames = 0; frames <= 40; frames += 4) {
    SCOPED_TRACE(frames);
    Chain chain;
    ASSERT_TRUE(chain.drive(0.5));
    chain.run(0.05 * frames);
    const TimeNs told_ns = chain.now();
    chain.shut_down();
    EXPECT_LT(chain.now() - told_ns, 2 * kSecond);
    EXPECT_EQ(chain.state(), State::idle);
    EXPECT_NEAR(chain.speed_m_s(), 0, 1e-3);
    for (const std::size_t drive : {0u, 1u})
      EXPECT_TRUE(chain.power(drive) == "switch on disabled" || chain.power(drive) == "ready")
          << chain.power(drive);
  }
}

// After an emergency stop the drives hold, and the daemon does not wait for them.
TEST(ScoutEnding, InFatalErrorLeavesDrivesThatHold) {
  Chain chain;
  ASSERT_TRUE(chain.drive(0.5));
  chain.run(1);
  chain.send(CommandKind::emergency_stop);
  ASSERT_TRUE(chain.run_until(State::fatal_error, 1));
  chain.run(2);
  const TimeNs told_ns = chain.now();
  chain.shut_down();
  EXPECT_LT(chain.now() - told_ns, kSecond);
  for (const std::size_t drive : {0u, 1u}) EXPECT_EQ(chain.power(drive), "quick stop");
}

}  // namespace
}  // namespace scout
}  // namespace lss
