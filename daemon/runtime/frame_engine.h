#pragma once

// The frame-offset loop (TALARIS thesis 4.3 and 5.1.3): the frame thread computes the command of
// frame k from T_k on, the actuate thread releases it at T_k + offset, never earlier and never
// "when ready", so that a stochastic delay becomes a known constant. When a command is not ready,
// the one before is repeated once; when late again, nothing is released and the bus notices its
// stale orders. A command waits for its release as two copies with a checksum: a bit that radiation
// flips there is corrected, and a command that is damaged otherwise is not released. Frames: of
// daemon/runtime/frames.h.
//
// frame() and actuate() are the bodies of the two threads; nothing in here allocates, locks or
// logs.

#include <atomic>
#include <cstdint>
#include <type_traits>
#include <utility>

#include "daemon/cycle/messages.h"
#include "daemon/cycle/twins.h"
#include "daemon/runtime/frames.h"
#include "daemon/runtime/latest.h"

namespace lss {

struct FrameParameters {
  TimeNs period_ns = 20 * kMillisecond;
  TimeNs offset_ns = 5 * kMillisecond;
  int max_consecutive_overruns = 5;
  TimeNs frame_spin_ns = 0, actuate_spin_ns = 0;
};

// Report of the actuate thread to the frame thread.
struct Released {
  TimeNs released_ns = 0;  // of the last frame
  std::uint64_t overruns = 0, repeated = 0;
  std::uint64_t limits = 0;  // how often too many were late in a row
  bool limit = false;        // frame thread: again, since the frame before
};

template <class Frames, class Command>
class FrameEngine {
 public:
  FrameEngine(Frames& frames, const FrameParameters& parameters) noexcept
      : frames_(frames), parameters_(parameters), overruns_(parameters.max_consecutive_overruns) {}

  // compute(Boundary, Released, TimingPoints&) -> Command computes the command and stamps read and
  // navigated; say(TimingPoints) runs after the command was stored.
  template <class Compute, class Say>
  void frame(Compute&& compute, Say&& say) noexcept {
    auto follower = frames_.follow_frame(parameters_.frame_spin_ns);
    while (!stopped()) {
      const Boundary boundary = follower.next(0);
      if (!stopped()) begin(boundary, compute, say);
    }
  }

  // release(Command) hands it to the buses; or release(Command, Boundary), where a repeated command
  // has the boundary of an earlier frame.
  template <class Release>
  void actuate(Release&& release) noexcept {
    auto follower = frames_.follow_actuate(parameters_.actuate_spin_ns);
    while (!stopped()) {
      const Boundary boundary = follower.next(parameters_.offset_ns);
      if (!stopped()) due(boundary, release);
    }
  }
  // With work of the thread between releases (NoWork in frames.h explains it).
  template <class Release, class Work>
  void actuate(Release&& release, Work& work) noexcept {
    auto follower = frames_.follow_actuate(parameters_.actuate_spin_ns);
    while (!stopped()) {
      const Boundary boundary = follower.next(parameters_.offset_ns, work);
      if (!stopped()) due(boundary, release);
    }
  }

  // One frame of the frame thread, at its boundary.
  template <class Compute, class Say>
  void begin(const Boundary& boundary, Compute&& compute, Say&& say) noexcept {
    timing_.offset_ns = parameters_.offset_ns;
    timing_.woken_ns = now_ns();
    timing_.frame = boundary.frame;
    timing_.boundary_ns = boundary.time_ns;
    timing_.frames_skipped += boundary.skipped;
    timing_.frames_held += boundary.held ? 1 : 0;
    Released released = released_.get();
    released.limit = std::exchange(limits_seen_, released.limits) != released.limits;
    released.limit |= timing_.woken_ns - boundary.time_ns >=
                      parameters_.max_consecutive_overruns * parameters_.period_ns;
    timing_.released_ns = released.released_ns;
    timing_.overruns = released.overruns;
    timing_.commands_repeated = released.repeated;
    due_.put(Sealed<Due>(
        {.boundary_ns = boundary.time_ns, .command = compute(boundary, released, timing_)}));
    timing_.ready_ns = now_ns();
    timing_.margin_ns = boundary.time_ns + parameters_.offset_ns - timing_.ready_ns;
    say(timing_);
    count_.fetch_add(1, std::memory_order_relaxed);
  }

  // One frame of the actuate thread, at its release.
  template <class Release>
  void due(const Boundary& boundary, Release&& release) noexcept {
    // Releases that were slept through are late as well: a standstill of the machine is an overrun.
    Due due;
    const bool whole = due_.get().open(due);
    bool limit = due.boundary_ns != 0 && boundary.skipped != 0 && overruns_.late(boundary.skipped);
    if (!whole) {
      limit = overruns_.late() || limit;
    } else if (due.boundary_ns == boundary.time_ns) {
      overruns_.in_time();
      hand(release, due.command, boundary);
    } else if (due.boundary_ns != 0) {  // before the first frame nothing is late
      limit = overruns_.late() || limit;
      if (overruns_.consecutive() == 1) {
        ++report_.repeated;
        hand(release, due.command, boundary);
      }
    }
    report_.limits += limit ? 1 : 0;
    report_.released_ns = now_ns();
    report_.overruns = overruns_.total();
    released_.put(report_);
    releases_.fetch_add(1, std::memory_order_relaxed);
  }

  void stop() noexcept {
    stop_.store(true, std::memory_order_relaxed);
    if constexpr (requires { frames_.stop(); }) frames_.stop();
  }
  // Frames computed and released so far; any thread.
  std::uint64_t frames() const noexcept { return count_.load(std::memory_order_relaxed); }
  std::uint64_t releases() const noexcept { return releases_.load(std::memory_order_relaxed); }

 private:
  bool stopped() const noexcept { return stop_.load(std::memory_order_relaxed); }

  struct Due {
    TimeNs boundary_ns = 0;  // 0: none yet
    Command command{};
  };

  template <class Release>
  static void hand(Release& release, const Command& command, const Boundary& boundary) noexcept {
    if constexpr (std::is_invocable_v<Release&, const Command&, const Boundary&>) {
      release(command, boundary);
    } else {
      release(command);
    }
  }

  Frames& frames_;
  FrameParameters parameters_;
  TimingPoints timing_;  // frame thread
  std::uint64_t limits_seen_ = 0;
  OverrunCounter overruns_;  // actuate thread, with its report
  Released report_;
  Latest<Sealed<Due>> due_;
  Latest<Released> released_;
  std::atomic<std::uint64_t> count_{0}, releases_{0};
  std::atomic<bool> stop_{false};
};

}  // namespace lss
