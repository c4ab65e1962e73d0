#include "tools/lss-cli/waker.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>

#include "tools/lss-cli/failure.h"

namespace lss::cli {
namespace {

void wake(void* fd) {
  const std::uint64_t one = 1;
  // Full means that it is awake already.
  [[maybe_unused]] const ssize_t written = write(*static_cast<int*>(fd), &one, sizeof one);
}

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

}  // namespace

Waker::Waker() {
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_BLOCK, &set, nullptr);
  signal_fd_ = signalfd(-1, &set, SFD_CLOEXEC | SFD_NONBLOCK);
  news_fd_ = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  listener_ = dds_create_listener(&news_fd_);
  if (signal_fd_ < 0 || news_fd_ < 0 || listener_ == nullptr) {
    throw Failure(ExitCode::internal, "no file descriptors left");
  }
  dds_lset_data_available(listener_, [](dds_entity_t, void* fd) { wake(fd); });
  dds_lset_publication_matched(
      listener_, [](dds_entity_t, dds_publication_matched_status_t, void* fd) { wake(fd); });
}

Waker::~Waker() {
  dds_delete_listener(listener_);
  close(news_fd_);
  close(signal_fd_);
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

Waker::Result Waker::wait(Clock::time_point until, int input_fd) {
  using std::chrono::milliseconds;
  const auto left = std::chrono::ceil<milliseconds>(until - Clock::now()).count();
  std::array<pollfd, 3> fds{
      {{news_fd_, POLLIN, 0}, {signal_fd_, POLLIN, 0}, {input_fd, POLLIN, 0}}};
  const int timeout_ms = static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000));
  Result result;
  if (poll(fds.data(), fds.size(), timeout_ms) <= 0) return result;
  std::uint64_t news = 0;
  if (fds[0].revents != 0) [[maybe_unused]]
    const ssize_t n = read(news_fd_, &news, sizeof news);
  signalfd_siginfo info{};
  result.interrupted = fds[1].revents != 0 && read(signal_fd_, &info, sizeof info) == sizeof info;
  result.input = fds[2].revents != 0;
  return result;
}

}  // namespace lss::cli
