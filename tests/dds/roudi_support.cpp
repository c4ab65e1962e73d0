#include "tests/dds/roudi_support.h"

#include <dlfcn.h>
#include <sys/socket.h>
#include <unistd.h>
#include <zebro.h>  // of the IDL

#include <csignal>
#include <cstdio>
#include <filesystem>
#include <string>

namespace {
thread_local std::uint64_t sent_by_this_thread = 0;
}  // namespace

// Overrides the C library's function, so that the test sees Cyclone's messages and their threads.
extern "C" ssize_t sendmsg(int fd, const msghdr* message, int flags) {
  using Function = ssize_t (*)(int, const msghdr*, int);
  static const auto kNext = reinterpret_cast<Function>(::dlsym(RTLD_NEXT, "sendmsg"));
  ++sent_by_this_thread;
  return kNext(fd, message, flags);
}

namespace lss::testing_support {

Alone::Alone() : lock_(std::chrono::minutes(10)) {
  require(lock_.is_locked(), "no RouDi but ours on this machine while its tests run");
}

Roudi::Roudi()
    : log_file_(std::filesystem::temp_directory_path() /
                ("lss-test-roudi-" + std::to_string(::getpid()) + ".log")) {
  process_.emplace(std::vector<std::string>{
      "sh", "-c", "exec iox-roudi -c " ROUDI_CONFIG " > " + log_file_ + " 2>&1"});
  require(eventually([] { return dds::find_roudi().has_value(); }), "RouDi starts");
}

Roudi::~Roudi() {
  kill();
  std::filesystem::remove(log_file_);
}

void Roudi::kill() {
  process_.reset();
  require(!dds::find_roudi(), "a killed RouDi is not found");
}

Publisher::Publisher(Face& face)
    : face_(face), thread_([this](const std::stop_token& stop) {
        lss_ZebroTelemetry telemetry{};
        while (!stop.stop_requested()) {
          if (stops_process_.exchange(false)) ::raise(SIGSTOP);  // before it returns
          ++telemetry.frame;
          face_.telemetry(&telemetry);
          face_.timing(TimingPoints{});
          if (face_.watch_shared_memory()) ++changes_;
          samples_ = telemetry.frame;
          datagrams_ = sent_by_this_thread;
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
      }) {}

Publisher::~Publisher() = default;

void require(bool truth, const std::string& what) {
  if (truth) return;
  std::fprintf(stderr, "not so: %s\n", what.c_str());
  ::_exit(3);
}

}  // namespace lss::testing_support
