// Row i: how late the frame thread wakes at T_k, against cyclictest with the same period, priority
// and CPU at the same time.

#include "daemon/runtime/frame_engine.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

constexpr TimeNs kPeriod = 5 * kMillisecond;  // 200 Hz
constexpr TimeNs kSpin = 200 * kMicrosecond;  // 4 % of the period

struct Run {
  Samples latencies_us;
  double cpu_share = 0;
};

// The frame thread of the daemon, with nothing to compute.
Run frame_thread(int frames, TimeNs spin_ns) {
  Run run;
  run.latencies_us.resize(static_cast<std::size_t>(frames));
  ClockFrames grid(FrameClock(now_ns() + 2 * kPeriod, kPeriod, kPeriod / 2));
  FrameEngine<ClockFrames, int> engine(
      grid, {.period_ns = kPeriod, .offset_ns = kPeriod / 2, .frame_spin_ns = spin_ns});
  std::size_t done = 0;
  run_fifo("frame", kFramePriority, measured_cpu(), [&] {
    const TimeNs begin_ns = now_ns();
    const double begin_s = thread_cpu_s();
    engine.frame([](const Boundary&, const Released&, TimingPoints&) noexcept { return 0; },
                 [&](const TimingPoints& timing) noexcept {
                   run.latencies_us[done] =
                       static_cast<double>(timing.woken_ns - timing.boundary_ns) * 1e-3;
                   if (++done == run.latencies_us.size()) engine.stop();
                 });
    run.cpu_share = (thread_cpu_s() - begin_s) / (static_cast<double>(now_ns() - begin_ns) * 1e-9);
  });
  return run;
}

}  // namespace

Figures wake_up(const Options& options) {
  prepare_real_time();
  const int frames = options.count(300, 40);
  // Which thread wakes shortly after which, and finds the CPU awake, is chance: many short rounds.
  // There is none in a machine that counts instructions.
  const int rounds_wanted = options.maxima ? kRounds : options.count(15, kRounds);
  Figures figures;
  for (const TimeNs spin_ns : {TimeNs{0}, kSpin}) {
    Rounds rounds;
    Samples shares;
    for (int i = 0; i < rounds_wanted; ++i) {
      Cyclictest first(kFramePriority, kPeriod, frames, measured_cpu());
      Cyclictest second(kFramePriority, kPeriod, frames, measured_cpu());
      const Run run = frame_thread(frames, spin_ns);
      shares.push_back(run.cpu_share * 100);
      rounds.push_back({run.latencies_us, first.latencies(), second.latencies()});
    }
    const bool spin = spin_ns != 0;
    const std::string how = spin ? "wake-up, spin_us = 200" : "wake-up, asleep";
    figures.push_back(figure("i", how + ", p50", "us", rounds, median, spin ? 0.05 : 1.05));
    figures.push_back(figure("i", how + ", p99", "us", rounds, p99, spin ? 0.25 : 1.35));
    if (options.maxima) {
      figures.push_back(most("i", how + ", max", "us", rounds));
      figures.push_back(missed("i", how + ", later than 2.5 ms", rounds, 2500));
    }
    if (spin)
      figures.push_back(figure_of("i", "CPU of the frame thread, spin_us = 200", "%",
                                  median(shares), 100, 0.05, "reference: one CPU"));
  }
  return figures;
}

}  // namespace lss::bench
