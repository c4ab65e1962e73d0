#include "tools/lss-ground/outbox.h"

#include <algorithm>
#include <cstring>

namespace lss::ground {

Frame::Frame(std::string_view text, bool binary) : bytes_(kRoom + text.size()), binary_(binary) {
  std::memcpy(bytes_.data() + kRoom, text.data(), text.size());
}

bool Outbox::add(Item item, Clock::time_point now) {
  if (items_.empty()) moved_ = now;
  if (items_.size() >= kDepth || bytes_ + item.frame->size() > kBytes) return false;
  bytes_ += item.frame->size();
  items_.push_back(std::move(item));
  return true;
}

bool Outbox::push(FramePtr frame, Clock::time_point now) {
  return add({"", std::move(frame)}, now);
}

bool Outbox::push_newest(const std::string& key, FramePtr frame, Clock::time_point now) {
  const auto waiting = std::ranges::find(items_, key, &Item::key);
  if (waiting == items_.end()) return add({key, std::move(frame)}, now);
  ++replaced_;
  bytes_ += frame->size() - waiting->frame->size();
  waiting->frame = std::move(frame);
  return true;
}

FramePtr Outbox::pop(Clock::time_point now) {
  FramePtr frame = std::move(items_.front().frame);
  items_.pop_front();
  bytes_ -= frame->size();
  moved_ = now;
  return frame;
}

bool RateLimit::take(Clock::time_point now) {
  if (before_ != Clock::time_point{}) {
    const double passed_s = std::chrono::duration<double>(now - before_).count();
    left_ = std::min(at_once_, left_ + passed_s * per_s_);
  }
  before_ = now;
  if (left_ < 1) return false;
  left_ -= 1;
  return true;
}

}  // namespace lss::ground
