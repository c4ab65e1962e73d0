// The lines and the bus under arbitrary bytes, cuts, frames and times: forbidden actions.

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include "drivers/talaris/ar1000.h"
#include "drivers/talaris/crossbow.h"
#include "drivers/talaris/hopper_bus.h"
#include "drivers/talaris/landmark30.h"
#include "drivers/talaris/valves.h"
#include "tests/support/any_frame.h"
#include "tests/support/can_frames.h"
#include "tests/talaris/drivers/lines.h"

namespace lss::talaris {
namespace {

constexpr TimeNs kPeriod = 5 * kMillisecond;

// To the line in pieces of any length, all read at their end.
void bring(SensorLine& line, const std::vector<LineByte>& bytes, TimeNs now) {
  for (std::size_t at = 0; at < bytes.size();) {
    const std::size_t size = std::min(*rc::gen::inRange<std::size_t>(1, 40), bytes.size() - at);
    line.receive(std::span(bytes).subspan(at, size), now);
    at += size;
  }
}

rc::Gen<std::vector<LineByte>> any_bytes() {
  return rc::gen::container<std::vector<LineByte>>(rc::gen::map(
      rc::gen::pair(rc::gen::weightedOneOf<std::uint8_t>(
                        {{3, rc::gen::arbitrary<std::uint8_t>()},
                         {1, rc::gen::element<std::uint8_t>(0x2A, 0xFF, 'E', '.', '\n', '\r')}}),
                    rc::gen::inRange(0, 20)),
      [](const auto& pair) {
        return LineByte{pair.first, pair.second == 0};
      }));
}

// Where a good packet begins in `stream`, from `at` on.
std::size_t next_good(const std::vector<LineByte>& stream, std::size_t at) {
  for (; at + LandMark30::kPacket <= stream.size(); ++at) {
    unsigned sum = 0;
    bool bad = stream[at].value != 0x2A;
    for (std::size_t i = at; i < at + LandMark30::kPacket; ++i) {
      sum += stream[i].value;
      bad = bad || stream[i].bad;
    }
    if (!bad && sum % 256 == 0) return at;
  }
  return stream.size();
}

// A packet whose data are those of its number.
std::vector<LineByte> numbered_packet(int n) {
  Bytes packet = landmark_packet(static_cast<std::uint8_t>(n), 0x40);
  for (std::size_t i = 2; i < 16; ++i) {
    packet[i] = static_cast<std::uint8_t>(37 * n + static_cast<int>(i) * 11);
  }
  return line_bytes(with_sum(packet));
}

RC_GTEST_PROP(LandmarkFuzz, OnlyGoodPacketsAreTakenAndWholeOnesComeBackWithinTwo, ()) {
  LandMark30 line{LandMark30Parameters{}};
  const int first = *rc::gen::inRange(0, 256);
  const int total = *rc::gen::inRange(10, 120);
  std::vector<LineByte> stream;
  std::vector<TalarisSample> all;
  std::size_t broken = 0;
  for (int n = 0; n < total; ++n) {
    auto bytes = numbered_packet(first + n);
    const int what = n < total - 4 ? *rc::gen::inRange(0, 12) : 11;
    const auto where = *rc::gen::inRange<std::ptrdiff_t>(0, std::ssize(bytes));
    LineByte& byte = bytes[static_cast<std::size_t>(where)];
    if (what == 0) byte.value ^= static_cast<std::uint8_t>(1 << *rc::gen::inRange(0, 8));
    if (what == 1) byte.bad = true;
    if (what == 2) bytes.erase(bytes.begin() + where);
    if (what == 3) bytes.insert(bytes.begin() + where, {0x2A, false});
    if (what == 4) bytes.clear();
    if (what <= 4) ++broken;
    stream.insert(stream.end(), bytes.begin(), bytes.end());
    bring(line, bytes, kSecond + n * kPeriod);
    for (const TalarisSample& s : take_all(line)) all.push_back(s);
  }
  // Each that was taken stands in the stream, sum and all, behind the one before.
  const auto packets = only<ImuPacket>(all);
  std::size_t at = 0;
  TimeNs last = 0;
  for (const auto& [time, packet] : packets) {
    RC_ASSERT(time > last);
    last = time;
    bool found = false;
    for (; !found; ++at) {
      at = next_good(stream, at);
      RC_ASSERT(at < stream.size());
      const auto low = stream[at + 14].value, high = stream[at + 15].value;
      const auto raw = static_cast<std::int16_t>(static_cast<std::uint16_t>(low | high << 8));
      found = packet.temperature_degC == raw * 0.01;
    }
    at += LandMark30::kPacket - 1;
  }
  // The last whole one has been taken, and no disturbance cost more than two of them.
  RC_ASSERT(at == stream.size());
  RC_ASSERT(packets.size() + 3 * broken >= static_cast<std::size_t>(total));
}

RC_GTEST_PROP(LandmarkFuzz, AnyBytesThenWholePackets, ()) {
  LandMark30 line{LandMark30Parameters{}};
  const auto noise = *any_bytes();
  bring(line, noise, kSecond);
  take_all(line);
  const std::uint64_t before = line.status().counters.packets;
  const int first = *rc::gen::inRange(0, 256);
  TimeNs now = 2 * kSecond;
  for (int n = 0; n < 6; ++n) {
    now += kPeriod;
    bring(line, line_bytes(landmark_packet(static_cast<std::uint8_t>(first + n), 0x40)), now);
  }
  // Noise may hide the first one, and look like one that goes on; never more.
  RC_ASSERT(line.status().counters.packets - before >= 4u);
}

RC_GTEST_PROP(CrossbowFuzz, AnyBytesNeverMakeAPacketWithoutItsSum, ()) {
  Crossbow line{CrossbowParameters{}};
  line.restart(kSecond);
  TimeNs now = kSecond;
  written(line, now);
  line.receive(line_bytes("H"), now);
  written(line, now);
  line.receive(line_bytes("C"), now);
  const int rounds = *rc::gen::inRange(1, 10);
  for (int n = 0; n < rounds; ++n) {
    now += 10 * kMillisecond;
    written(line, now);
    const auto noise = *any_bytes();
    bring(line, noise, now + kMillisecond);
    // An accepted packet is in the noise, including its sum.
    const auto got = only<ImuPacket>(take_all(line));
    bool possible = false;
    for (std::size_t at = 0; at + 18 <= noise.size(); ++at) {
      unsigned sum = 0;
      bool bad = false;
      for (std::size_t i = 0; i < 18; ++i) {
        if (i > 0 && i < 17) sum += noise[at + i].value;
        bad = bad || noise[at + i].bad;
      }
      possible =
          possible || (!bad && noise[at].value == 0xFF && (sum & 0xFF) == noise[at + 17].value);
    }
    RC_ASSERT(got.empty() || possible);
  }
  // And the next whole answer is taken.
  now += 10 * kMillisecond;
  written(line, now);
  bring(line, line_bytes(kCrossbowGolden), now + 6 * kMillisecond);
  RC_ASSERT(only<ImuPacket>(take_all(line)).size() == 1u);
}

RC_GTEST_PROP(AltimeterFuzz, AnyBytesThenAWholeLine, ()) {
  Ar1000 line{Ar1000Parameters{}};
  line.restart(kSecond);
  bring(line, *any_bytes(), kSecond);
  for (const auto& [time, range] : only<Range>(take_all(line))) {
    RC_ASSERT(range.error != 0 || (range.range_m >= 0.1 && range.range_m <= 30));
  }
  bring(line, line_bytes("\r\n000.934\r\n"), 2 * kSecond);
  const auto got = only<Range>(take_all(line));
  RC_ASSERT(!got.empty());
  RC_ASSERT(got.back().second.range_m == 0.934);
}

RC_GTEST_PROP(ValvesFuzz, WhatIsSaidIsWhatTheOrdersInForceSay, ()) {
  ValveSequencer valves;
  TalarisOrders orders;
  TimeNs now = 10 * kSecond;
  std::uint8_t open = 0;
  TimeNs said_ns = 0;
  const int frames = *rc::gen::inRange(1, 6);
  CanFrame frame;
  for (int n = 0; n < frames; ++n) {
    orders.enabled = *rc::gen::arbitrary<std::uint8_t>();
    orders.all_stop = *rc::gen::inRange(0, 8) == 0;
    orders.boundary_ns = orders.issued_ns = orders.release_ns = now;
    for (std::size_t i = 0; i < kHopperValves; ++i) {
      orders.pulse[i] = {*rc::gen::inRange<TimeNs>(-20, 250) * kMillisecond,
                         *rc::gen::inRange<TimeNs>(-20, 250) * kMillisecond};
      orders.hold[i] = {*rc::gen::inRange(0, 5) == 0,
                        now + *rc::gen::inRange<TimeNs>(-100, 700) * kMillisecond};
    }
    valves.release(orders, now);
    const TimeNs end = now + *rc::gen::inRange<TimeNs>(150, 700) * kMillisecond;
    const TimeNs stops = *rc::gen::inRange(0, 5) == 0 ? now + 60 * kMillisecond : INT64_MAX;
    bool stopped = false;
    while (now < end) {
      while (valves.due(now, frame)) {
        RC_ASSERT(frame.id == 0x220u || frame.id == 0x221u);
        valves.sent(true, now);
        if (frame.id != 0x220u) continue;
        RC_ASSERT(frame.data[1] != 0);
        open = frame.data[0];
        said_ns = now;
      }
      // Never open when not enabled, after the end of the frame, with too old orders, or after a
      // stop.
      RC_ASSERT((open & ~orders.enabled) == 0);
      RC_ASSERT(open == 0 || (!orders.all_stop && !stopped));
      RC_ASSERT(open == 0 || now - orders.issued_ns <= ValveParameters{}.stale_after_ns);
      RC_ASSERT(open == 0 || now - said_ns <= 50 * kMillisecond);
      for (std::size_t i = 0; i < kHopperValves; ++i) {
        const bool held = orders.hold[i].open && now < orders.hold[i].until_ns;
        if (!held) {
          RC_ASSERT((open >> i & 1) == 0 || now < orders.release_ns + 210 * kMillisecond);
        }
      }
      const TimeNs next = std::min({valves.next_wake(), end, stopped ? INT64_MAX : stops});
      RC_ASSERT(next > now);
      now = next;
      if (now >= stops && !stopped) {
        stopped = true;
        valves.all_stop(now);
      }
    }
  }
}

RC_GTEST_PROP(HopperFuzz, AnyFramesNeverOpenAValveNorAskForThePast, ()) {
  HopperBus bus({.load_cell = true});
  TimeNs now = kSecond;
  bus.restart(now);
  std::array<TalarisSample, HopperBus::kMaxSamples> samples;
  const int steps = *rc::gen::inRange(1, 150);
  for (int n = 0; n < steps; ++n) {
    CanFrame in = *testing_support::any_frame();
    if (*rc::gen::arbitrary<bool>()) {  // of our nodes, for they get further
      in.extended = in.remote = in.error = false;
      in.id = *rc::gen::element<std::uint32_t>(0x080, 0x180, 0x280, 0x580, 0x700) +
              *rc::gen::element<std::uint32_t>(0x20, 0x21, 0x22);
      in.size = *rc::gen::inRange<std::uint8_t>(0, 9);
    }
    in.time_ns = now;
    bus.receive({&in, 1});
    if (*rc::gen::inRange(0, 10) == 0) {
      TalarisOrders orders;
      orders.issued_ns = now - *rc::gen::inRange<TimeNs>(0, 500) * kMillisecond;
      orders.enabled = 0xFF;
      for (auto& hold : orders.hold) hold = {true, INT64_MAX};
      for (auto& width : orders.fan_us) width = *rc::gen::arbitrary<std::uint16_t>();
      orders.boot_allowed = *rc::gen::arbitrary<bool>();
      orders.node_reset_serial = *rc::gen::inRange<std::uint32_t>(0, 3);
      orders.reset_nodes = *rc::gen::arbitrary<std::uint8_t>();
      bus.release(orders, now);
    }
    CanFrame out;
    for (int sent = 0; bus.transmit(now, out); ++sent) {
      RC_ASSERT(sent < 200);
      if (out.id == 0x220u) RC_ASSERT((out.data[0] | out.data[1]) == 0);
      if (out.id != 0x221u) continue;
      for (std::size_t i = 0; i < 8; i += 2) {
        const int width = out.data[i] | out.data[i + 1] << 8;
        RC_ASSERT(width >= 1000 && width <= 2000);
      }
    }
    RC_ASSERT(bus.next_wake() > now);
    (void)bus.take(samples);
    now += *rc::gen::inRange<TimeNs>(0, 60) * kMillisecond;
  }
}

}  // namespace
}  // namespace lss::talaris
