// Row xi: the error of a release at an absolute time by the actuate thread, as a valve has it: when
// the order is issued, and when its byte was written to a port; against cyclictest with the same
// period, priority and CPU at the same time.

#include "tests/bench/edge_error.h"

#include <unistd.h>

#include <array>
#include <atomic>

#include "daemon/runtime/frame_engine.h"
#include "drivers/serial/serial_port.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

constexpr TimeNs kPeriod = 5 * kMillisecond;
constexpr TimeNs kOffset = 2 * kMillisecond;
constexpr TimeNs kSpin = 200 * kMicrosecond;

Errors edges(int count, TimeNs spin_ns) {
  Terminal terminal;
  SerialPort port;
  if (port.open(terminal.name().c_str(), 115'200, false) != SerialPort::Status::ok)
    throw NotHere("a pseudo-terminal cannot be opened as a port here");
  Errors errors;
  errors.issued_us.resize(static_cast<std::size_t>(count));
  errors.written_us.resize(static_cast<std::size_t>(count));

  ClockFrames grid(FrameClock(now_ns() + 2 * kPeriod, kPeriod, kOffset));
  // The command of a frame is the time at which it is to be released.
  FrameEngine<ClockFrames, TimeNs> engine(
      grid, {.period_ns = kPeriod, .offset_ns = kOffset, .actuate_spin_ns = spin_ns});
  std::size_t done = 0;
  std::atomic<bool> over{false};
  {
    Fifo frame("frame", kFramePriority, measured_cpu(), [&] {
      engine.frame([](const Boundary& boundary, const Released&,
                      TimingPoints&) noexcept { return boundary.time_ns + kOffset; },
                   [](const TimingPoints&) noexcept {});
    });
    Fifo actuate("actuate", kActuatePriority, measured_cpu(), [&] {
      engine.actuate([&](TimeNs due_ns) noexcept {
        const TimeNs issued_ns = now_ns();
        const std::uint8_t edge = 1;
        port.write({&edge, 1});
        const TimeNs written_ns = now_ns();
        if (done == errors.issued_us.size()) return;
        errors.issued_us[done] = static_cast<double>(issued_ns - due_ns) * 1e-3;
        errors.written_us[done] = static_cast<double>(written_ns - due_ns) * 1e-3;
        if (++done == errors.issued_us.size()) {
          engine.stop();
          over = true;
        }
      });
    });
    // The far end takes the bytes.
    const auto drain = [&] {
      std::array<char, 256> bytes;
      while (::read(terminal.fd(), bytes.data(), bytes.size()) > 0) {
      }
      return over.load();
    };
    if (!eventually(drain, std::chrono::minutes(5))) engine.stop();
  }
  return errors;
}

// Of one way to make edges, beside cyclictest.
void measure(const Options& options, const std::string& what, Errors (*subject)(int, TimeNs),
             Figures& figures) {
  const int count = options.count(300, 40);
  const int rounds_wanted = options.maxima ? kRounds : options.count(15, kRounds);
  for (const TimeNs spin_ns : {TimeNs{0}, kSpin}) {
    Rounds issued, written;
    for (int i = 0; i < rounds_wanted; ++i) {
      Cyclictest first(kActuatePriority, kPeriod, count, measured_cpu());
      Cyclictest second(kActuatePriority, kPeriod, count, measured_cpu());
      const Errors errors = subject(count, spin_ns);
      const Samples a = first.latencies(), b = second.latencies();
      issued.push_back({errors.issued_us, a, b});
      written.push_back({errors.written_us, a, b});
    }
    const bool spin = spin_ns != 0;
    const std::string how = what + (spin ? ", spin_us = 200, " : ", asleep, ");
    figures.push_back(figure("xi", "edge issued" + how + "p50", "us", issued, median, kNone));
    figures.push_back(
        figure("xi", "edge issued" + how + "p99", "us", issued, p99, spin ? 0.05 : kNone));
    figures.push_back(held_back(
        figure("xi", "byte written" + how + "p50", "us", written, median, spin ? 0.25 : kNone),
        "the kernel's write to a pseudo-terminal, which wakes a worker"));
    figures.push_back(
        figure("xi", "byte written" + how + "p99", "us", written, p99, spin ? 0.6 : kNone));
    if (options.maxima) {
      figures.push_back(most("xi", "edge issued" + how + "max", "us", issued));
      figures.push_back(most("xi", "byte written" + how + "max", "us", written));
      figures.push_back(missed("xi", "byte written" + how + "later than 1 ms", written, 1000));
    }
  }
}

}  // namespace

Figures edge_error(const Options& options) {
  prepare_real_time();
  Figures figures;
  measure(options, "", edges, figures);
#ifdef LSS_BENCH_TALARIS
  measure(options, " between releases", valve_edges, figures);
#endif
  return figures;
}

}  // namespace lss::bench
