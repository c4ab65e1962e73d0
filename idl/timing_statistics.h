#pragma once

// Statistics over many frames: mean, sigma, extremes and a histogram for each step of a frame
// (TALARIS thesis, table 1). The daemon publishes those since its start or the last reset; lss-cli
// makes its own of the frames that it receives. Eight buckets per octave from 1 us on, linear
// below: a quantile is right to some 6 %. Plain; no thread of its own.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

namespace lss {

class TimingSeries {
 public:
  static constexpr std::size_t kBuckets = 200;  // of lss::TimingSeries in lss.idl; up to 17 s

  // Durations below 0 count as 0, too long ones in the last bucket.
  void add(std::int64_t ns) noexcept {
    const double value = static_cast<double>(ns);
    ++count;
    sum_ns += value;
    squares_ns2 += value * value;
    min_ns = std::min(min_ns, ns);
    max_ns = std::max(max_ns, ns);
    ++bucket[index(ns)];
  }

  double mean_ns() const noexcept { return count ? sum_ns / static_cast<double>(count) : 0; }
  double sigma_ns() const noexcept {
    if (count == 0) return 0;
    const double mean = mean_ns();
    return std::sqrt(std::max(0.0, squares_ns2 / static_cast<double>(count) - mean * mean));
  }
  // Interpolated within its bucket, never outside the extremes.
  double quantile_ns(double q) const noexcept {
    const double rank = q * static_cast<double>(count);
    double below = 0;
    for (std::size_t i = 0; i < kBuckets; ++i) {
      const auto here = static_cast<double>(bucket[i]);
      if (here > 0 && below + here >= rank) {
        const double part = (rank - below) / here;
        const auto low = static_cast<double>(lower_ns(i)),
                   high = static_cast<double>(lower_ns(i + 1));
        return std::clamp(low + part * (high - low), static_cast<double>(min_ns),
                          static_cast<double>(max_ns));
      }
      below += here;
    }
    return count ? static_cast<double>(max_ns) : 0;
  }

  static constexpr std::size_t index(std::int64_t ns) noexcept {
    if (ns < 0) return 0;
    const auto value = static_cast<std::uint64_t>(ns);
    if (value < kLinear_ns) return static_cast<std::size_t>(value / (kLinear_ns / 8));
    const auto octave = static_cast<std::size_t>(std::bit_width(value)) - kLinearBits - 1;
    const std::size_t eighth = (value >> (octave + kLinearBits - 3)) & 7;
    return std::min(8 + octave * 8 + eighth, kBuckets - 1);
  }
  // Lower bound of a bucket; of kBuckets: upper bound of the last one.
  static constexpr std::int64_t lower_ns(std::size_t i) noexcept {
    if (i < 8) return static_cast<std::int64_t>(i * (kLinear_ns / 8));
    const std::size_t octave = (i - 8) / 8, eighth = (i - 8) % 8;
    return static_cast<std::int64_t>((8 + eighth) << (octave + kLinearBits - 3));
  }

  std::uint64_t count = 0;
  double sum_ns = 0, squares_ns2 = 0;
  std::int64_t min_ns = std::numeric_limits<std::int64_t>::max();
  std::int64_t max_ns = std::numeric_limits<std::int64_t>::min();
  std::array<std::uint32_t, kBuckets> bucket{};

 private:
  static constexpr std::size_t kLinearBits = 10;
  static constexpr std::uint64_t kLinear_ns = 1u << kLinearBits;
};

struct TimingStep {
  const char* name;
  const char* what;
};
inline constexpr TimingStep kTimingSteps[] = {
    {"wake-up", "frame boundary to the thread running"},
    {"read", "samples and requests taken"},
    {"navigate", "supervised and navigated"},
    {"control", "command computed and put down"},
    {"command", "frame boundary to the command being ready"},
    {"release", "command given out after its time"},
};
inline constexpr std::size_t kTimingStepCount = std::size(kTimingSteps);

struct TimingStatistics {
  std::array<TimingSeries, kTimingStepCount> series{};  // as kTimingSteps
  std::uint64_t frames = 0, overruns = 0, repeated = 0, skipped = 0, held = 0;
  std::int64_t since_ns = 0, until_ns = 0;  // boundaries of the first and the last frame
  std::int64_t period_ns = 0, offset_ns = 0;

  double margin_ns(double ready_ns) const noexcept {
    return static_cast<double>(offset_ns) - ready_ns;
  }
};

// Accumulates frames. Points: TimingPoints or lss_Timing, one per frame; frames missed in between
// count by their counters only.
template <class Points>
class TimingCollector {
 public:
  void add(const Points& t) noexcept {
    if (statistics_.frames == 0) {
      if (before_.frame == 0) before_ = t;
      base_ = before_;
      statistics_.since_ns = t.boundary_ns;
    }
    auto& s = statistics_.series;
    s[0].add(t.woken_ns - t.boundary_ns);
    s[1].add(t.read_ns - t.woken_ns);
    s[2].add(t.navigated_ns - t.read_ns);
    s[3].add(t.ready_ns - t.navigated_ns);
    s[4].add(t.ready_ns - t.boundary_ns);
    const std::int64_t due_ns = before_.boundary_ns + before_.offset_ns;
    if (before_.frame + 1 == t.frame && t.released_ns >= due_ns) s[5].add(t.released_ns - due_ns);
    ++statistics_.frames;
    statistics_.overruns = t.overruns - base_.overruns;
    statistics_.repeated = t.commands_repeated - base_.commands_repeated;
    statistics_.skipped = t.frames_skipped - base_.frames_skipped;
    statistics_.held = t.frames_held - base_.frames_held;
    statistics_.until_ns = t.boundary_ns;
    statistics_.offset_ns = t.offset_ns;
    before_ = t;
  }
  void reset() noexcept { statistics_ = {.period_ns = statistics_.period_ns}; }
  void set_period(std::int64_t period_ns) noexcept { statistics_.period_ns = period_ns; }
  const TimingStatistics& statistics() const noexcept { return statistics_; }

 private:
  TimingStatistics statistics_;
  Points before_{}, base_{};
};

}  // namespace lss
