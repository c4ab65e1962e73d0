#pragma once

// A DDS domain that no other test uses at the same time.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/cli/fake_daemon.h"
#include "tests/cli/program.h"
#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"
#include "tools/lss-cli/session/waker.h"

namespace lss::cli::test {

using nlohmann::json;
using testing::AllOf;
using testing::AnyOf;
using testing::Each;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::IsSupersetOf;
using testing::Not;
using testing::StartsWith;

class ProgramTest : public testing::Test {
 protected:
  static int domain() { return testing_support::own_domain(); }
  static Ended run(const std::vector<std::string>& arguments, const std::string& input = "") {
    return test::run(domain(), arguments, input);
  }
  // In the environment of the programs, during its lifetime.
  class Variable {
   public:
    Variable(const char* name, const char* value) : name_(name) { setenv(name, value, 1); }
    ~Variable() { unsetenv(name_); }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;

   private:
    const char* name_;
  };
  // How long a verb waits that does not hear all: a busy machine needs time to find the others.
  static constexpr const char* kFoundBy = "5s";
  // Bounded; false when it never became true.
  static bool await(const std::function<bool()>& condition) {
    return testing_support::eventually(condition);
  }
};

}  // namespace lss::cli::test
