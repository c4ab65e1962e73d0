#include "drivers/can/can_queue.h"

#include <algorithm>

namespace lss {
namespace {

// CANopen's PDOs are sent repeatedly. Other services send a message once.
bool is_pdo(const CanFrame& frame) {
  return !frame.extended && frame.id >= 0x180 && frame.id < 0x580;
}

}  // namespace

template <class Drops>
void CanQueue::drop_if(Drops drops) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    if (!drops(at(i))) at(kept++) = at(i);
  }
  count_ = kept;
}

void CanQueue::push(const CanFrame& frame, TimeNs now, CanCounters& counters) noexcept {
  if (count_ == kLength) {
    bool dropped = false;
    drop_if([&dropped](const Waiting& w) {
      const bool drops = !dropped && is_pdo(w.frame);
      dropped = dropped || drops;
      return drops;
    });
    if (!dropped) {
      first_ = (first_ + 1) % kLength;
      --count_;
    }
    ++counters.dropped_full;
  }
  at(count_++) = {frame, now};
}

bool CanQueue::flush(CanTransport& transport, TimeNs now, CanCounters& counters) noexcept {
  retry_ns_ = kNever;
  if (count_ == 0) return true;
  const std::size_t before = count_;
  drop_if([now](const Waiting& w) { return is_pdo(w.frame) && now - w.since_ns > kStale; });
  counters.dropped_stale += before - count_;
  std::array<CanFrame, 32> batch;
  while (count_ > 0) {
    const std::size_t size = std::min(count_, batch.size());
    for (std::size_t i = 0; i < size; ++i) batch[i] = at(i).frame;
    const CanTransport::Sent sent = transport.send(std::span(batch).first(size), counters);
    first_ = (first_ + sent.frames) % kLength;
    count_ -= sent.frames;
    if (sent.lost) return false;
    if (sent.frames < size) {
      ++counters.retries;
      retry_ns_ = now + kRetry;
      break;
    }
  }
  return true;
}

void CanQueue::clear() noexcept {
  count_ = 0;
  retry_ns_ = kNever;
}

}  // namespace lss
