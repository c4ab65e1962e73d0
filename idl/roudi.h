#pragma once

// Looks for RouDi, iceoryx' shared-memory broker, without joining it. Cyclone DDS aborts the
// process when it shall use shared memory and RouDi does not answer, after a minute in which the
// process does nothing, so every program looks first. Any thread.

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <optional>

namespace lss::dds {

// Distinguishes one start of RouDi from the next: each binds a new socket file. The inode number
// alone is not enough, since file systems reuse a freed one at once.
struct RoudiIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  std::int64_t created_ns = 0;

  bool operator==(const RoudiIdentity&) const = default;
};

// The RouDi that runs now and that this user may connect to, also when it hangs. Empty when there
// is none. About ten times a second: three system calls, no wait, no effect on RouDi.
std::optional<RoudiIdentity> find_roudi();

// A message to RouDi, which logs it: "Received Keepalive from unknown process ...". One that hangs
// leaves it in its queue.
class RoudiCall {
 public:
  RoudiCall();
  RoudiCall(const RoudiCall&) = delete;
  RoudiCall& operator=(const RoudiCall&) = delete;
  ~RoudiCall();

  bool sent() const { return sent_; }  // false: there is none, or its queue is full
  bool taken() const;                  // it was read, or RouDi ended

 private:
  int fd_;
  bool sent_;
};

// Waits at most this time for the RouDi that runs now to take a message.
bool roudi_answers(std::chrono::milliseconds limit);

}  // namespace lss::dds
