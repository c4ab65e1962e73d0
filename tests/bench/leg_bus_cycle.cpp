// Row v: one cycle of Lunar Zebro's RS-485 bus, from its release to the last of the seven status
// replies: the daemon's bus thread on a pseudo-terminal, lss-sim with the pace of the wire behind
// it, against the time that the bits take (docs/icd-zebro.md section 8). A cycle that is not over
// at the next release counts as a whole period.

#include <fmt/format.h>

#include "daemon/runtime/serial_bus.h"
#include "drivers/zebro/leg_bus.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

using Bus = SerialBus<zebro::LegBus, zebro::LegBusParameters, zebro::BusOrders, zebro::ModuleReply,
                      zebro::BusCounters>;

constexpr TimeNs kPeriod = 20 * kMillisecond;

// Full duplex: seven requests and one reply behind one another, and a character to turn round.
double wire_us(int baud) {
  const double frame = static_cast<double>(zebro::frame_time_ns(baud, zebro::Stop::lf));
  return ((zebro::kBusModules + 1) * frame + 10e9 / baud) * 1e-3;
}

Cycles cycles(int baud, int count) {
  Folder folder;
  const Process simulator(
      {program("lss-sim"), "zebro", "--dir", folder, "--pace", "--baud", std::to_string(baud)},
      folder / "sim.log");
  const std::filesystem::path port = folder / "legs";
  if (!eventually([&] { return std::filesystem::exists(port); }))
    throw NotHere("lss-sim makes no port: " + read_file(folder / "sim.log"));

  Bus bus(zebro::LegBusParameters{.baud = baud, .period_ns = kPeriod},
          SerialSettings{.path = port, .baud = baud});
  Samples newest_us;
  Fifo thread("bus", kBusPriority, -1, [&] { bus.run(); });
  run_fifo("actuate", kActuatePriority, -1, [&] {
    newest_us.reserve(static_cast<std::size_t>(count) + 1);
    TimeNs next = now_ns() + kPeriod;
    // The first cycles also stop the modules and request their identity.
    for (int i = -30; i < count; ++i, next += kPeriod) {
      sleep_until(next);
      if (i >= -1) newest_us.push_back(static_cast<double>(bus.report().counters.cycle_ns) * 1e-3);
      bus.release({.issued_ns = now_ns()});
    }
  });
  const std::uint64_t dropped = bus.report().counters.frames_dropped;
  bus.stop();
  Cycles all = with_incomplete(newest_us, static_cast<double>(kPeriod) * 1e-3);
  if (all.incomplete > count / 2)
    throw std::runtime_error(fmt::format("{} of {} bus cycles were not complete, {} frames dropped",
                                         all.incomplete, count, dropped));
  return all;
}

Figure cycle(const Options& options, int baud, double goal) {
  const Cycles ours = cycles(baud, options.count(750, 60));
  const Samples wire(ours.us.size(), wire_us(baud));
  return noted(figure("v", fmt::format("bus cycle of seven modules, {} baud, p50", baud), "us",
                      side_by_side(ours.us, wire), median, goal),
               fmt::format("{} of {} cycles incomplete, counted as {} ms; reference: bits on the "
                           "wire by formula, so A/A is 1",
                           ours.incomplete, ours.us.size(), kPeriod / kMillisecond));
}

}  // namespace

Figures leg_bus_cycle(const Options& options) {
  prepare_real_time();
  return {cycle(options, 115'200, 1.015), cycle(options, 1'000'000, 1.07)};
}

}  // namespace lss::bench
