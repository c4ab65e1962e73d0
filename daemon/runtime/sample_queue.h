#pragma once

// Samples of a bus thread on their way to the frame thread, each with its time of reception
// (`time_ns`). They wait for up to a frame, so each has two copies and a checksum against bits that
// radiation flips; a sample of which neither copy is whole is dropped and counted.

#include <atomic>
#include <cstdint>

#include "daemon/cycle/twins.h"
#include "daemon/runtime/ring.h"
#include "drivers/time.h"

namespace lss {

template <class Sample>
class SampleQueue {
 public:
  // Bus thread. False: full, the sample was dropped and counted.
  bool push(const Sample& sample) noexcept { return ring_.push(Sealed<Sample>(sample)); }

  // Frame thread: the oldest sample stamped before `end`. False: there is none.
  bool pop(Sample& sample, TimeNs end) noexcept {
    bool whole = false;
    const auto due = [&](const Sealed<Sample>& oldest) {
      whole = oldest.open(sample);
      return !whole || sample.time_ns < end;
    };
    for (Sealed<Sample> taken; ring_.pop_if(taken, due);) {
      if (whole) return true;
      lost_.fetch_add(1, std::memory_order_relaxed);
    }
    return false;
  }

  // Any thread.
  std::uint64_t dropped() const noexcept {
    return ring_.dropped() + lost_.load(std::memory_order_relaxed);
  }

 private:
  Ring<Sealed<Sample>, 256> ring_;
  std::atomic<std::uint64_t> lost_{0};
};

}  // namespace lss
