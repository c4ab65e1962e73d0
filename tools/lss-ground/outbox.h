#pragma once

// The messages that wait to be sent to one client. Of periodic messages (telemetry, status) only
// the newest waits; all others wait in order, up to a limit. Nothing here blocks: a client that
// stops reading costs the memory of its outbox and is dropped after some time. Event loop only.

#include <chrono>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace lss::ground {

using Clock = std::chrono::steady_clock;

// A text or bytes, with space before them for the frame header that the server writes in place;
// shared between clients.
class Frame {
 public:
  explicit Frame(std::string_view text, bool binary = false);
  unsigned char* text() { return bytes_.data() + kRoom; }
  std::size_t size() const { return bytes_.size() - kRoom; }
  bool binary() const { return binary_; }

 private:
  static constexpr std::size_t kRoom = 32;  // of which the server needs LWS_PRE
  std::vector<unsigned char> bytes_;
  bool binary_;
};
using FramePtr = std::shared_ptr<Frame>;

class Outbox {
 public:
  static constexpr std::size_t kDepth = 1024;  // 256 events of each of three vehicles, and more
  static constexpr std::size_t kBytes = 4 << 20;
  static constexpr Clock::duration kPatience = std::chrono::seconds(5);

  // False: no space; the client is too slow for messages that must not be lost.
  bool push(FramePtr frame, Clock::time_point now);
  // Replaces the waiting message with the same key.
  bool push_newest(const std::string& key, FramePtr frame, Clock::time_point now);

  bool empty() const { return items_.empty(); }
  // For what can wait: all of a vehicle fits besides.
  bool roomy() const { return items_.size() < kDepth / 4 && bytes_ < kBytes / 4; }
  FramePtr pop(Clock::time_point now);
  // Messages wait, and the client has read none for too long.
  bool stalled(Clock::time_point now) const { return !empty() && now - moved_ > kPatience; }

  std::uint64_t replaced() const { return replaced_; }

 private:
  struct Item {
    std::string key;  // empty: must not be lost
    FramePtr frame;
  };
  bool add(Item item, Clock::time_point now);

  std::deque<Item> items_;
  std::size_t bytes_ = 0;
  Clock::time_point moved_{};  // when it was last empty, or a message was taken
  std::uint64_t replaced_ = 0;
};

// Rate limit: messages a second, and messages at once.
class RateLimit {
 public:
  RateLimit(double per_s, double at_once) : per_s_(per_s), at_once_(at_once), left_(at_once) {}
  bool take(Clock::time_point now);

 private:
  double per_s_, at_once_, left_;
  Clock::time_point before_{};
};

}  // namespace lss::ground
