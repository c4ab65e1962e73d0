#pragma once

// Passes the newest value from one thread to another: a triple buffer, wait-free on both sides. One
// writer thread, one reader thread, one slot. The reader gets the newest complete value or, when
// there is no new one, the previous; values in between are lost, by design, and counted. Bound: one
// copy of T on each side.

#include <array>
#include <atomic>
#include <cstdint>
#include <type_traits>

namespace lss {

template <class T>
class Latest {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Writer thread only.
  void put(const T& value) noexcept {
    slots_[writing_] = value;
    const std::uint8_t before =
        middle_.exchange(static_cast<std::uint8_t>(writing_ | kFresh), std::memory_order_acq_rel);
    writing_ = before & kIndex;
    if ((before & kFresh) != 0)
      replaced_.store(replaced_.load(std::memory_order_relaxed) + 1, std::memory_order_relaxed);
  }

  // Reader thread only. True when the value is newer than at the last call.
  bool update() noexcept {
    if ((middle_.load(std::memory_order_relaxed) & kFresh) == 0) return false;
    const std::uint8_t before = middle_.exchange(reading_, std::memory_order_acq_rel);
    reading_ = before & kIndex;
    return true;
  }
  // Values that a newer one replaced before they were read. Any thread.
  std::uint64_t replaced() const noexcept { return replaced_.load(std::memory_order_relaxed); }
  const T& value() const noexcept { return slots_[reading_]; }
  const T& get() noexcept {
    update();
    return value();
  }

 private:
  static constexpr std::uint8_t kIndex = 3, kFresh = 4;

  std::array<T, 3> slots_{};
  alignas(64) std::atomic<std::uint8_t> middle_{1};
  alignas(64) std::uint8_t writing_ = 0;  // writer's own
  std::atomic<std::uint64_t> replaced_{0};
  alignas(64) std::uint8_t reading_ = 2;  // reader's own
};

}  // namespace lss
