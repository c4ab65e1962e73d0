#pragma once

// Samples of a bus until its thread takes them; the oldest are dropped. One thread; no allocation.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

namespace lss {

template <class Sample, std::size_t N>
class SampleRing {
 public:
  // False: the oldest one was dropped for it.
  bool put(const Sample& sample) noexcept {
    const bool full = count_ == N;
    if (full) first_ = (first_ + 1) % N;
    count_ -= full ? 1 : 0;
    sample_[(first_ + count_++) % N] = sample;
    return !full;
  }
  std::size_t take(std::span<Sample> out) noexcept {
    const std::size_t count = std::min(out.size(), count_);
    for (std::size_t i = 0; i < count; ++i) out[i] = sample_[(first_ + i) % N];
    first_ = (first_ + count) % N;
    count_ -= count;
    return count;
  }
  void clear() noexcept { count_ = 0; }

 private:
  std::array<Sample, N> sample_{};
  std::size_t first_ = 0, count_ = 0;
};

}  // namespace lss
