#include "tools/lss-cli/doctor/probes.h"

#include <fcntl.h>
#include <linux/can.h>
#include <linux/serial.h>
#include <pthread.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <sys/sysmacros.h>
#include <sys/timex.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>
#include <limits>
#include <system_error>
#include <thread>

#include "drivers/file.h"

namespace lss::cli::doctor {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

std::int64_t now_ns(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return now.tv_sec * kSecond_ns + now.tv_nsec;
}

bool is_pseudo_terminal(dev_t device) {
  return major(device) >= 136 && major(device) <= 143;  // UNIX98 slaves
}

// As registered in the kernel. An unregistered device (a pseudo-terminal) may be a terminal.
bool may_be_terminal(const struct stat& file) {
  if (!S_ISCHR(file.st_mode)) return false;
  const std::filesystem::path device = "/sys/dev/char/" + std::to_string(major(file.st_rdev)) +
                                       ":" + std::to_string(minor(file.st_rdev));
  std::error_code error;
  const std::filesystem::path subsystem =
      std::filesystem::read_symlink(device / "subsystem", error);
  return error || subsystem.filename() == "tty";
}

}  // namespace

int ask_fifo(int priority) {
  int error = 0;
  std::thread([&] {
    const sched_param parameter{.sched_priority = priority};
    error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameter);
  }).join();
  return error;
}

double clock_read_ns() {
  constexpr int kBatches = 20, kReads = 500;
  double best_ns = std::numeric_limits<double>::infinity();
  for (int batch = 0; batch < kBatches; ++batch) {
    const std::int64_t begin_ns = now_ns(CLOCK_MONOTONIC);
    std::int64_t end_ns = begin_ns;
    for (int i = 0; i < kReads; ++i) end_ns = now_ns(CLOCK_MONOTONIC);
    best_ns = std::min(best_ns, static_cast<double>(end_ns - begin_ns) / kReads);
  }
  return best_ns;
}

bool clock_synchronised() {
  timex state{};
  return ::adjtimex(&state) != TIME_ERROR && (state.status & STA_UNSYNC) == 0;
}

std::int64_t utc_offset_ns() { return now_ns(CLOCK_REALTIME) - now_ns(CLOCK_MONOTONIC); }

SerialAnswer ask_serial(const std::filesystem::path& path) {
  SerialAnswer answer;
  struct stat file {};
  if (::stat(path.c_str(), &file) != 0) {
    answer.error = errno;
    return answer;
  }
  if (!may_be_terminal(file)) return answer;
  answer.pseudo = is_pseudo_terminal(file.st_rdev);
  const File port(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC));
  if (!port) {
    answer.error = errno;
    return answer;
  }
  answer.terminal = ::isatty(port.get()) == 1;
  serial_struct settings{};
  if (answer.terminal && ::ioctl(port.get(), TIOCGSERIAL, &settings) == 0) {
    answer.low_latency = (settings.flags & static_cast<int>(ASYNC_LOW_LATENCY)) != 0;
  }
  return answer;
}

int ask_can_socket() {
  const File socket(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC, CAN_RAW));
  return socket ? 0 : errno;
}

std::optional<Space> space(const std::filesystem::path& folder) {
  struct statvfs system {};
  if (::statvfs(folder.c_str(), &system) != 0) return std::nullopt;
  return Space{system.f_bavail * system.f_frsize, system.f_blocks * system.f_frsize,
               ::access(folder.c_str(), W_OK | X_OK) == 0};
}

}  // namespace lss::cli::doctor
