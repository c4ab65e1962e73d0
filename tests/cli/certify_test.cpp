// The parts of timing certify: outputs of other programs, and times on the wire. The whole of it:
// tests/e2e/test_certificate.py.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "daemon/config/config.h"
#include "tools/lss-cli/certify/scheduling.h"
#include "tools/lss-cli/certify/wire.h"
#include "tools/lss-cli/session/vehicle.h"

namespace lss::cli::certify {
namespace {

using testing::HasSubstr;

TEST(Scheduling, OfTimerlatIsTheLargestOfBothLatenciesOverTheCpus) {
  const auto t = parse_timerlat(
      "# RTLA timerlat histogram\n# Time unit is nanoseconds (ns)\n# Duration:   0 00:00:10\n"
      "Index   IRQ-000   Thr-000   IRQ-001   Thr-001\n"
      "2            91         3        90         2\n"
      "over:         0         0         0         0\n"
      "count:    10000     10000      9999      9999\n"
      "min:        700      2100       650      2000\n"
      "avg:        900      3100       950      3000\n"
      "max:       4100     11250      5200      9800\n");
  ASSERT_TRUE(t);
  EXPECT_DOUBLE_EQ(t->irq_us, 5.2);
  EXPECT_DOUBLE_EQ(t->thread_us, 11.25);
}

TEST(Scheduling, OfACpuWithoutASampleIsNotCounted) {
  const auto t = parse_timerlat(
      "Index   IRQ-000   Thr-000   IRQ-001   Thr-001\n"
      "max:          -         -      5200      9800\n");
  ASSERT_TRUE(t);
  EXPECT_DOUBLE_EQ(t->thread_us, 9.8);
  EXPECT_FALSE(parse_timerlat("Index   IRQ-000   Thr-000\nmax:          -         -\n"));
  EXPECT_FALSE(parse_timerlat("Tracer timerlat not found!\n"));
  EXPECT_FALSE(parse_timerlat("max: 5200 9800\n"));
  EXPECT_FALSE(parse_timerlat(""));
}

TEST(Scheduling, OfCyclictestIsItsLargestMaximum) {
  const auto us = parse_cyclictest(
      "# /dev/cpu_dma_latency set to 0us\n"
      "T: 0 (23474) P:70 I:1000 C:   1985 Min:  22257 Act:   95155 Avg:  104556 Max: 2793114\n"
      "T: 1 (23475) P:70 I:1500 C:   1329 Min:  22389 Act:   81048 Avg:  102603 Max: 2992343\n");
  ASSERT_TRUE(us);
  EXPECT_DOUBLE_EQ(*us, 2992.343);
  EXPECT_FALSE(parse_cyclictest("unable to set scheduler: Max:"));
  EXPECT_FALSE(parse_cyclictest("Max:\n"));
}

TEST(Program, IsRunWithItsWordsAndBothStreams) {
  const Ran ran = run_program({"sh", "-c", "echo $1; echo there >&2; exit 7", "-", "here; rm"});
  EXPECT_EQ(ran.code, 7);
  EXPECT_EQ(ran.output, "here; rm\nthere\n");
  EXPECT_EQ(run_program({"there-is-no-such-program"}).code, 127);
  EXPECT_EQ(run_program({"sh", "-c", "kill -9 $$"}).code, 128 + 9);
}

// ISO 11898-1; the worst case of 8 bytes is known as 135 bits.
TEST(Wire, OfACanFrameIsItsBitsWithTheMostStuffBits) {
  EXPECT_EQ(can_bits(8), 135);
  EXPECT_EQ(can_bits(0), 55);
  static_assert(bits_us(135, 500'000) == 270);
}

Wire wire_of(const config::Config& config, const std::string& own = "") {
  const toml::table table = toml::parse(own);
  config::Errors errors;
  config::Section section(&table, config.vehicle, "test", errors);
  return find_vehicle(config.vehicle)->overlay->wire(config, section, 500'000);
}

// docs/icd-zebro.md section 8: a frame has 24 characters, with CR one more; two characters of
// turning round in half duplex.
TEST(Wire, OfLunarZebroIsItsRequests) {
  config::Config config;
  config.vehicle = "zebro";
  config.ports = {{.name = "legs", .path = {}, .baud = 115'200}};
  const double character_us = 1e7 / 115'200;
  EXPECT_NEAR(wire_of(config).orders_us, 7 * 24 * character_us, 0.01);
  EXPECT_EQ(wire_of(config).packet_us, 0);
  EXPECT_NEAR(wire_of(config, "bus.stop = 'crlf'").orders_us, 7 * 25 * character_us, 0.01);
  config.ports[0].half_duplex = true;
  EXPECT_NEAR(wire_of(config).orders_us, 14 * 25 * character_us, 0.01);
  EXPECT_THAT(wire_of(config).formula, HasSubstr("7 requests and replies of"));
}

TEST(Wire, OfCanIsItsFramesAndAnotherBeforeThem) {
  config::Config config;
  config.vehicle = "ardito";
  EXPECT_DOUBLE_EQ(wire_of(config).orders_us,
                   bits_us(can_bits(8) + 10 * can_bits(6) + can_bits(1), 500'000));
  config.vehicle = "talaris";
  config.ports = {{.name = "imu", .path = {}, .baud = 115'200}};
  EXPECT_NEAR(wire_of(config).packet_us, 1875, 0.1) << "docs/icd-talaris.md: 104.2 us each";
  config.ports[0].baud = 38'400;
  EXPECT_NEAR(wire_of(config, "imu.kind = 'crossbow'").packet_us, 18 * 260.4, 0.5);
}

}  // namespace
}  // namespace lss::cli::certify
