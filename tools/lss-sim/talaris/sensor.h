#pragma once

// What the sensors of TALARIS on serial lines share: their faults, and the messages that they send
// by themselves. step() of each from the physics thread, all functions of LineDevice from the
// line's thread, faults from any: one lock.

#include <atomic>
#include <cstdint>
#include <deque>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "tools/lss-sim/frame/uart.h"

namespace lss::sim::talaris {

template <class Faults>
class Sensor : public LineDevice {
 public:
  std::span<const std::uint8_t> send(TimeNs) override {
    const std::lock_guard lock(mutex_);
    waiting_ = is_due();
    if (!waiting_) return {};
    sent_ = std::move(outbox_.front().bytes);
    outbox_.pop_front();
    waiting_ = is_due();
    return sent_;
  }
  bool wants_to_send() const override { return waiting_; }

  void set_faults(const Faults& faults) {
    const std::lock_guard lock(mutex_);
    faults_ = faults;
  }
  Faults faults() const {
    const std::lock_guard lock(mutex_);
    return faults_;
  }

 protected:
  // To be sent after so many milliseconds; the oldest is lost when nobody reads. Locked.
  void queue(std::span<const std::uint8_t> message, int due_ms = 0) {
    constexpr std::size_t kMost = 4;
    if (outbox_.size() >= kMost) outbox_.pop_front();
    outbox_.push_back({{message.begin(), message.end()}, due_ms});
    waiting_ = is_due();
  }
  void pass_millisecond() {  // locked
    for (Message& message : outbox_) --message.due_ms;
    waiting_ = is_due();
  }

  mutable std::mutex mutex_;
  Faults faults_;

 private:
  struct Message {
    std::vector<std::uint8_t> bytes;
    int due_ms = 0;
  };
  bool is_due() const { return !outbox_.empty() && outbox_.front().due_ms <= 0; }

  std::deque<Message> outbox_;
  std::vector<std::uint8_t> sent_;
  std::atomic<bool> waiting_ = false;
};

}  // namespace lss::sim::talaris
