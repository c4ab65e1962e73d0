#pragma once

// Looks for RouDi, iceoryx' shared-memory broker, without joining it. Cyclone DDS aborts the
// process when it shall use shared memory and RouDi does not answer, so every program looks first.
// Any thread, at start-up or about ten times a second: three system calls, no wait, no effect on
// RouDi.

#include <sys/types.h>

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

// The RouDi that runs now and that this user may connect to. Empty when there is none.
std::optional<RoudiIdentity> find_roudi();

}  // namespace lss::dds
