#include "tests/cli/program.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <stdexcept>

namespace lss::cli::test {
namespace {

struct Pipe {
  int read_fd = -1, write_fd = -1;
  Pipe() {
    std::array<int, 2> fds{};
    if (pipe2(fds.data(), O_CLOEXEC) != 0) throw std::runtime_error("no pipe");
    read_fd = fds[0];
    write_fd = fds[1];
  }
};

std::thread drain(int fd, std::string& text) {
  return std::thread([fd, &text] {
    std::array<char, 4096> buffer{};
    for (ssize_t n = 0; (n = read(fd, buffer.data(), buffer.size())) > 0;)
      text.append(buffer.data(), static_cast<std::size_t>(n));
    close(fd);
  });
}

}  // namespace

Program::Program(int domain, const std::vector<std::string>& arguments, const std::string& input) {
  const Pipe in;
  begin(domain, arguments, in.read_fd);
  close(in.read_fd);
  [[maybe_unused]] const ssize_t written = write(in.write_fd, input.data(), input.size());
  close(in.write_fd);
}

Program::Program(int domain, const std::vector<std::string>& arguments, int input_fd) {
  begin(domain, arguments, input_fd);
}

void Program::begin(int domain, const std::vector<std::string>& arguments, int input_fd) {
  const Pipe out, err;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, input_fd, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, out.write_fd, STDOUT_FILENO);
  posix_spawn_file_actions_adddup2(&actions, err.write_fd, STDERR_FILENO);
  std::vector<std::string> words = {LSS_CLI};
  // A busy machine is no finding: a program has a minute, unless its test says how long.
  if (std::ranges::find(arguments, "--timeout") == arguments.end())
    words.insert(words.end(), {"--timeout", "60s"});
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  setenv("LSS_DOMAIN", std::to_string(domain).c_str(), 1);
  const int error = posix_spawn(&pid_, LSS_CLI, &actions, nullptr, argv.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  for (const int fd : {out.write_fd, err.write_fd}) close(fd);
  if (error != 0) throw std::runtime_error("cannot run " LSS_CLI);
  out_ = drain(out.read_fd, ended_.out);
  err_ = drain(err.read_fd, ended_.err);
}

Program::~Program() {
  if (pid_ > 0) {
    signal(SIGKILL);
    wait();
  }
}

void Program::signal(int number) const { kill(pid_, number); }

Ended Program::wait() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  out_.join();
  err_.join();
  ended_.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return ended_;
}

}  // namespace lss::cli::test
