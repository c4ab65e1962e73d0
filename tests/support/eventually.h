#pragma once

// Waiting for other programs, and the one RouDi that a machine can have.

#include <fcntl.h>
#include <grp.h>
#include <sys/file.h>
#include <unistd.h>

#include <chrono>
#include <functional>
#include <string>
#include <thread>

#include "idl/roudi.h"

namespace lss::testing_support {

// What has not come by then never will: beside endless compilers a busy second took half a minute.
inline constexpr std::chrono::seconds kHung{120};

// Polls every 2 ms; false when the condition did not come true in time.
inline bool eventually(const std::function<bool()>& condition, std::chrono::seconds limit = kHung) {
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  }
  return true;
}

// The lock that all who need a RouDi, or none, share; until the process no longer needs it.
class RoudiLock {
 public:
  // Not locked when it was not free in time, or another RouDi runs.
  explicit RoudiLock(std::chrono::seconds limit) : fd_(::open(kFile, O_RDONLY | O_CLOEXEC)) {
    // Not made by the first call: the kernel refuses to "create" a file that another user's run
    // left in /tmp.
    if (fd_ < 0) fd_ = ::open(kFile, O_RDONLY | O_CREAT | O_CLOEXEC, 0644);
    // That of the test before us may be dying still.
    locked_ = fd_ >= 0 && eventually([&] { return ::flock(fd_, LOCK_EX | LOCK_NB) == 0; }, limit) &&
              eventually([] { return !dds::find_roudi(); }, limit);
  }
  // A killed RouDi leaves files that the RouDi of another user could not replace.
  ~RoudiLock() {
    if (locked_) {
      const group* own = ::getgrgid(::getegid());
      const std::string segment = std::string("/dev/shm/") + (own != nullptr ? own->gr_name : "");
      for (const std::string& file :
           {std::string("/dev/shm/iceoryx_mgmt"), segment, std::string("/tmp/roudi"),
            std::string("/tmp/roudi.lock"), std::string("/tmp/iox-unique-roudi.lock")}) {
        if (!dds::find_roudi()) ::unlink(file.c_str());  // never those of a running one
      }
    }
    if (fd_ >= 0) ::close(fd_);
  }
  RoudiLock(const RoudiLock&) = delete;
  RoudiLock& operator=(const RoudiLock&) = delete;
  bool is_locked() const { return locked_; }

 private:
  static constexpr const char* kFile = "/tmp/lss-test-roudi.lock";
  int fd_;
  bool locked_ = false;
};

}  // namespace lss::testing_support
