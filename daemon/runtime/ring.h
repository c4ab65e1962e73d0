#pragma once

// A bounded stream from one thread to another: Boost's single-producer single-consumer queue,
// wait-free, that drops and counts when it is full, so that a slow reader can never delay the
// writer.

#include <atomic>
#include <boost/lockfree/policies.hpp>
#include <boost/lockfree/spsc_queue.hpp>
#include <cstdint>
#include <type_traits>

namespace lss {

template <class T, std::size_t N>
class Ring {
  static_assert(std::is_trivially_copyable_v<T>);

 public:
  // Writer thread only. False: full, the value was dropped and counted.
  bool push(const T& value) noexcept {
    if (queue_.push(value)) return true;
    dropped_.fetch_add(1, std::memory_order_relaxed);
    return false;
  }

  // Writer thread only. How many more it takes now.
  std::size_t room() const noexcept { return queue_.write_available(); }

  // Reader thread only. How many wait, at least.
  std::size_t waiting() const noexcept { return queue_.read_available(); }

  // Reader thread only. False: empty.
  bool pop(T& value) noexcept { return queue_.pop(value); }

  // Reader thread only. The oldest value, if there is one and `take` accepts it.
  template <class Predicate>
  bool pop_if(T& value, Predicate&& take) noexcept {
    if (queue_.read_available() == 0 || !take(queue_.front())) return false;
    return queue_.pop(value);
  }

  // Any thread.
  std::uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }

 private:
  boost::lockfree::spsc_queue<T, boost::lockfree::capacity<N>> queue_;
  std::atomic<std::uint64_t> dropped_{0};
};

}  // namespace lss
