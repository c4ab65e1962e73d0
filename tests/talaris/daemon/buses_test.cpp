// The wiring on real pseudo-terminals and datagrams, with its threads. The asserted times are also
// valid on a busy machine: never early, and in order.

#include "daemon/vehicles/talaris/buses.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <future>
#include <optional>
#include <vector>

#include "tests/talaris/daemon/buses_rig.h"

namespace lss::talaris {
namespace {

using testing_support::FrameSeen;
using testing_support::Rig;
using testing_support::tells_fans;
using testing_support::tells_valves;

constexpr TimeNs kDelay = 2 * kMillisecond, kOn = 4 * kMillisecond;

void nothing(const FrameSeen&, TalarisOrders&) {}
void pulse_of_valve_3(const FrameSeen&, TalarisOrders& orders) {
  orders.enabled = 0xFF;
  orders.pulse[2] = {.delay_ns = kDelay, .on_ns = kOn};
}
// In every frame, until something else is wanted.
void valve_1_open(TalarisOrders& orders) {
  orders.enabled = 0xFF;
  orders.hold[0] = {.open = true, .until_ns = INT64_MAX};
  orders.fan_us = {1500, 1500, 1500, 1500};
}
bool opens_valve_1(const CanFrame& f) { return tells_valves(f) && f.data[0] == 0x01; }
bool shuts_all(const CanFrame& f) { return tells_valves(f) && f.data[0] == 0; }
bool switches_fans_off(const CanFrame& f) {
  return tells_fans(f) && f.data == std::array<std::uint8_t, 8>{0xE8, 3, 0xE8, 3, 0xE8, 3, 0xE8, 3};
}

std::vector<ImuPacket> packets(const std::vector<FrameSeen>& frames) {
  std::vector<ImuPacket> all;
  for (const FrameSeen& frame : frames) {
    for (const TalarisSample& sample : frame.samples) {
      if (const auto* packet = std::get_if<ImuPacket>(&sample.reading)) all.push_back(*packet);
    }
  }
  return all;
}

TEST(Buses, EveryFourthPacketBeginsAFrameWithWhatWasHeardBefore) {
  Rig rig;
  rig.start(nothing);
  const char range[] = "003.210\r\n001.234\r\n";  // the first may be received from its middle
  rig.altimeter.write(range, sizeof range - 1);
  ASSERT_TRUE(rig.send_for_frames(10));
  rig.stop();
  const std::vector<FrameSeen> frames = rig.seen();
  std::size_t ranges = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    EXPECT_FALSE(frames[k].boundary.held);
    for (const TalarisSample& sample : frames[k].samples) {
      EXPECT_LT(sample.time_ns, frames[k].boundary.time_ns);
      const auto* heard = std::get_if<Range>(&sample.reading);
      // A message of the altimeter may have come before the first frame.
      if (k > 0 && heard == nullptr) {
        EXPECT_GE(sample.time_ns, frames[k - 1].boundary.time_ns);
      }
      if (heard != nullptr && std::abs(heard->range_m - 1.234) < 1e-9) ++ranges;
    }
  }
  EXPECT_EQ(ranges, 1u);
  const std::vector<ImuPacket> heard = packets(frames);
  ASSERT_GE(heard.size(), 30u);
  for (std::size_t i = 0; i < heard.size(); ++i) {
    EXPECT_EQ(heard[i].count, heard[0].count + i) << "none is lost or there twice";
    EXPECT_NEAR(heard[i].force_m_s2[0], 9.80665, 1e-9);
  }
}

TEST(Buses, ALostPacketDoesNotShiftTheFramesAfterIt) {
  Rig rig;
  rig.start(nothing);
  rig.imu.send(80, 19, 1);  // as if the 20th, which may begin a frame, were lost
  rig.imu.send(80, 33, 2);
  ASSERT_TRUE(rig.wait_for_frame(
      [](const FrameSeen& f) { return f.report.imu.status.counters.lost == 3; }));
  rig.stop();
  for (const FrameSeen& frame : rig.seen()) {
    const std::vector<ImuPacket> batch = packets({frame});
    if (batch.empty()) continue;
    // A batch begins with the packet that began the frame before; with the next when it is lost.
    EXPECT_LE(batch[0].count % 4, 2u);
    if (batch.size() == 4) {
      EXPECT_EQ(batch[0].count % 4, 0u);
    }
  }
}

TEST(Buses, OrdersOpenTheirValveAtItsTimeAfterTheReleaseAndShutIt) {
  Rig rig;
  rig.start(pulse_of_valve_3);
  ASSERT_TRUE(rig.send_for_frames(10));
  rig.stop();
  // The first word on the bus is: all shut.
  const auto heard = rig.can.heard();
  const auto first =
      std::ranges::find_if(heard, [](const auto& h) { return tells_valves(h.frame); });
  ASSERT_NE(first, heard.end());
  EXPECT_EQ(first->frame.data[0], 0);
  int pulses = 0;
  const std::vector<FrameSeen> frames = rig.seen();
  for (std::size_t k = 1; k < frames.size(); ++k) {
    // The report of this frame on the one before, when that was released in time.
    const EdgeReport& edges = frames[k].report.edges;
    const TimeNs release_ns = frames[k - 1].boundary.time_ns + rig.config.offset_ns;
    if (edges.opened_ns[2] < release_ns || edges.shut_ns[2] < edges.opened_ns[2]) continue;
    EXPECT_GE(edges.opened_ns[2], release_ns + kDelay);
    EXPECT_GE(edges.shut_ns[2], release_ns + kDelay + kOn);
    ++pulses;
  }
  EXPECT_GT(pulses, 0);
  const EdgeReport& edges = frames.back().report.edges;
  EXPECT_GE(edges.counters.pulses[2], 1u);
  EXPECT_GE(edges.counters.worst_late_ns, edges.last_late_ns);
  int opened = 0;
  for (std::size_t i = 0; i < heard.size(); ++i) {
    if (tells_valves(heard[i].frame)) opened += heard[i].frame.data[0] == 0x04;
  }
  EXPECT_GE(opened, pulses);
}

TEST(Buses, WhileTheImuIsSilentFramesBeginByTheClock) {
  Rig rig;
  rig.parameters.grace_ns = 5 * kMillisecond;
  rig.start(pulse_of_valve_3);
  ASSERT_TRUE(rig.wait_for_frame([](const FrameSeen& f) { return f.boundary.frame >= 5; }));
  const bool pulsed =
      rig.can.wait_for([](const CanFrame& f) { return f.data[0] == 4; }).has_value();
  EXPECT_TRUE(pulsed);
  std::uint64_t held = 0;
  for (const FrameSeen& frame : rig.seen()) held += frame.boundary.held;
  EXPECT_EQ(held, rig.seen().size());
  // It speaks again; a busy machine may delay some of its packets.
  std::thread speaking([&] { rig.imu.send(200); });
  EXPECT_TRUE(rig.wait_for_frame([](const FrameSeen& f) { return !f.boundary.held; }));
  speaking.join();
}

TEST(Buses, ALineThatIsPulledOutIsOpenedAgain) {
  Rig rig;
  rig.parameters.grace_ns = 5 * kMillisecond;
  rig.start(nothing);
  const auto open = [](bool wanted) {
    return [wanted](const FrameSeen& f) {
      return f.report.imu.open == wanted && f.report.imu.was_open;
    };
  };
  ASSERT_TRUE(rig.wait_for_frame(open(true)));
  rig.imu.device.pull_out();
  ASSERT_TRUE(rig.wait_for_frame(open(false)));
  const std::size_t before = rig.seen().size();
  rig.imu.device.plug_in();
  std::thread speaking([&] { rig.imu.send(200); });
  std::size_t at = 0;
  EXPECT_TRUE(
      rig.wait_for_frame([&](const FrameSeen& f) { return ++at > before && !f.boundary.held; }));
  speaking.join();
}

TEST(Buses, SamplesThatAThreadDroppedAreReported) {
  HopperCan can(HopperBusParameters{}, "can0", canopen::filters());
  HopperCan::Report said;
  can.line().describe(said, 3);
  EXPECT_EQ(said.port.overflows, 3u);
  Ar1000 altimeter(Ar1000Parameters{});
  LineBus line(LineEnds{.line = &altimeter}, SerialSettings{});
  LineBus::Report heard;
  line.line().describe(heard, 3);
  EXPECT_EQ(heard.counters.counters.overflows, 3u);
}

TEST(Buses, ThePortsHaveToBeThereByName) {
  Rig rig;
  rig.config.ports.pop_back();
  EXPECT_THAT(Buses(rig.config, rig.parameters).wrong_configuration(),
              testing::HasSubstr("\"can\""));
}

TEST(Buses, OnlyTheCanBusTakesOrders) {
  Rig rig;
  for (const Progress& bus : Buses(rig.config, rig.parameters).progress())
    EXPECT_EQ(bus.orders, bus.thread == "bus/can") << bus.thread;
}

TEST(Buses, APortThatNothingReadsIsNamed) {
  Rig rig;
  rig.config.ports.push_back({.name = "camera", .path = "/dev/camera"});
  EXPECT_THAT(Buses(rig.config, rig.parameters).wrong_configuration(),
              testing::HasSubstr("set present = true in [talaris.camera]"));
  rig.config.ports.back().name = "kamera";
  EXPECT_THAT(Buses(rig.config, rig.parameters).wrong_configuration(),
              testing::HasSubstr("nothing reads the port \"kamera\""));
}

TEST(Buses, AltimetersAtTheCornersHaveFourPortsOfOneKind) {
  Rig rig;
  const auto wrong = [&] { return Buses(rig.config, rig.parameters).wrong_configuration(); };
  rig.config.ports.push_back({.name = "corner_1", .path = "/dev/corner_1"});
  EXPECT_THAT(wrong(), testing::HasSubstr("set present = true in [talaris.corner_altimeters]"));
  rig.parameters.has_corners = true;
  EXPECT_THAT(wrong(), testing::HasSubstr("no [[port]] with name = \"corner_2\""));
  const auto baud = std::ranges::find(rig.config.ports, "altimeter", &config::Port::name)->baud;
  rig.config.ports.back().baud = baud;
  for (const char* name : {"corner_2", "corner_3", "corner_4"})
    rig.config.ports.push_back({.name = name, .path = "/dev/" + std::string(name), .baud = baud});
  EXPECT_EQ(wrong(), "");
  rig.config.ports.back().baud = 2 * baud;
  EXPECT_THAT(wrong(), testing::HasSubstr("give both one baud"));
}

TEST(Buses, TheFrameIsAsLongAsTheImuSays) {
  Rig rig;
  rig.parameters.landmark.packets_per_frame = 40;
  EXPECT_THAT(Buses(rig.config, rig.parameters).wrong_configuration(),
              testing::HasSubstr("200 ms"));
}

// One frame too late: its orders come two periods after the last, and nothing is stale until then.
TEST(Buses, OrdersAreNotStaleBeforeOneLateFrameIsMadeUpFor) {
  Rig rig;
  rig.parameters.grace_ns = 5 * kMillisecond;
  const TimeNs least = 2 * rig.config.period_ns + rig.config.offset_ns + rig.parameters.grace_ns;
  rig.parameters.can.stale_after_ns = least;
  rig.parameters.valves.stale_after_ns = least - 1;
  EXPECT_THAT(Buses(rig.config, rig.parameters).wrong_configuration(), testing::HasSubstr("50"));
  rig.parameters.valves.stale_after_ns = least;
  EXPECT_EQ(Buses(rig.config, rig.parameters).wrong_configuration(), "");
  rig.parameters.can.stale_after_ns = least - 1;
  EXPECT_NE(Buses(rig.config, rig.parameters).wrong_configuration(), "");
}

// From the first frame on the valve is open; then nothing makes another frame for as long as the
// test likes, and orders do not grow stale.
class AllStop : public testing::Test {
 protected:
  AllStop() {
    rig_.parameters.valves.stale_after_ns = rig_.parameters.can.stale_after_ns = 1000 * kSecond;
    rig_.parameters.valves.renew_ns = 1000 * kSecond;  // nothing else wakes the actuate thread
    rig_.start([this](const FrameSeen&, TalarisOrders& orders) {
      if (stopping_) {
        orders.all_stop = true;
      } else {
        valve_1_open(orders);
      }
    });
    // A bus that is opened after the orders came shuts, and they are gone.
    EXPECT_TRUE(rig_.can.wait_for(shuts_all));
    // A frame that the machine delayed past the time of its release has no orders: the next one
    // has.
    for (int tries = 0; tries < 30; ++tries) {
      rig_.imu.send(7);
      if (rig_.can.wait_for(opens_valve_1, 0, std::chrono::seconds(1))) break;
    }
  }
  // The number of the frame on the bus after which that was so.
  std::optional<std::size_t> heard(bool (*is)(const CanFrame&), std::size_t from) {
    return rig_.can.wait_for(is, from);
  }
  std::atomic<bool> stopping_{false};
  Rig rig_;
};

TEST_F(AllStop, ShutsAndSwitchesOffBeforeTheNextFrameBegins) {
  const auto opened = heard(opens_valve_1, 0);
  ASSERT_TRUE(opened);
  const std::size_t frames = rig_.seen().size();
  rig_.buses->all_stop();
  EXPECT_TRUE(heard(shuts_all, *opened));
  EXPECT_TRUE(heard(switches_fans_off, *opened));
  EXPECT_EQ(rig_.seen().size(), frames);
}

TEST_F(AllStop, OrdersDoNotPassUntilTheCycleHasConfirmed) {
  const auto opened = heard(opens_valve_1, 0);
  ASSERT_TRUE(opened);
  rig_.buses->all_stop();
  const auto shut = heard(shuts_all, *opened);
  ASSERT_TRUE(shut);
  // The cycle does not know of it yet.
  const auto sent_until = [&](auto is) {
    return rig_.send_until([&] { return std::ranges::any_of(rig_.seen(), is); });
  };
  ASSERT_TRUE(sent_until([](const FrameSeen& f) { return f.report.edges.refused_orders > 0; }));
  for (const FrameSeen& frame : rig_.seen()) {
    if (frame.report.edges.refused_orders > 0) {
      EXPECT_TRUE(frame.report.edges.all_stop_pending);
    }
  }
  // It does.
  stopping_ = true;
  ASSERT_TRUE(sent_until([](const FrameSeen& f) {
    return f.report.edges.refused_orders > 0 && !f.report.edges.all_stop_pending;
  }));
  const auto all = rig_.can.heard();
  for (std::size_t i = *shut; i < all.size(); ++i) EXPECT_FALSE(opens_valve_1(all[i].frame));
  // And may go on.
  stopping_ = false;
  EXPECT_TRUE(rig_.send_until([&] {
    return rig_.can.wait_for(opens_valve_1, *shut, std::chrono::milliseconds(0)).has_value();
  }));
}

// The frame thread does not come to an end: one repetition, and then everything is shut by itself.
TEST(Overrun, AnOpenValveIsShutWhenNoOrdersCome) {
  Rig rig;
  rig.parameters.grace_ns = 5 * kMillisecond;
  rig.parameters.valves.stale_after_ns = 60 * kMillisecond;
  std::atomic<bool> stuck{false};
  std::promise<void> free;
  const std::shared_future<void> freed = free.get_future().share();
  rig.start([&](const FrameSeen&, TalarisOrders& orders) {
    valve_1_open(orders);
    if (stuck) freed.wait();
  });
  // Frames go on until the valve is open: the first of them may be late and release nothing.
  const auto opened = rig.can.wait_for(opens_valve_1);
  EXPECT_TRUE(opened);
  stuck = true;
  EXPECT_TRUE(rig.can.wait_for(shuts_all, opened.value_or(0)));
  free.set_value();
  ASSERT_TRUE(rig.wait_for_frame([](const FrameSeen& f) {
    return f.report.edges.counters.stale > 0 && f.released.overruns > 0;
  }));
}

}  // namespace
}  // namespace lss::talaris
