// Messages of the fast all-stop on the CAN bus besides shutting and switching off.

#include "daemon/vehicles/talaris/actuation.h"

#include <gtest/gtest.h>

#include "drivers/canopen/canopen.h"
#include "tests/talaris/daemon/buses_rig.h"

namespace lss::talaris {
namespace {

using testing_support::CanListener;
using testing_support::tells_fans;

// Nobody answers, and no node is booted but by order.
class Actuate : public testing::Test {
 protected:
  Actuate() {
    can_.line().attach(actuation_.sender());
    thread_ = std::thread([this] { can_.run(); });
  }
  ~Actuate() override {
    can_.stop();
    thread_.join();
  }

  void release(std::uint16_t fan_us, bool all_stop = false) {
    const TimeNs now = now_ns();
    actuation_.release({.issued_ns = now,
                        .boundary_ns = now,
                        .release_ns = now,
                        .all_stop = all_stop,
                        .fan_us = {fan_us, fan_us, fan_us, fan_us},
                        .node_reset_serial = 1,
                        .reset_nodes = 1u << kFanNode},
                       now, now);
  }
  void all_stop() {
    actuation_.all_stop(now_ns());
    actuation_.run(now_ns());
  }
  // Twice: messages due at the same time were sent before the second.
  bool heard(std::uint16_t fan_us) {
    const auto says = [fan_us](const CanFrame& f) {
      return tells_fans(f) && f.data[0] == (fan_us & 0xFF) && f.data[1] == fan_us >> 8;
    };
    for (int i = 0; i < 2; ++i) {
      const auto at = listener_.wait_for(says, from_);
      if (!at) return false;
      from_ = *at + 1;
    }
    return true;
  }
  std::ptrdiff_t resets() {
    const auto all = listener_.heard();
    return std::ranges::count_if(all, [](const CanListener::Heard& h) {
      return h.frame.id == 0 && h.frame.data[0] == 0x81 && h.frame.data[1] == 0x21;
    });
  }

  CanListener listener_;
  HopperCan can_{HopperBusParameters{.stale_after_ns = 1000 * kSecond}, listener_.path(),
                 canopen::filters()};
  Actuation actuation_{ValveParameters{}, can_};
  std::thread thread_;
  std::size_t from_ = 0;
};

TEST_F(Actuate, AnAllStopDoesNotRepeatTheLastResetOfANode) {
  release(1100);
  ASSERT_TRUE(heard(1100));
  ASSERT_EQ(resets(), 1);
  all_stop();
  ASSERT_TRUE(heard(1000));
  release(1000, true);  // the cycle confirms, and may go on
  release(1200);
  ASSERT_TRUE(heard(1200));
  EXPECT_EQ(resets(), 1);
}

}  // namespace
}  // namespace lss::talaris
