#pragma once

// Where frames begin. ClockFrames: at T_k = epoch + k * period. SensorFrames: when the n-th packet
// of a sensor arrives (TALARIS thesis 4.3: 40 packets of 200 Hz), and by the clock, with the last
// phase, while the sensor is silent. Both keep their phase after an overrun: frames are skipped,
// never shifted.
//
// Both real-time threads follow the frames, each with its own follower: next(lag) returns at T_k +
// lag of the next frame (lag 0: the frame thread; the offset: the actuate thread). With
// SensorFrames the actuate thread may do work while it waits: next(lag, work). Nothing here
// allocates or locks.

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <utility>

#include "daemon/cycle/twins.h"
#include "daemon/runtime/alarm.h"
#include "daemon/runtime/clock.h"
#include "daemon/runtime/frame_clock.h"
#include "daemon/runtime/latest.h"

namespace lss {

struct Boundary {
  std::uint64_t frame = 0;    // counts up from 1
  TimeNs time_ns = 0;         // T_k
  std::uint64_t skipped = 0;  // frames since the one before, slept or worked through
  bool held = false;          // by the clock, the sensor being silent
};

class ClockFrames {
 public:
  explicit ClockFrames(const FrameClock& clock) noexcept : clock_(clock) {}

  class Follower {
   public:
    Follower(const ClockFrames& frames, TimeNs spin_ns) noexcept
        : clock_(frames.clock_), spin_ns_(spin_ns), frame_(clock_.after(0, now_ns()) - 1) {}

    Boundary next(TimeNs lag) noexcept {
      const std::uint64_t frame = clock_.after(frame_, now_ns() - lag);
      const std::uint64_t skipped = frame - frame_ - 1;
      frame_ = frame;
      wait_until(clock_.boundary(frame) + lag, spin_ns_);
      return {frame, clock_.boundary(frame), skipped, false};
    }

   private:
    FrameClock clock_;
    TimeNs spin_ns_;
    std::uint64_t frame_;
  };
  Follower follow_frame(TimeNs spin_ns) const noexcept { return {*this, spin_ns}; }
  Follower follow_actuate(TimeNs spin_ns) const noexcept { return {*this, spin_ns}; }

 private:
  FrameClock clock_;
};

struct SensorFramesParameters {
  std::uint32_t packets = 40;  // make a frame
  TimeNs period_ns = 200 * kMillisecond;
  // After this delay of a packet the frame begins by the clock.
  TimeNs grace_ns = 15 * kMillisecond;
};

// Frame boundaries from the announced packets; pure arithmetic.
class SensorGrid {
 public:
  // `frame`: the number of the last one.
  SensorGrid(const SensorFramesParameters& parameters, TimeNs epoch_ns,
             std::uint64_t frame = 0) noexcept
      : parameters_(parameters),
        last_ns_(epoch_ns),
        deadline_ns_(epoch_ns + parameters.period_ns + parameters.grace_ns),
        frame_(frame) {}

  // Without a packet until then the frame begins by the clock.
  TimeNs deadline() const noexcept { return deadline_ns_; }
  // The n-th packet arrived, `index` counts them. False: too soon after a frame by the clock; its
  // samples are left to the next frame.
  bool arrived(std::uint64_t index, TimeNs time_ns, Boundary& out) noexcept {
    const std::uint64_t missed = index_ == 0 || index <= index_ ? 0 : index - index_ - 1;
    index_ = index;
    const TimeNs next_ns = time_ns + parameters_.period_ns + parameters_.grace_ns;
    if (time_ns - last_ns_ < parameters_.period_ns / 2 && frame_ != 0) {
      deadline_ns_ = next_ns;  // the sensor's phase again
      return false;
    }
    begin(time_ns, held_ ? 0 : missed, false, out);
    deadline_ns_ = next_ns;
    return true;
  }
  // The deadline passed.
  void held(TimeNs now, Boundary& out) noexcept {
    const TimeNs late = now - deadline_ns_;
    const std::uint64_t skipped =
        late < 0 ? 0 : static_cast<std::uint64_t>(late / parameters_.period_ns);
    begin(deadline_ns_ + static_cast<TimeNs>(skipped) * parameters_.period_ns, skipped, true, out);
    deadline_ns_ = last_ns_ + parameters_.period_ns;
  }

 private:
  void begin(TimeNs time_ns, std::uint64_t skipped, bool held, Boundary& out) noexcept {
    frame_ += skipped + 1;
    last_ns_ = time_ns;
    held_ = held;
    out = {frame_, time_ns, skipped, held};
  }

  SensorFramesParameters parameters_;
  TimeNs last_ns_, deadline_ns_;
  std::uint64_t frame_, index_ = 0;
  bool held_ = false;
};

// Work of the actuate thread between releases: next_wake() is the time of the next one, run(now) is
// called then and whenever the thread was woken.
struct NoWork {
  static constexpr TimeNs next_wake() noexcept { return INT64_MAX; }
  static constexpr void run(TimeNs) noexcept {}
};

class SensorFrames {
 public:
  explicit SensorFrames(const SensorFramesParameters& parameters) noexcept
      : parameters_(parameters), epoch_ns_(now_ns()) {}

  // Before the followers run: without a packet the first frame begins a period and the grace later.
  void start(TimeNs epoch_ns) noexcept { epoch_ns_ = epoch_ns; }

  // The bus thread of the sensor: the first byte of a packet arrived then. For sensors that do not
  // number their packets; a lost one shifts the frames after it.
  void packet(TimeNs arrival_ns) noexcept {
    if (++packets_ % parameters_.packets == 0) announce(packets_ / parameters_.packets, arrival_ns);
  }
  // The same thread, when its driver uses the sensor's own numbers: the packet that ends frame
  // `index` (or the next one, when that was lost). Indices count up; a skipped index is a lost
  // frame.
  void announce(std::uint64_t index, TimeNs arrival_ns) noexcept {
    arrived_.post({index, arrival_ns});
  }

