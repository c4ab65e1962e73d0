#pragma once

// A DDS domain that no other test uses at the same time.

#include <gtest/gtest.h>
#include <unistd.h>

#include "tests/cli/fake_daemon.h"
#include "tests/cli/program.h"
#include "tools/lss-cli/waker.h"

namespace lss::cli::test {

class ProgramTest : public testing::Test {
 protected:
  // Tests run side by side are processes of their own; below 100 is left to people.
  static int domain() { return 100 + static_cast<int>(getpid() % 130); }
  static Ended run(const std::vector<std::string>& arguments, const std::string& input = "") {
    return test::run(domain(), arguments, input);
  }
  // Bounded; false when it never became true.
  template <class Condition>
  static bool await(Condition condition) {
    const Clock::time_point until = Clock::now() + seconds(20);
    while (!condition() && Clock::now() < until)
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
  }
};

}  // namespace lss::cli::test
