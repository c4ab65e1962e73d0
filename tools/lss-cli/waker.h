#pragma once

// The one place where lss-cli waits: for news on DDS, for Ctrl-C and for the keyboard. While it
// lives, SIGINT, SIGTERM and SIGHUP are blocked in this thread and in those it starts, and are seen
// by wait() only: create it before any DDS entity. Main thread only, but for the listener, which
// Cyclone's threads call.

#include <dds/dds.h>

#include <chrono>

namespace lss::cli {

using Clock = std::chrono::steady_clock;

constexpr Clock::duration seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

class Waker {
 public:
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  // Wakes wait() on data and matches of the entities that have it.
  const dds_listener_t* listener() const { return listener_; }

  struct Result {
    bool interrupted = false;
    bool input = false;  // something to read from input_fd
  };
  // Until one of these, news on DDS, or the time is over.
  Result wait(Clock::time_point until, int input_fd = -1);

 private:
  int news_fd_ = -1, signal_fd_ = -1;
  dds_listener_t* listener_ = nullptr;
};

}  // namespace lss::cli
