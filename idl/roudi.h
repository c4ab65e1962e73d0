#pragma once

// Looks for RouDi, iceoryx' shared-memory broker, without joining it. Cyclone DDS aborts the
// process when it is to use shared memory and RouDi does not answer, so everybody looks first. Any
// thread, start-up or about ten times a second: three system calls, no wait, nothing that RouDi
// could notice.

#include <sys/types.h>

#include <cstdint>
#include <optional>

namespace lss::dds {

// Tells one RouDi from the next: every start binds a new socket file. The inode number alone does
// not do, since file systems hand a freed one out again at once.
struct RoudiIdentity {
  dev_t device = 0;
  ino_t inode = 0;
  std::int64_t created_ns = 0;

  bool operator==(const RoudiIdentity&) const = default;
};

// The RouDi that lives now and that this user may talk to. Empty when there is none.
std::optional<RoudiIdentity> find_roudi();

}  // namespace lss::dds
