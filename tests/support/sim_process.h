#pragma once

// Runs lss-sim (LSS_SIM is its path) as a program of its own and reads its output and its truth.
// Test thread only; every wait is bounded.

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "drivers/file.h"
#include "tests/support/temp_folder.h"

namespace lss::sim {

inline constexpr auto kPatience = std::chrono::seconds(20);

// A child process; its stdout and stderr are one stream.
class Process {
 public:
  explicit Process(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), LSS_SIM);
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    int ends[2];
    if (::pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error("pipe");
    output_ = File(ends[0]);
    const File write_end(ends[1]);
    pid_ = ::fork();
    if (pid_ != 0) return;
    ::dup2(write_end.get(), STDOUT_FILENO);
    ::dup2(write_end.get(), STDERR_FILENO);
    ::execv(LSS_SIM, argv.data());
    ::_exit(127);
  }
  ~Process() {
    if (!waited_) ::kill(pid_, SIGKILL);
    wait();
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  // Reads until the text has come or the stream has ended.
  bool says(const std::string& text) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (heard.find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > deadline || !read()) return false;
    }
    return true;
  }
  void signal(int number) { ::kill(pid_, number); }
  // Exit code, or minus the signal that ended it.
  int wait() {
    while (read()) {
    }
    if (!waited_) ::waitpid(pid_, &status_, 0);
    waited_ = true;
    return WIFEXITED(status_) ? WEXITSTATUS(status_) : -WTERMSIG(status_);
  }

  std::string heard;

 private:
  bool read() {
    char buffer[4096];
    const ssize_t bytes = ::read(output_.get(), buffer, sizeof buffer);
    if (bytes > 0) heard.append(buffer, static_cast<std::size_t>(bytes));
    return bytes > 0;
  }

  File output_;
  pid_t pid_ = -1;
  int status_ = 0;
  bool waited_ = false;
};

// It ends at once and says why.
inline void expect_refused(const std::vector<std::string>& arguments, const char* why) {
  Process refused(arguments);
  EXPECT_EQ(refused.wait(), 2) << why;
  EXPECT_THAT(refused.heard, testing::HasSubstr(why));
}

// A simulator of the folder of the test.
class SimProgram : public testing::Test {
 protected:
  // The arguments of this vehicle in the folder.
  std::vector<std::string> arguments(const std::string& vehicle,
                                     const std::vector<std::string>& more) const {
    std::vector<std::string> all = {vehicle, "--dir", folder_.string()};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  // On a CAN bus at any port.
  std::vector<std::string> on_can(const std::string& vehicle, std::vector<std::string> more) const {
    more.insert(more.begin(), {"--can", "udp://127.0.0.1:0"});
    return arguments(vehicle, more);
  }
  // `lss-sim fault`: its exit code.
  int fault(const std::string& text, std::string* said = nullptr) {
    Process process({"fault", "--dir", folder_.string(), text});
    const int code = process.wait();
    if (said != nullptr) *said = process.heard;
    return code;
  }

  static bool within_patience(const std::function<bool()>& condition) {
    const auto deadline = std::chrono::steady_clock::now() + kPatience;
    while (!condition()) {
      if (std::chrono::steady_clock::now() > deadline) return false;
      ::poll(nullptr, 0, 2);
    }
    return true;
  }

  std::filesystem::path truth() const { return folder_ / "truth.jsonl"; }
  // The third line of the truth, of 0.2 s.
  nlohmann::json third_truth() const {
    std::vector<std::string> lines;
    EXPECT_TRUE(within_patience([&] {
      lines.clear();
      std::ifstream file(truth());
      for (std::string line; std::getline(file, line);) lines.push_back(line);
      return lines.size() >= 4;
    }));
    if (lines.size() < 4) return {};
    const auto third = nlohmann::json::parse(lines[2]);
    EXPECT_NEAR(third.at("t_s").get<double>(), 0.2, 1e-9);
    return third;
  }

  testing_support::TempFolder folder_;
};

}  // namespace lss::sim
