#pragma once

// The only place where lss-cli waits: for news on DDS, for Ctrl-C and for the keyboard. During its
// lifetime SIGINT, SIGTERM and SIGHUP are blocked in this thread and in those it starts, and only
// wait() receives them: create it before any DDS entity. Main thread only, except for the listener,
// which Cyclone's threads call. In simulated time a thread wakes the main thread for a signal.

#include <dds/dds.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>

#include "drivers/lockstep/lockstep.h"

namespace lss::cli {

// The monotonic clock, or simulated time once the main thread takes part in it.
struct Clock {
  using duration = std::chrono::nanoseconds;
  using rep = duration::rep;
  using period = duration::period;
  using time_point = std::chrono::time_point<Clock>;
  static constexpr bool is_steady = true;

  static time_point now() {
    if (lockstep::takes_part()) return time_point(duration(lockstep::now() + ahead_ns));
    return time_point(std::chrono::steady_clock::now().time_since_epoch());
  }
  static inline TimeNs ahead_ns = 0;  // of simulated time
};

// At most 31 years, which can be added to any time.
constexpr Clock::duration seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(
      std::chrono::duration<double>(std::min(s, 1e9)));
}

class Waker {
 public:
  Waker();
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  // Wakes wait() on data and matches of its entities.
  const dds_listener_t* listener() const { return listener_; }

  struct Result {
    bool interrupted = false;
    bool input = false;  // data to read from input_fd
  };
  // Until one of these, news on DDS, or the end of the time.
  Result wait(Clock::time_point until, int input_fd = -1);

  // The same, on the wall clock.
  Result poll(int timeout_ms, int input_fd = -1);

  // Whether a wait was interrupted since the beginning, or since this was forgotten.
  bool was_interrupted() const { return was_interrupted_; }
  void forget_interruption() { was_interrupted_ = false; }

  // From here on uses the simulated time of lss-sim in that folder, under that name. Throws on
  // errors. `source` numbers its commands and heartbeats from 1.
  void take_part(const std::string& folder, const std::string& source);
  // nullptr: in wall-clock time.
  lockstep::Client* simulation() { return client_.get(); }

 private:
  class Rouser;

  Result wait_in_simulation(Clock::time_point until, int input_fd);

  std::unique_ptr<lockstep::Part> part_;
  std::unique_ptr<lockstep::Client> client_;
  lockstep::Waiter waiter_;
  std::unique_ptr<Rouser> rouser_;
  int news_fd_ = -1, signal_fd_ = -1;
  bool was_interrupted_ = false;
  dds_listener_t* listener_ = nullptr;
};

}  // namespace lss::cli
