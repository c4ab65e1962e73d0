#include "tests/bench/realtime.h"

#include <fcntl.h>
#include <stdlib.h>
#include <termios.h>
#include <unistd.h>

#include <ctime>
#include <thread>

#include "drivers/time.h"

namespace lss::bench {

int measured_cpu() { return static_cast<int>(std::thread::hardware_concurrency()) - 1; }

void prepare_real_time() {
  if (auto ok = rt::lock_memory(); !ok) throw NotHere(ok.error());
  rt::populate_memory();
  rt::Thread probe;
  if (auto ok = probe.start({.name = "probe", .priority = kActuatePriority, .cpu = measured_cpu()},
                            true, [] {});
      !ok)
    throw NotHere(ok.error());
}

Fifo::Fifo(const std::string& name, int priority, int cpu, std::function<void()> body) {
  if (auto ok =
          thread_.start({.name = name, .priority = priority, .cpu = cpu}, true, std::move(body));
      !ok)
    throw NotHere(ok.error());
}

double thread_cpu_s() {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + static_cast<double>(t.tv_nsec) * 1e-9;
}

Terminal::Terminal() {
  master_ = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  char name[64];
  if (master_ < 0 || ::grantpt(master_) != 0 || ::unlockpt(master_) != 0 ||
      ::ptsname_r(master_, name, sizeof name) != 0)
    throw NotHere("no pseudo-terminal can be made here: check /dev/pts");
  name_ = name;
  slave_ = ::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC);
  termios settings{};
  ::tcgetattr(slave_, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave_, TCSANOW, &settings);
}

Terminal::~Terminal() {
  ::close(slave_);
  ::close(master_);
}

}  // namespace lss::bench
