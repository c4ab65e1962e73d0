// Messages of the fast all-stop on the CAN bus besides shutting and switching off.

#include "daemon/vehicles/talaris/actuation.h"

#include <gtest/gtest.h>

#include <cstring>

#include "drivers/canopen/canopen.h"
#include "tests/support/copies.h"
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
  static constexpr TimeNs kStaleAfter = 450'000'123;
  Actuation actuation_{ValveParameters{.stale_after_ns = kStaleAfter}, can_};
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

constexpr TimeNs kPulse = 123'456'789;

TalarisOrders pulse_now() {
  TalarisOrders orders;
  orders.issued_ns = orders.boundary_ns = orders.release_ns = now_ns();
  orders.enabled = 1;
  orders.pulse[0].on_ns = kPulse;
  orders.fan_us.fill(1100);
  return orders;
}

// Radiation, between the release of a pulse and its end: tenths of a second.
TEST_F(Actuate, AFlippedBitOfAPulseIsCorrectedAndTwoShutTheValves) {
  release(1200);
  ASSERT_TRUE(heard(1200)) << "the port is open";
  for (const std::size_t damaged : {0u, 1u, 2u}) {
    const TalarisOrders orders = pulse_now();
    actuation_.release(orders, orders.release_ns, orders.release_ns);
    ASSERT_EQ(actuation_.report().open, 1);
    const auto copies = lss::testing_support::copies_of(kPulse, bytes_of(actuation_));
    ASSERT_EQ(copies.size(), 2u);
    lss::testing_support::damage(copies, damaged);
    actuation_.run(orders.release_ns + kMillisecond);
    EXPECT_EQ(actuation_.report().open, damaged == 2 ? 0 : 1) << damaged;
    EXPECT_EQ(actuation_.take_memory_lost(), damaged == 2) << damaged;
    EXPECT_FALSE(actuation_.take_memory_lost()) << "once";
    EXPECT_FALSE(actuation_.report().all_stop_pending);
    if (damaged == 2) continue;
    EXPECT_EQ(std::memcmp(copies[0], &kPulse, sizeof kPulse), 0);
    EXPECT_EQ(std::memcmp(copies[1], &kPulse, sizeof kPulse), 0);
  }
}

TEST_F(Actuate, AParameterOfWhichBothCopiesAreDamagedIsThatOfTheStartAgain) {
  release(1200);
  ASSERT_TRUE(heard(1200)) << "the port is open";
  TalarisOrders orders = pulse_now();
  actuation_.release(orders, orders.release_ns, orders.release_ns);
  const std::uint64_t pulses = actuation_.report().counters.pulses[0];
  const auto copies = lss::testing_support::copies_of(kStaleAfter, bytes_of(actuation_));
  ASSERT_EQ(copies.size(), 3u) << "the start's, then both of the valves' timing";
  copies[1][7] ^= 0x80;  // all orders are stale
  copies[2][7] ^= 0xC0;
  actuation_.run(orders.release_ns + kMillisecond);
  EXPECT_EQ(actuation_.report().open, 0);
  EXPECT_EQ(actuation_.report().shut_ns[0], orders.release_ns + kMillisecond);
  orders = pulse_now();
  actuation_.release(orders, orders.release_ns, orders.release_ns);
  EXPECT_EQ(actuation_.report().open, 1);
  EXPECT_EQ(actuation_.report().counters.pulses[0], pulses + 1);
}

// By the way that the frame asks.
TEST(ActuateOfTheBuses, DamagedTimingOfTheValvesIsReportedOnce) {
  const lss::testing_support::TempFolder folder;
  const CanListener can;
  const auto buses =
      std::make_unique<Buses>(testing_support::configuration(folder, can), BusesParameters{});
  Actuation& actuation = buses->actuation();
  const TalarisOrders orders = pulse_now();
  actuation.release(orders, orders.release_ns, orders.release_ns);
  EXPECT_FALSE(buses->take_memory_lost());
  const auto copies = lss::testing_support::copies_of(kPulse, bytes_of(actuation));
  ASSERT_EQ(copies.size(), 2u);
  lss::testing_support::damage(copies, 2);
  actuation.run(orders.release_ns + kMillisecond);
  EXPECT_TRUE(buses->take_memory_lost());
  EXPECT_FALSE(buses->take_memory_lost());
}

}  // namespace
}  // namespace lss::talaris
