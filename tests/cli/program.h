#pragma once

// Runs lss-cli as a program of its own and reads its output. Test threads; waits are bounded by
// CTest.

#include <sys/types.h>

#include <string>
#include <thread>
#include <vector>

namespace lss::cli::test {

struct Ended {
  int code = -1;  // exit code; 128 + signal when it was killed
  std::string out, err;
};

class Program {
 public:
  // LSS_CLI is the path of the program; the domain goes by LSS_DOMAIN.
  Program(int domain, const std::vector<std::string>& arguments, const std::string& input = "");
  // It reads from input_fd, which stays with the caller.
  Program(int domain, const std::vector<std::string>& arguments, int input_fd);
  ~Program();
  Program(const Program&) = delete;
  Program& operator=(const Program&) = delete;

  void signal(int number) const;
  Ended wait();

 private:
  void begin(int domain, const std::vector<std::string>& arguments, int input_fd);

  pid_t pid_ = -1;
  Ended ended_;
  std::thread out_, err_;
};

inline Ended run(int domain, const std::vector<std::string>& arguments,
                 const std::string& input = "") {
  return Program(domain, arguments, input).wait();
}

}  // namespace lss::cli::test
