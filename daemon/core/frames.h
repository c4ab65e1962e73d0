#pragma once

// Where frames begin. ClockFrames: at T_k = epoch + k * period. SensorFrames: when the n-th packet
// of a sensor arrives (TALARIS thesis 4.3: 40 packets of 200 Hz), and by the clock, in the rhythm
// last seen, while the sensor is silent. Both keep their phase whatever an overrun does: frames
// are skipped, never shifted.
//
// Both real-time threads follow the frames, each with a follower of its own: next(lag) returns at
// T_k + lag of the next frame (lag 0: the frame thread; the offset: the actuate thread). Nothing
// here allocates or locks.

#include <semaphore.h>

#include <cerrno>
#include <cstdint>

#include "daemon/core/clock.h"
#include "daemon/core/frame_clock.h"
#include "daemon/core/latest.h"

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
  // A packet this late is not waited for: the frame begins by the clock.
  TimeNs grace_ns = 15 * kMillisecond;
};

// What a follower makes of the packets that were announced; pure arithmetic.
class SensorGrid {
 public:
  SensorGrid(const SensorFramesParameters& parameters, TimeNs epoch_ns) noexcept
      : parameters_(parameters),
        last_ns_(epoch_ns),
        deadline_ns_(epoch_ns + parameters.period_ns + parameters.grace_ns) {}

  // Without a packet until then the frame begins by the clock.
  TimeNs deadline() const noexcept { return deadline_ns_; }
  // The n-th packet arrived, `index` counting them. False: too soon after a frame by the clock, its
  // samples are left to the next one.
  bool arrived(std::uint64_t index, TimeNs time_ns, Boundary& out) noexcept {
    const std::uint64_t missed = index_ == 0 ? 0 : index - index_ - 1;
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
  std::uint64_t frame_ = 0, index_ = 0;
  bool held_ = false;
};

class SensorFrames {
 public:
  explicit SensorFrames(const SensorFramesParameters& parameters) noexcept
      : parameters_(parameters), epoch_ns_(now_ns()) {}

  // The one bus thread that hears the sensor: a packet whose first byte arrived then.
  void packet(TimeNs arrival_ns) noexcept {
    if (++packets_ % parameters_.packets == 0)
      arrived_.post({packets_ / parameters_.packets, arrival_ns});
  }

 private:
  // The newest value, and somebody who waits for it.
  template <class T>
  class Mailbox {
   public:
    Mailbox() noexcept { ::sem_init(&posted_, 0, 0); }
    ~Mailbox() { ::sem_destroy(&posted_); }
    Mailbox(const Mailbox&) = delete;
    Mailbox& operator=(const Mailbox&) = delete;

    void post(const T& value) noexcept {
      value_.put(value);
      ::sem_post(&posted_);
    }
    // False: nothing new came until the deadline.
    bool take(T& value, TimeNs deadline_ns) noexcept {
      const timespec deadline = to_timespec(deadline_ns);
      while (!value_.update()) {
        if (::sem_clockwait(&posted_, CLOCK_MONOTONIC, &deadline) == 0 || errno == EINTR) continue;
        if (!value_.update()) return false;
        break;
      }
      value = value_.value();
      return true;
    }

   private:
    Latest<T> value_;
    ::sem_t posted_;
  };
  struct Arrival {
    std::uint64_t index = 0;
    TimeNs time_ns = 0;
  };

 public:
  // Of the frame thread. Tells the other one what it decided.
  class FrameFollower {
   public:
    explicit FrameFollower(SensorFrames& frames) noexcept
        : frames_(frames), grid_(frames.parameters_, frames.epoch_ns_) {}

    Boundary next(TimeNs) noexcept {
      Boundary boundary;
      for (;;) {
        Arrival arrival;
        if (!frames_.arrived_.take(arrival, grid_.deadline())) {
          grid_.held(now_ns(), boundary);
          break;
        }
        if (grid_.arrived(arrival.index, arrival.time_ns, boundary)) break;
      }
      frames_.begun_.post(boundary);
      return boundary;
    }

   private:
    SensorFrames& frames_;
    SensorGrid grid_;
  };

  // Of the actuate thread. When the frame thread does not begin a frame in time, the frame is one
  // that nobody computes a command for.
  class ActuateFollower {
   public:
    ActuateFollower(SensorFrames& frames, TimeNs spin_ns) noexcept
        : frames_(frames), last_{.time_ns = frames.epoch_ns_}, spin_ns_(spin_ns) {}

    Boundary next(TimeNs lag) noexcept {
      const SensorFramesParameters& p = frames_.parameters_;
      const TimeNs deadline_ns = last_.time_ns + p.period_ns + 2 * p.grace_ns + lag;
      Boundary boundary;
      do {
        if (!frames_.begun_.take(boundary, deadline_ns))
          return last_ = {last_.frame + 1, last_.time_ns + p.period_ns, 0, true};
      } while (boundary.frame <= last_.frame);  // it was given up already
      boundary.skipped = boundary.frame - last_.frame - 1;
      wait_until(boundary.time_ns + lag, spin_ns_);
      return last_ = boundary;
    }

   private:
    SensorFrames& frames_;
    Boundary last_;
    TimeNs spin_ns_;
  };
  FrameFollower follow_frame(TimeNs) noexcept { return FrameFollower(*this); }
  ActuateFollower follow_actuate(TimeNs spin_ns) noexcept { return {*this, spin_ns}; }

 private:
  SensorFramesParameters parameters_;
  TimeNs epoch_ns_;
  std::uint64_t packets_ = 0;  // bus thread
  Mailbox<Arrival> arrived_;
  Mailbox<Boundary> begun_;
};

}  // namespace lss
