#include "daemon/runtime/thread.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <condition_variable>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <mutex>
#include <sstream>
#include <string_view>

#include "drivers/lockstep/lockstep.h"

namespace lss::rt {
namespace {

constexpr std::size_t kTouchedStack = 256 * 1024;
constexpr std::size_t kLargeMapping = 4 * 1024 * 1024;

// The counter of the calling thread; set for threads of this class only.
thread_local std::atomic<std::uint64_t>* own_mallocs = nullptr;

// Requests the settings from the kernel. Returns the refusals, or nothing.
std::string apply(const ThreadRequest& request) {
  std::string refused;
  if (request.priority > 0) {
    const sched_param parameter{.sched_priority = request.priority};
    if (const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameter)) {
      refused = fmt::format(
          "thread {}: SCHED_FIFO {} refused ({}): give the service LimitRTPRIO={} or the user an "
          "rtprio limit, "
          "and check that the control group has a real-time budget",
          request.name, request.priority, std::strerror(error), request.priority);
    }
  }
  if (request.cpu >= 0) {
    cpu_set_t set;
    CPU_ZERO(&set);
    CPU_SET(static_cast<std::size_t>(request.cpu), &set);
    if (const int error = ::pthread_setaffinity_np(::pthread_self(), sizeof set, &set)) {
      if (!refused.empty()) refused += '\n';
      refused += fmt::format("thread {}: CPU {} refused ({}): name a CPU that this machine has",
                             request.name, request.cpu, std::strerror(error));
    }
  }
  return refused;
}

// Whether a mapping of that name is called by real-time threads: the program itself, the runtimes
// of C and C++, memory without a file. They call no other library.
bool called_in_real_time(std::string_view name, std::string_view executable) {
  if (!name.starts_with('/')) return true;
  if (name == executable) return true;
  const std::string_view file = name.substr(name.rfind('/') + 1);
  for (const std::string_view library : {"libc.", "libm.", "libstdc++.", "libgcc_s.", "ld-linux"}) {
    if (file.starts_with(library)) return true;
  }
  return false;
}

}  // namespace

Thread::~Thread() { join(); }

void Thread::join() {
  if (thread_.joinable()) thread_.join();
}

tl::expected<void, std::string> Thread::start(const ThreadRequest& request, bool enforce,
                                              std::function<void()> body) {
  request_ = request;
  // Simulated time waits for this thread; at a real-time priority it would only keep others from
  // the CPU.
  if (lockstep::on()) request_.priority = 0;
  std::mutex mutex;
  std::condition_variable answered;
  bool done = false;
  std::string refused;

  thread_ = std::thread([&, body = std::move(body)] {
    ::pthread_setname_np(::pthread_self(), request_.name.substr(0, 15).c_str());
    tid_ = static_cast<pid_t>(::syscall(SYS_gettid));
    std::string problem = apply(request_);
    const bool run = problem.empty() || !enforce;
    const bool real_time = request_.priority > 0;
    {
      const std::lock_guard lock(mutex);
      refused = std::move(problem);
      done = true;
      answered.notify_one();  // inside the lock: the waiter's stack may be gone after it
    }
    if (!run) return;
    if (real_time) touch_stack(kTouchedStack);
    const lockstep::Part part(request_.name);
    own_mallocs = &mallocs_;
    body();
    own_mallocs = nullptr;
  });

  std::unique_lock lock(mutex);
  answered.wait(lock, [&] { return done; });
  granted_ = refused.empty();
  if (granted_) return {};
  return tl::unexpected(refused);
}

std::uint64_t Thread::page_faults_now() const {
  std::ifstream file(fmt::format("/proc/self/task/{}/stat", tid_.load()));
  std::string line;
  if (!std::getline(file, line)) return 0;
  // Fields after the name in parentheses: state ppid pgrp session tty tpgid flags minflt cminflt
  // majflt
  std::istringstream fields(line.substr(line.rfind(')') + 2));
  std::string skip;
  for (int i = 0; i < 7; ++i) fields >> skip;
  std::uint64_t minor = 0, minor_of_children = 0, major = 0;
  fields >> minor >> minor_of_children >> major;
  return minor + major;
}

void Thread::mark_ready() {
  page_faults_base_ = page_faults_now();
  mallocs_base_ = mallocs_.load();
}

ThreadStatus Thread::status() const {
  ThreadStatus s;
  request_.name.copy(s.name.data(), s.name.size() - 1);
  s.policy = request_.priority > 0 && granted_ ? SCHED_FIFO : SCHED_OTHER;
  s.priority = granted_ ? request_.priority : 0;
  s.cpu = request_.cpu;
  s.granted = granted_;
  const std::uint64_t faults = page_faults_now();
  s.page_faults = faults > page_faults_base_ ? faults - page_faults_base_ : 0;
  s.mallocs = mallocs_.load() - mallocs_base_;
  return s;
}

tl::expected<void, std::string> lock_memory() {
  // MCL_ONFAULT: without it the whole stack of each thread and every arena is populated, some 190
  // MB (2026-11).
  if (::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0) return {};
  return tl::unexpected(
      fmt::format("memory is not locked ({}): give the service LimitMEMLOCK=infinity or the user a "
                  "memlock limit",
                  std::strerror(errno)));
}

void populate_memory() noexcept {
  char executable[PATH_MAX] = "";
  [[maybe_unused]] const auto length = ::readlink("/proc/self/exe", executable, PATH_MAX - 1);
  std::ifstream maps("/proc/self/maps");
  for (std::string line; std::getline(maps, line);) {
    std::uintptr_t begin = 0, end = 0;
    char read = 0, write = 0, shared = 0;
    if (std::sscanf(line.c_str(), "%lx-%lx %c%c%*c%c", &begin, &end, &read, &write, &shared) != 5)
      continue;
    const std::string name = line.substr(std::min(line.find_first_of("/["), line.size()));
    if (read != 'r' || shared == 's' || !called_in_real_time(name, executable)) continue;
    // Stacks and arenas reserve far more than they use: their threads touch those pages.
    if (name.empty() && end - begin > kLargeMapping) continue;
    const int advice = write == 'w' ? MADV_POPULATE_WRITE : MADV_POPULATE_READ;
    ::madvise(reinterpret_cast<void*>(begin), end - begin,
              advice);  // an older kernel refuses: then each page faults once
  }
}

void touch_stack(std::size_t bytes) noexcept {
  constexpr std::size_t kPage = 4096;
  volatile unsigned char page[kPage];
  page[0] = 0;
  page[kPage - 1] = page[0];
  if (bytes > kPage) touch_stack(bytes - kPage);
  page[1] = 0;  // after the call: no tail recursion
}

void count_malloc() noexcept {
  if (own_mallocs != nullptr) own_mallocs->fetch_add(1, std::memory_order_relaxed);
}

}  // namespace lss::rt
