#include "tools/lss-cli/session/waker.h"

#include <fmt/format.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/signalfd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <thread>

#include "drivers/file.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

void wake(void* fd) {
  const std::uint64_t one = 1;
  // A full pipe has already woken it.
  [[maybe_unused]] const ssize_t written = write(*static_cast<int*>(fd), &one, sizeof one);
}

sigset_t interrupts() {
  sigset_t set;
  sigemptyset(&set);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set, signal);
  return set;
}

}  // namespace

// Wakes the waiter at each signal, which it leaves to it: simulated time may stand still.
class Waker::Rouser {
 public:
  Rouser(int signal_fd, lockstep::Waiter& waiter) : waiter_(waiter) {
    for (const int fd : {signal_fd, end_.get()}) {
      epoll_event event{};
      event.events = EPOLLIN | EPOLLET;
      event.data.fd = fd;
      if (::epoll_ctl(poll_.get(), EPOLL_CTL_ADD, fd, &event) != 0)
        throw Failure(ExitCode::internal, "no file descriptors left");
    }
    thread_ = std::thread([this] { run(); });
  }
  ~Rouser() {
    int end = end_.get();
    wake(&end);
    thread_.join();
  }
  Rouser(const Rouser&) = delete;
  Rouser& operator=(const Rouser&) = delete;

 private:
  void run() {
    epoll_event event{};
    while (true) {
      if (::epoll_wait(poll_.get(), &event, 1, -1) != 1) continue;
      if (event.data.fd == end_.get()) return;
      waiter_.wake();
    }
  }

  lockstep::Waiter& waiter_;
  const File poll_{::epoll_create1(EPOLL_CLOEXEC)}, end_{::eventfd(0, EFD_CLOEXEC)};
  std::thread thread_;
};

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
  rouser_.reset();
  dds_delete_listener(listener_);
  close(news_fd_);
  close(signal_fd_);
  const sigset_t set = interrupts();
  pthread_sigmask(SIG_UNBLOCK, &set, nullptr);
}

void Waker::take_part(const std::string& folder, const std::string& source) {
  if (const std::string error = lockstep::join_as_client(folder); !error.empty())
    throw Failure(ExitCode::unreachable, error);
  const Clock::time_point now = Clock::now();
  part_ = std::make_unique<lockstep::Part>("client");
  client_ = std::make_unique<lockstep::Client>(source);
  if (!client_->has_place()) {
    client_.reset();
    part_.reset();
    throw Failure(
        ExitCode::unreachable,
        fmt::format("{} programs take part as clients in this simulated time, no more can",
                    lockstep::kMostClients),
        "stop one of them, or wait until one has ended");
  }
  rouser_ = std::make_unique<Rouser>(signal_fd_, waiter_);
  Clock::ahead_ns = now.time_since_epoch().count() - lockstep::now();
}

Waker::Result Waker::wait(Clock::time_point until, int input_fd) {
  using std::chrono::milliseconds;
  if (client_) return wait_in_simulation(until, input_fd);
  const auto left = std::chrono::ceil<milliseconds>(until - Clock::now()).count();
  return poll(static_cast<int>(std::clamp<std::int64_t>(left, 0, 1'000'000)), input_fd);
}

Waker::Result Waker::wait_in_simulation(Clock::time_point until, int input_fd) {
  waiter_.wait(until.time_since_epoch().count() - Clock::ahead_ns);
  if (lockstep::over()) throw Failure(ExitCode::unreachable, "the simulation has ended");
  return poll(0, input_fd);
}

Waker::Result Waker::poll(int timeout_ms, int input_fd) {
  std::array<pollfd, 3> fds{
      {{news_fd_, POLLIN, 0}, {signal_fd_, POLLIN, 0}, {input_fd, POLLIN, 0}}};
  Result result;
  if (::poll(fds.data(), fds.size(), timeout_ms) <= 0) return result;
  std::uint64_t news = 0;
  if (fds[0].revents != 0) [[maybe_unused]]
    const ssize_t n = read(news_fd_, &news, sizeof news);
  signalfd_siginfo info{};
  result.interrupted = fds[1].revents != 0 && read(signal_fd_, &info, sizeof info) == sizeof info;
  was_interrupted_ = was_interrupted_ || result.interrupted;
  result.input = fds[2].revents != 0;
  return result;
}

}  // namespace lss::cli