  // Any thread: ends all waits.
  void stop() noexcept {
    stopped_.store(true, std::memory_order_relaxed);
    arrived_.alarm().ring();
    begun_.alarm().ring();
  }
  // Frame thread. Both copies of where frames begin were damaged since the last call.
  bool take_memory_lost() noexcept { return std::exchange(memory_lost_, false); }
  // Any thread: the actuate thread's work is run at once.
  void wake_actuate() noexcept { begun_.alarm().ring(); }

 private:
  // The newest value, and an alarm for the thread that waits for it.
  template <class T>
  class Mailbox {
   public:
    void post(const T& value) noexcept {
      value_.put(value);
      alarm_.ring();
    }
    bool take(T& value) noexcept {
      if (!value_.update()) return false;
      value = value_.value();
      return true;
    }
    Alarm& alarm() noexcept { return alarm_; }

   private:
    Latest<T> value_;
    Alarm alarm_;
  };
  struct Arrival {
    std::uint64_t index = 0;
    TimeNs time_ns = 0;
  };

 public:
  // For the frame thread. Passes its decisions to the other follower. While the thread waits or
  // works on a frame, the grid has a second copy; if neither is as it was left, the grid begins
  // again, and the frame thread gets a report.
  class FrameFollower {
   public:
    explicit FrameFollower(SensorFrames& frames) noexcept
        : frames_(frames), grid_(frames.parameters_, frames.epoch_ns_) {
      twin_.seal(bytes_of(grid_));
    }

    Boundary next(TimeNs) noexcept {
      Boundary boundary;
      for (bool over = false;;) {
        check();
        bool begins = over;
        if (Arrival arrival; frames_.arrived_.take(arrival)) {
          begins = grid_.arrived(arrival.index, arrival.time_ns, boundary);
        } else if (over) {
          grid_.held(now_ns(), boundary);
        }
        twin_.seal(bytes_of(grid_));
        if (begins) break;
        if (frames_.stopped()) return boundary;  // no frame begins
        over = !frames_.arrived_.alarm().wait(grid_.deadline(), 0);
      }
      frame_ = boundary.frame;
      frames_.begun_.post(boundary);
      return boundary;
    }

   private:
    void check() noexcept {
      if (twin_.check(bytes_of(grid_)) != MemoryCheck::lost) return;
      const SensorFramesParameters& p = frames_.parameters_;
      grid_ = SensorGrid(p, now_ns() - p.period_ns - p.grace_ns, frame_);  // a frame is due
      frames_.memory_lost_ = true;
    }

    SensorFrames& frames_;
    SensorGrid grid_;
    Twin<sizeof(SensorGrid)> twin_;
    std::uint64_t frame_ = 0;  // the last one
  };

  // For the actuate thread. When the frame thread does not begin a frame in time, the frame has no
  // command.
  class ActuateFollower {
   public:
    ActuateFollower(SensorFrames& frames, TimeNs spin_ns) noexcept
        : frames_(frames), last_{.time_ns = frames.epoch_ns_}, spin_ns_(spin_ns) {}

    Boundary next(TimeNs lag) noexcept {
      NoWork none;
      return next(lag, none);
    }
    // A release and work due at the same time: the release comes first.
    template <class Work>
    Boundary next(TimeNs lag, Work& work) noexcept {
      const SensorFramesParameters& p = frames_.parameters_;
      const TimeNs deadline_ns = last_.time_ns + p.period_ns + 2 * p.grace_ns + lag;
      Boundary boundary;
      for (bool over = false; !begun(boundary, lag); over = reached(deadline_ns, work)) {
        if (over || frames_.stopped())
          return last_ = {last_.frame + 1, last_.time_ns + p.period_ns, 0, true};
      }
      boundary.skipped = boundary.frame > last_.frame ? boundary.frame - last_.frame - 1 : 0;
      while (!frames_.stopped() && !reached(boundary.time_ns + lag, work)) {
      }
      return last_ = boundary;
    }

   private:
    // An abandoned frame may still begin: too late, unless its release is ahead. The time decides,
    // not the number, since an abandoned frame may never have been one.
    bool begun(Boundary& boundary, TimeNs lag) noexcept {
      return frames_.begun_.take(boundary) &&
             (!last_.held || boundary.time_ns > last_.time_ns + frames_.parameters_.period_ns / 2 ||
              boundary.time_ns + lag > now_ns());
    }
    // False: it was woken before the time, and the work is done.
    template <class Work>
    bool reached(TimeNs time_ns, Work& work) noexcept {
      const TimeNs wake_ns = work.next_wake();
      const bool rung = frames_.begun_.alarm().wait(std::min(wake_ns, time_ns), spin_ns_);
      if (!rung && wake_ns >= time_ns) return true;
      work.run(now_ns());
      return false;
    }

    SensorFrames& frames_;
    Boundary last_;
    TimeNs spin_ns_;
  };
  FrameFollower follow_frame(TimeNs) noexcept { return FrameFollower(*this); }
  ActuateFollower follow_actuate(TimeNs spin_ns) noexcept { return {*this, spin_ns}; }

 private:
  bool stopped() const noexcept { return stopped_.load(std::memory_order_relaxed); }

  SensorFramesParameters parameters_;
  TimeNs epoch_ns_;
  std::uint64_t packets_ = 0;  // bus thread
  bool memory_lost_ = false;   // frame thread
  std::atomic<bool> stopped_{false};
  Mailbox<Arrival> arrived_;
  Mailbox<Boundary> begun_;
};

}  // namespace lss
