// The participants: the page in its file, and processes that join and leave.

#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>

#include "drivers/file.h"
#include "drivers/lockstep/page.h"

namespace lss::lockstep {
namespace {

constexpr TimeNs kBeginLimit = 20 * kSecond;  // of wall time

std::string trouble(const std::string& path) {
  return "lockstep: " + path + ": " + std::strerror(errno);
}

Page* map(int fd) {
  void* memory = ::mmap(nullptr, sizeof(Page), PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
  return memory == MAP_FAILED ? nullptr : static_cast<Page*>(memory);
}

// nullptr: none; `why` is the reason. A page of another build counts as none.
Page* open_page(const std::string& folder, std::string& why) {
  const std::string path = folder + "/" + kFile;
  const File file(::open(path.c_str(), O_RDWR | O_CLOEXEC));
  if (!file) {
    why = trouble(path) + ": start lss-sim VEHICLE --lockstep first, with this folder as its --dir";
    return nullptr;
  }
  struct stat info {};
  Page* page =
      ::fstat(file.get(), &info) == 0 && info.st_size == sizeof(Page) ? map(file.get()) : nullptr;
  if (page != nullptr && page->magic == kMagic && page->version == kVersion &&
      page->size == sizeof(Page))
    return page;
  if (page != nullptr) ::munmap(page, sizeof(Page));
  why = "lockstep: " + path + " is of another build: install lss-sim and lssd of one version";
  return nullptr;
}

bool make_mutex(pthread_mutex_t& mutex) {
  pthread_mutexattr_t how;
  ::pthread_mutexattr_init(&how);
  ::pthread_mutexattr_setpshared(&how, PTHREAD_PROCESS_SHARED);
  ::pthread_mutexattr_setrobust(&how, PTHREAD_MUTEX_ROBUST);
  ::pthread_mutexattr_setprotocol(&how, PTHREAD_PRIO_INHERIT);
  const int error = ::pthread_mutex_init(&mutex, &how);
  ::pthread_mutexattr_destroy(&how);
  return error == 0;
}

// With the lock.
std::string take_process(const char* program, bool joining) {
  for (int i = 0; i < kProcesses; ++i) {
    Process& p = shared->processes[static_cast<std::size_t>(i)];
    if (p.pid != 0) continue;
    p.started = started_of(::getpid());
    p.joining = joining;
    std::snprintf(p.program, sizeof p.program, "%s", program);
    p.pid = ::getpid();
    own_process = i;
    return {};
  }
  return "lockstep: more processes take part than there is room for: stop some";
}

// One thread runs at a time: on one CPU a hand-over takes half as long (measured 2026-11).
void share_cpu() noexcept {
  if (shared->cpu == kNobody) return;
  cpu_set_t one;
  CPU_ZERO(&one);
  CPU_SET(static_cast<unsigned>(shared->cpu), &one);
  ::sched_setaffinity(0, sizeof one, &one);
}

std::string enter(const std::string& folder, const char* program, bool joining) {
  std::string why;
  Page* page = open_page(folder, why);
  if (page == nullptr) return why;
  shared = page;
  {
    const Lock lock;
    remove_dead();
    const bool empty = std::all_of(page->processes.begin(), page->processes.end(),
                                   [](const Process& p) { return p.pid == 0; });
    if (!empty && !page->over) {
      why = take_process(program, joining);
      if (why.empty()) {
        share_cpu();
        return {};
      }
    }
  }
  shared = nullptr;
  if (!why.empty()) return why;
  return "lockstep: nobody moves the time in " + folder +
         " any more: start lss-sim VEHICLE --lockstep again";
}

}  // namespace

std::uint64_t started_of(pid_t pid) noexcept {
  char path[32], text[512];
  std::snprintf(path, sizeof path, "/proc/%d/stat", static_cast<int>(pid));
  const File file(::open(path, O_RDONLY | O_CLOEXEC));
  const ssize_t size = ::read(file.get(), text, sizeof text - 1);
  if (size <= 0) return 0;
  text[size] = '\0';
  const char* after = std::strrchr(text, ')');  // the name may contain any character
  if (after == nullptr) return 0;
  char state = 0;
  unsigned long long started = 0;
  const int fields = std::sscanf(after + 1,
                                 " %c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %*u %*u %*d %*d %*d "
                                 "%*d %*d %*d %llu",
                                 &state, &started);
  if (fields != 2 || state == 'Z' || state == 'X') return 0;
  return started == 0 ? 1 : started;
}

bool is_alive(const Process& process) noexcept {
  return started_of(process.pid) == process.started;
}

std::string create(const std::string& folder, const Settings& settings) {
  if (enter(folder, "lss-sim", false).empty()) return {};  // its processes run: join them
  const std::string path = folder + "/" + kFile, fresh = path + ".new";
  ::unlink(fresh.c_str());
  const File file(::open(fresh.c_str(), O_RDWR | O_CREAT | O_EXCL | O_CLOEXEC, 0660));
  if (!file) return trouble(fresh);
  Page* page = ::ftruncate(file.get(), sizeof(Page)) == 0 ? map(file.get()) : nullptr;
  if (page == nullptr) return trouble(fresh);
  if (!make_mutex(page->mutex)) return "lockstep: this kernel has no shared mutex that is robust";
  page->version = kVersion;
  page->size = sizeof(Page);
  page->now = kBegin;
  page->holder = page->last = kNobody;
  page->speed = page->pace = settings.speed;
  page->client_speed = settings.client_speed < 0 ? settings.speed : settings.client_speed;
  page->cpu = settings.speed > 0 ? kNobody : ::sched_getcpu();
  page->client_at = settings.client_at < 0 ? -1 : kBegin + settings.client_at;
  page->paced_ns = kBegin;
  for (Line& line : page->lines) {
    for (std::size_t side = 0; side < kSides; ++side)
      line.reader[side] = line.process[side] = kNobody;
  }
  page->magic = kMagic;
  shared = page;
  {
    const Lock lock;
    take_process("lss-sim", false);
    share_cpu();
  }
  if (::rename(fresh.c_str(), path.c_str()) == 0) return {};
  shared = nullptr;
  return trouble(path);
}

std::string join(const std::string& folder, const char* program) {
  return enter(folder, program, true);
}
std::string join_as_client(const std::string& folder) { return enter(folder, "lss-cli", false); }

bool begin(unsigned threads) {
  const TimeNs limit = wall_now() + kBeginLimit;
  for (;;) {
    int next = kNobody;
    bool done = false;
    {
      const Lock lock;
      Page& p = *shared;
      const auto waiting = std::count_if(p.seats.begin(), p.seats.end(), [](const Seat& s) {
        return s.used && s.process == own_process && s.waiting;
      });
      if (static_cast<unsigned>(waiting) >= threads) {
        p.processes[static_cast<std::size_t>(own_process)].joining = false;
        p.started = true;
        pace_from_here();
        if (p.holder.load() == kNobody) next = pass_on();
        done = true;
      }
    }
    rouse(next);
    if (done) return true;
    if (wall_now() > limit) return false;
    const timespec pause{0, kMillisecond};
    ::nanosleep(&pause, nullptr);
  }
}

void remove_process(int process) noexcept {
  Page& p = *shared;
  const auto index = static_cast<std::size_t>(process);
  if (process == kNobody || p.processes[index].pid == 0) return;
  int count = 0;
  for (int i = 0; i < p.count; ++i) {
    const int seat = p.order[static_cast<std::size_t>(i)];
    Seat& s = p.seats[static_cast<std::size_t>(seat)];
    if (s.process != process) {
      p.order[static_cast<std::size_t>(count++)] = seat;
      continue;
    }
    s.used = s.waiting = false;
    if (p.holder.load() == seat) p.holder = kNobody;
  }
  p.count = count;
  for (Line& line : p.lines) {
    for (int side = 0; side < kSides; ++side) {
      if (line.process[static_cast<std::size_t>(side)].load() == process) close_line(line, side);
    }
  }
  for (ClientSlot& client : p.clients) {
    if (client.process == process) client.used = false;
  }
  p.processes[index].pid = 0;
}

bool remove_dead() noexcept {
  bool some = false;
  for (int i = 0; i < kProcesses; ++i) {
    const Process& p = shared->processes[static_cast<std::size_t>(i)];
    if (p.pid == 0 || is_alive(p)) continue;
    remove_process(i);
    some = true;
  }
  return some;
}

void finish() noexcept { shared->over = true; }
bool over() noexcept { return shared->over; }
std::uint64_t turns() noexcept { return shared->turns; }
std::uint64_t handovers() noexcept { return shared->handovers; }
double slipped_s() noexcept { return static_cast<double>(shared->slipped_ns.load()) * 1e-9; }

std::string waits_for() {
  const Page& p = *shared;
  const int holder = p.holder.load();
  if (holder != kNobody) {
    const Seat& seat = p.seats[static_cast<std::size_t>(holder)];
    if (!seat.used) return {};
    return std::string(p.processes[static_cast<std::size_t>(seat.process)].program) + " thread " +
           seat.name;
  }
  for (const Process& process : p.processes) {
    if (process.pid != 0 && process.joining) return std::string(process.program) + ", which starts";
  }
  return {};
}

Client::Client(std::string_view source) noexcept {
  const Lock lock;
  for (int i = 0; i < kMostClients && at_ < 0; ++i) {
    ClientSlot& c = shared->clients[static_cast<std::size_t>(i)];
    if (c.used) continue;
    at_ = i;
    c.used = true;
    c.at_speed = false;
    c.process = own_process;
    c.seat = own_seat;
    c.commands = c.heartbeats = c.answers = 0;
    const std::size_t length = std::min(source.size(), sizeof c.source - 1);
    std::memcpy(c.source, source.data(), length);
    c.source[length] = '\0';
  }
}

Client::~Client() {
  if (at_ < 0) return;
  const Lock lock;
  shared->clients[static_cast<std::size_t>(at_)].used = false;
}

namespace {

// Before it takes part, a client numbers its messages by the wall clock.
bool is_numbered(std::uint64_t number) noexcept { return number < std::uint64_t{1} << 40; }

bool await_count(const std::atomic<std::uint64_t>& count, std::uint64_t number,
                 TimeNs limit) noexcept {
  const TimeNs end = wall_now() + limit;
  while (count.load() < number) {
    if (wall_now() > end) return false;
    const timespec pause{0, 50 * kMicrosecond};
    ::nanosleep(&pause, nullptr);
  }
  return true;
}

template <class Count>
void for_client(std::string_view source, std::uint64_t number, Count count) noexcept {
  if (!on() || !is_numbered(number)) return;
  for (ClientSlot& c : shared->clients) {
    if (c.used && source == c.source) count(c);
  }
}

}  // namespace

bool Client::await_command(std::uint64_t number, TimeNs limit) const noexcept {
  return at_ < 0 ||
         await_count(shared->clients[static_cast<std::size_t>(at_)].commands, number, limit);
}

bool Client::await_heartbeat(std::uint64_t number, TimeNs limit) const noexcept {
  return at_ < 0 ||
         await_count(shared->clients[static_cast<std::size_t>(at_)].heartbeats, number, limit);
}

void Client::wait_at_speed(bool on) noexcept {
  if (at_ >= 0) shared->clients[static_cast<std::size_t>(at_)].at_speed = on;
}

void Client::heard_answer(std::uint64_t number) noexcept { answers_ += is_numbered(number); }

bool Client::all_heard(TimeNs status_ns, TimeNs telemetry_ns) const noexcept {
  return at_ < 0 ||
         (answers_ >= shared->clients[static_cast<std::size_t>(at_)].answers.load() &&
          status_ns >= shared->status_ns.load() && telemetry_ns >= shared->telemetry_ns.load());
}

void took_command(std::string_view source, std::uint64_t number) noexcept {
  for_client(source, number, [&](ClientSlot& c) { c.commands.store(number); });
}

void took_heartbeat(std::string_view source, std::uint64_t number) noexcept {
  for_client(source, number, [&](ClientSlot& c) { c.heartbeats.store(number); });
}

bool has_heartbeat(std::string_view source, std::uint64_t number) noexcept {
  bool had = false;
  for_client(source, number, [&](ClientSlot& c) { had = had || c.heartbeats.load() >= number; });
  return had;
}

void answered(std::string_view source, std::uint64_t number) noexcept {
  for_client(source, number, [](ClientSlot& c) {
    c.answers.fetch_add(1);
    wake_seat(c.seat);
  });
}

void said_telemetry(TimeNs time) noexcept {
  if (on()) shared->telemetry_ns.store(time);
}

void said_status(TimeNs time) noexcept {
  if (!on()) return;
  shared->status_ns.store(time);
  for (const ClientSlot& c : shared->clients) {
    if (c.used) wake_seat(c.seat);
  }
}

}  // namespace lss::lockstep
