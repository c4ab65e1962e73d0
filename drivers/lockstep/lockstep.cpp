#include "drivers/lockstep/lockstep.h"

#include <linux/futex.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <cstring>
#include <ctime>

#include "drivers/lockstep/page.h"

namespace lss::lockstep {

thread_local int own_seat = kNobody;
int own_process = kNobody;

namespace {

constexpr TimeNs kLook = 100 * kMillisecond;     // check for ended processes, in wall time
constexpr TimeNs kBehind = 100 * kMillisecond;   // then time slips against the wall clock
constexpr std::uint32_t kMostIdle = 64;          // turns of one thread without a reason
constexpr TimeNs kIdleStep = 50 * kMicrosecond;  // then it waits for so long

std::atomic<bool> left{false};

timespec to_timespec(TimeNs ns) noexcept {
  return {static_cast<std::time_t>(ns / kSecond), static_cast<long>(ns % kSecond)};
}

void wall_sleep(TimeNs ns) noexcept {
  const timespec t = to_timespec(ns);
  ::nanosleep(&t, nullptr);
}

// Order at one instant: threads that move bytes, threads that compute, threads that record.
constexpr int kClient = 7;
int rank_of(std::string_view name) noexcept {
  if (name == "sim") return 0;
  if (name.starts_with("bus/")) return 1;
  if (name == "actuate") return 2;
  if (name == "frame") return 3;
  if (name == "publish") return 4;
  if (name == "log") return 5;
  if (name == "save") return 6;
  return kClient;
}

bool before(const Seat& a, const Seat& b) noexcept {
  if (a.rank != b.rank) return a.rank < b.rank;
  return std::strcmp(a.name, b.name) < 0;
}

bool may_move() noexcept {
  const Page& p = *shared;
  return p.started && !p.over && std::none_of(p.processes.begin(), p.processes.end(), [](auto& q) {
           return q.pid != 0 && q.joining;
         });
}

int first_due(TimeNs now) noexcept {
  const Page& p = *shared;
  for (int i = 0; i < p.count; ++i) {
    const Seat& s = p.seats[static_cast<std::size_t>(p.order[static_cast<std::size_t>(i)])];
    if (s.waiting && (s.woken.load(std::memory_order_relaxed) || s.deadline <= now))
      return p.order[static_cast<std::size_t>(i)];
  }
  return kNobody;
}

TimeNs earliest() noexcept {
  TimeNs first = kNever;
  const Page& p = *shared;
  for (int i = 0; i < p.count; ++i) {
    const Seat& s = p.seats[static_cast<std::size_t>(p.order[static_cast<std::size_t>(i)])];
    if (s.waiting) first = std::min(first, s.deadline);
  }
  return first;
}

TimeNs wall_of(TimeNs time) noexcept {
  const Page& p = *shared;
  return p.wall_ns + static_cast<TimeNs>(static_cast<double>(time - p.paced_ns) / p.pace);
}

// The next instant of simulated time; kNever: it needs an external event.
TimeNs next_time() noexcept {
  const Page& p = *shared;
  const TimeNs next = earliest();
  const bool waits_for_client = p.client_at >= 0 && p.clients_seen == 0 && next > p.client_at;
  return waits_for_client ? kNever : next;
}

// The speed that is due now.
double due_pace() noexcept {
  const Page& p = *shared;
  const bool client = std::any_of(p.clients.begin(), p.clients.end(),
                                  [](const ClientSlot& c) { return c.used && !c.at_speed; });
  return client ? p.client_speed : p.speed;
}

// Whether the wall clock has reached it; when it is far ahead, time slips.
bool reached(TimeNs time) noexcept {
  Page& p = *shared;
  if (const double pace = due_pace(); pace != p.pace) {
    p.pace = pace;
    pace_from_here();
  }
  if (p.pace <= 0) return true;
  const TimeNs late = wall_now() - wall_of(time);
  if (late > kBehind) {
    p.slipped_ns.fetch_add(late, std::memory_order_relaxed);
    p.wall_ns += late;
  }
  return late >= 0;
}

void give(int seat) noexcept {
  Page& p = *shared;
  Seat& s = p.seats[static_cast<std::size_t>(seat)];
  p.holder.store(seat, std::memory_order_relaxed);
  p.turns.fetch_add(1, std::memory_order_relaxed);
  if (p.last != seat) p.handovers.fetch_add(1, std::memory_order_relaxed);
  p.last = seat;
  s.was_woken = s.woken.exchange(false, std::memory_order_relaxed);
  s.word.fetch_add(1, std::memory_order_release);
  s.waiting = false;  // last: a thread that ends before leaves a turn that can be given again
}

// A waiting thread woke by itself: the next instant may be reached, or a process ended.
void look_after(std::uint64_t& turns) noexcept {
  int next = kNobody;
  {
    const Lock lock;
    const std::uint64_t now = shared->turns.load(std::memory_order_relaxed);
    if (now == turns) remove_dead();
    turns = now;
    if (shared->holder.load(std::memory_order_relaxed) == kNobody) next = pass_on();
  }
  rouse(next);
}

// Wall time until the next instant of simulated time.
TimeNs pause() noexcept {
  const Page& p = *shared;
  if (p.pace <= 0 || p.holder.load(std::memory_order_relaxed) != kNobody || !may_move())
    return kLook;
  const TimeNs next = next_time();
  return next == kNever ? kLook : std::clamp<TimeNs>(wall_of(next) - wall_now(), 1, kLook);
}

// Until the word changes. `longest`: first time-out.
void await_turn(Seat& seat, std::uint32_t word, TimeNs longest) noexcept {
  std::uint64_t turns = 0;
  while (seat.word.load(std::memory_order_acquire) == word && !left) {
    if (shared->over && seat.rank == kClient) return;  // daemons wait to be ended
    const timespec t = to_timespec(longest);
    const long result = ::syscall(SYS_futex, &seat.word, FUTEX_WAIT, word, &t, nullptr, 0);
    if (result != 0 && errno == ETIMEDOUT) {
      look_after(turns);
      const Lock lock;
      longest = pause();
    }
  }
}

}  // namespace

TimeNs wall_now() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_MONOTONIC, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

TimeNs now() noexcept { return shared->now.load(std::memory_order_relaxed); }
bool takes_part() noexcept { return own_seat != kNobody; }
bool gone() noexcept { return left; }

Lock::Lock() noexcept {
  if (::pthread_mutex_lock(&shared->mutex) != EOWNERDEAD) return;
  ::pthread_mutex_consistent(&shared->mutex);
  remove_dead();
  // An incomplete hand-over of the turn.
  const int holder = shared->holder.load(std::memory_order_relaxed);
  if (holder == kNobody) return;
  Seat& seat = shared->seats[static_cast<std::size_t>(holder)];
  if (!seat.waiting) return;
  give(holder);
  rouse(holder);
}

Lock::~Lock() { ::pthread_mutex_unlock(&shared->mutex); }

void rouse(int seat) noexcept {
  if (seat == kNobody) return;
  ::syscall(SYS_futex, &shared->seats[static_cast<std::size_t>(seat)].word, FUTEX_WAKE, INT_MAX,
            nullptr, nullptr, 0);
}

int pass_on() noexcept {
  Page& p = *shared;
  p.holder.store(kNobody, std::memory_order_relaxed);
  if (!may_move()) return kNobody;
  int next = first_due(p.now.load(std::memory_order_relaxed));
  if (next == kNobody) {
    const TimeNs time = next_time();
    if (time == kNever || !reached(time)) return kNobody;
    p.now.store(time, std::memory_order_relaxed);
    next = first_due(time);
  }
  give(next);
  return next;
}

void pace_from_here() noexcept {
  shared->wall_ns = wall_now();
  shared->paced_ns = now();
}

bool wait(TimeNs until) noexcept {
  if (own_seat == kNobody || left) {
    wall_sleep(kMillisecond / 10);
    return true;
  }
  Seat& s = shared->seats[static_cast<std::size_t>(own_seat)];
  int next = kNobody;
  std::uint32_t word = 0;
  TimeNs longest = kLook;
  {
    const Lock lock;
    if (!s.used) return true;
    // A thread that waits for a past time would keep time still for ever.
    s.idle = until > now() || s.was_woken ? 0 : s.idle + 1;
    s.deadline = s.idle > kMostIdle ? now() + kIdleStep : until;
    word = s.word.load(std::memory_order_relaxed);
    s.waiting = true;
    const int holder = shared->holder.load(std::memory_order_relaxed);
    if (holder == own_seat || holder == kNobody) next = pass_on();
    if (next == kNobody) longest = pause();
  }
  if (next != own_seat) {
    rouse(next);
    await_turn(s, word, longest);
  }
  return s.was_woken;
}

void sleep_until(TimeNs time) noexcept {
  if (own_seat == kNobody) return wall_sleep(std::max<TimeNs>(0, time - now()));
  do {
    wait(time);
  } while (now() < time && !left);
}

void wake_seat(int seat) noexcept {
  if (seat == kNobody) return;
  std::atomic<bool>& woken = shared->seats[static_cast<std::size_t>(seat)].woken;
  if (own_seat != kNobody && shared->holder.load(std::memory_order_relaxed) == own_seat) {
    woken.store(true, std::memory_order_relaxed);
    return;
  }
  // Maybe nobody has the turn, while time waits for the wall clock: this is its present value. With
  // the lock, so that look_after() does not give the turn at the time of before.
  int next = kNobody;
  {
    const Lock lock;
    Page& p = *shared;
    woken.store(true, std::memory_order_relaxed);
    if (p.holder.load(std::memory_order_relaxed) != kNobody || !may_move()) return;
    if (p.pace > 0) {
      const auto gone_ns = static_cast<double>(wall_now() - p.wall_ns) * p.pace;
      const TimeNs here = p.paced_ns + static_cast<TimeNs>(gone_ns);
      const TimeNs most =
          std::min(earliest(), p.client_at < 0 || p.clients_seen > 0 ? kNever : p.client_at);
      p.now.store(std::max(p.now.load(), std::min(here, most)), std::memory_order_relaxed);
    }
    next = pass_on();
  }
  rouse(next);
}

bool Waiter::wait(TimeNs until) noexcept {
  seat_.store(own_seat);
  bool rung = rung_.exchange(false);
  if (!rung) {
    rung = lockstep::wait(until);
    rung_.store(false);
  }
  return rung;
}

void Waiter::wake() noexcept {
  rung_.store(true);
  wake_seat(seat_.load());
}

Part::Part(std::string_view name) noexcept {
  if (!on() || left || own_seat != kNobody) return;
  int seat = kNobody, next = kNobody;
  std::uint32_t word = 0;
  {
    const Lock lock;
    Page& p = *shared;
    for (int i = 0; i < kSeats && seat == kNobody; ++i) {
      if (!p.seats[static_cast<std::size_t>(i)].used) seat = i;
    }
    if (seat == kNobody) return;  // more threads than ever exist
    Seat& s = p.seats[static_cast<std::size_t>(seat)];
    s.used = true;
    s.process = own_process;
    s.rank = rank_of(name);
    const std::size_t length = std::min(name.size(), sizeof s.name - 1);
    std::memcpy(s.name, name.data(), length);
    s.name[length] = '\0';
    s.idle = 0;
    s.woken.store(false);
    const bool client = s.rank == kClient;
    s.deadline = client ? std::max(now(), p.client_at) : now();
    p.clients_seen += client ? 1 : 0;
    if (client) pace_from_here();  // time may have stood still for it
    word = s.word.load();
    s.waiting = true;
    int at = p.count++;
    for (; at > 0 &&
           before(s, p.seats[static_cast<std::size_t>(p.order[static_cast<std::size_t>(at - 1)])]);
         --at)
      p.order[static_cast<std::size_t>(at)] = p.order[static_cast<std::size_t>(at - 1)];
    p.order[static_cast<std::size_t>(at)] = seat;
    own_seat = seat;
    if (p.holder.load() == kNobody) next = pass_on();
  }
  if (next == own_seat) return;
  rouse(next);
  await_turn(shared->seats[static_cast<std::size_t>(seat)], word, kLook);
}

Part::~Part() {
  if (own_seat == kNobody) return;
  int next = kNobody;
  if (!left) {
    const Lock lock;
    Page& p = *shared;
    p.seats[static_cast<std::size_t>(own_seat)].used = false;
    const auto end = std::remove(p.order.begin(), p.order.begin() + p.count, own_seat);
    p.count = static_cast<int>(end - p.order.begin());
    if (p.holder.load() == own_seat) next = pass_on();
  }
  own_seat = kNobody;
  rouse(next);
}

void leave() noexcept {
  if (!on() || left.exchange(true)) return;
  int next = kNobody;
  std::array<bool, kSeats> own{};
  {
    const Lock lock;
    for (std::size_t i = 0; i < kSeats; ++i)
      own[i] = shared->seats[i].used && shared->seats[i].process == own_process;
    remove_process(own_process);
    for (std::size_t i = 0; i < kSeats; ++i) {
      if (own[i]) shared->seats[i].word.fetch_add(1);
    }
    if (shared->holder.load() == kNobody) next = pass_on();
  }
  rouse(next);
  for (int i = 0; i < kSeats; ++i) {
    if (own[static_cast<std::size_t>(i)]) rouse(i);
  }
}

}  // namespace lss::lockstep
