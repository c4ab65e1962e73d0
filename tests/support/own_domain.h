#pragma once

// A DDS domain that no other test on this machine uses at the same time: the test has a lock on a
// file of its number until it ends. tests/e2e/rig.py takes those from 60 on in the same way.

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <map>
#include <stdexcept>
#include <string>

namespace lss::testing_support {

// `index`: for a test that needs several; each is another.
inline int own_domain(int index = 0) {
  static std::map<int, int> own;
  if (const auto known = own.find(index); known != own.end()) return known->second;
  for (int domain = 1; domain < 60; ++domain) {
    const std::string path = "/tmp/lss-e2e-domain-" + std::to_string(domain) + ".lock";
    const int file = ::open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
    if (file >= 0 && ::flock(file, LOCK_EX | LOCK_NB) == 0) return own[index] = domain;
    if (file >= 0) ::close(file);
  }
  throw std::runtime_error("no DDS domain from 1 to 59 is free");
}

}  // namespace lss::testing_support
