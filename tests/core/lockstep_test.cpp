// Simulated time between real processes: a simulator and a daemon, each forked, with a real
// pseudo-terminal between them (drivers/lockstep).

#include "drivers/lockstep/lockstep.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <signal.h>
#include <sys/mman.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <functional>
#include <memory>
#include <new>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "drivers/lockstep/page.h"
#include "drivers/lockstep/wire.h"

namespace lss::lockstep {
namespace {

// Reports of the processes of a test.
struct Told {
  std::atomic<std::uint64_t> hash{1469598103934665603u}, orders{0};
  std::atomic<TimeNs> woken_ns{0}, wall_ns{0};
  std::atomic<pid_t> holder{0};
  std::atomic<bool> ready{false}, done{false};
  char terminal[64] = "";
};

void wall_sleep(TimeNs ns) {
  const timespec t{ns / kSecond, ns % kSecond};
  ::nanosleep(&t, nullptr);
}

// A thread of this process: state S of proc_pid_stat(5).
bool sleeps(pid_t thread) {
  std::ifstream file("/proc/self/task/" + std::to_string(thread) + "/stat");
  std::string text;
  std::getline(file, text);
  const std::size_t end = text.rfind(')');
  return end != std::string::npos && text.substr(end, 4).find('S') != std::string::npos;
}

class Lockstep : public testing::Test {
 protected:
  Lockstep() {
    folder_ = ::mkdtemp(name_);
    void* memory =
        ::mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    told_ = new (memory) Told;
  }
  ~Lockstep() override {
    while (!children_.empty()) end(children_.back());
    ::unlink((folder_ + "/" + kFile).c_str());
    ::rmdir(folder_.c_str());
    ::munmap(told_, sizeof(Told));
  }

  pid_t process(const std::function<void()>& body) {
    const pid_t child = ::fork();
    if (child == 0) {
      body();
      ::_exit(0);
    }
    children_.push_back(child);
    return child;
  }

  void end(pid_t child) {
    std::erase(children_, child);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }

  // Waits for its end; how it ended.
  int outcome(pid_t child) {
    std::erase(children_, child);
    int status = 0;
    if (::waitpid(child, &status, 0) != child || !WIFEXITED(status)) return -1;
    return WEXITSTATUS(status);
  }

  // Its turns come every millisecond until `end_ns` after the beginning.
  pid_t simulator(const Settings& settings, TimeNs end_ns) {
    const pid_t child = process([this, settings, end_ns] {
      if (!create(folder_, settings).empty()) ::_exit(1);
      told_->ready = true;
      const Part part("sim");
      while (now() < kBegin + end_ns) sleep_until(now() + kMillisecond);
      told_->done = true;
      finish();
      for (;;) ::pause();
    });
    await(told_->ready);
    return child;
  }

  static void await(const std::atomic<bool>& condition) {
    for (int i = 0; i < 60'000 && !condition; ++i) wall_sleep(kMillisecond);
    ASSERT_TRUE(condition);
  }

  Told* told_ = nullptr;
  std::string folder_;

 private:
  char name_[32] = "/tmp/lss-lockstep-XXXXXX";
  std::vector<pid_t> children_;
};

void mix(std::atomic<std::uint64_t>& hash, const void* data, std::size_t size) {
  const auto* bytes = static_cast<const unsigned char*>(data);
  std::uint64_t h = hash.load();
  for (std::size_t i = 0; i < size; ++i) h = (h ^ bytes[i]) * 1099511628211u;
  hash = h;
}

// All that was counted.
template <class Use>
void read_all(Wire& wire, int fd, Use use) {
  unsigned char bytes[512];
  for (bool more = wire.coming(); more; more = wire.awaits(fd)) {
    const ssize_t got = ::read(fd, bytes, sizeof bytes);
    if (got <= 0) continue;
    wire.took(static_cast<std::size_t>(got));
    use(bytes, static_cast<std::size_t>(got));
  }
}

void write_all(Wire& wire, int fd, const void* bytes, std::size_t size) {
  if (::write(fd, bytes, size) != static_cast<ssize_t>(size)) ::_exit(2);
  wire.sent(size);
}

// A line with a packet every 1.7 ms; the daemon's answers and their times make the hash.
void line(Told& told, const std::string& folder, TimeNs end_ns, unsigned seed) {
  const int master = ::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK);
  ::grantpt(master);
  ::unlockpt(master);
  ::ptsname_r(master, told.terminal, sizeof told.terminal);
  const int slave = ::open(told.terminal, O_RDWR | O_NOCTTY);
  termios settings{};
  ::tcgetattr(slave, &settings);
  ::cfmakeraw(&settings);
  ::tcsetattr(slave, TCSANOW, &settings);
  if (!create(folder, {.speed = 0}).empty()) ::_exit(1);
  told.ready = true;
  const Part part("sim");
  Wire wire{Wire::Side::simulator};
  wire.open("legs");
  std::mt19937 random(seed);
  TimeNs packet = now();
  while (now() < kBegin + end_ns) {
    read_all(wire, master, [&](const unsigned char* bytes, std::size_t size) {
      const TimeNs at = now();
      mix(told.hash, &at, sizeof at);
      mix(told.hash, bytes, size);
      told.orders += size / 8;
    });
    if (now() >= packet) {
      unsigned char bytes[23];
      for (unsigned char& byte : bytes) byte = static_cast<unsigned char>(random());
      if (wire.is_heard()) write_all(wire, master, bytes, sizeof bytes);
      packet += 1'700 * kMicrosecond;
    }
    wait(packet);
  }
  told.done = true;
  finish();
  for (;;) ::pause();
}

void daemon(Told& told, const std::string& folder) {
  if (!join(folder, "daemon").empty()) ::_exit(1);
  std::atomic<std::uint64_t> order{0}, seen{0};
  Waiter bus_waiter;
  std::thread frame([&] {
    const Part part("frame");
    for (TimeNs at = now();; at += 20 * kMillisecond) {
      sleep_until(at);
      order = seen * 31 + static_cast<std::uint64_t>(at);
    }
  });
  std::thread actuate([&] {
    const Part part("actuate");
    for (TimeNs at = now() + 5 * kMillisecond;; at += 20 * kMillisecond) {
      sleep_until(at);
      bus_waiter.wake();
    }
  });
  std::thread bus([&] {
    const Part part("bus/legs");
    const int port = ::open(told.terminal, O_RDWR | O_NOCTTY | O_NONBLOCK);
    Wire wire{Wire::Side::daemon};
    wire.open("legs");
    for (std::uint64_t last = 0;;) {
      bus_waiter.wait(now() + 5 * kMillisecond);
      read_all(wire, port, [&](const unsigned char* bytes, std::size_t size) {
        for (std::size_t i = 0; i < size; ++i) seen = seen * 33 + bytes[i];
      });
      if (order == last) continue;
      last = order;
      write_all(wire, port, &last, sizeof last);
    }
  });
  if (!begin(3)) ::_exit(3);
  for (;;) ::pause();
}

class OnALine : public Lockstep {
 protected:
  std::uint64_t hash(unsigned seed, bool disturbed) {
    constexpr TimeNs kEnd = 4 * kSecond;
    new (told_) Told;
    const pid_t sim = process([&] { line(*told_, folder_, kEnd, seed); });
    await(told_->ready);
    const pid_t other = process([&] { daemon(*told_, folder_); });
    std::mt19937 random(7);
    for (int i = 0; i < 60'000 && !told_->done; ++i) {
      if (disturbed && i < 40) {
        const pid_t pid = random() % 2 == 0 ? sim : other;
        ::kill(pid, SIGSTOP);
        wall_sleep(static_cast<TimeNs>(random() % 30) * kMillisecond);
        ::kill(pid, SIGCONT);
      }
      wall_sleep(kMillisecond);
    }
    EXPECT_TRUE(told_->done);
    end(sim);
    end(other);
    return told_->hash;
  }
};

TEST_F(OnALine, bytes_and_their_times_are_the_same_each_time_and_when_processes_are_stopped) {
  const std::uint64_t first = hash(1, false);
  EXPECT_GT(told_->orders, 190u);
  EXPECT_EQ(hash(1, false), first);
  EXPECT_EQ(hash(1, true), first);
  EXPECT_NE(hash(2, false), first);
}

TEST_F(Lockstep, time_stands_still_before_a_daemon_and_while_one_starts) {
  simulator({.speed = 0}, 100 * kMillisecond);
  wall_sleep(50 * kMillisecond);
  EXPECT_FALSE(told_->done);
  const pid_t other = process([this] {
    if (!join(folder_, "daemon").empty()) ::_exit(1);
    if (now() != kBegin || waits_for() != "daemon, which starts") ::_exit(2);
    if (!begin(0)) ::_exit(3);
    while (!told_->done) wall_sleep(kMillisecond);
  });
  EXPECT_EQ(outcome(other), 0);
  EXPECT_TRUE(told_->done);
}

TEST_F(Lockstep, without_a_simulator_it_is_refused_with_what_to_do) {
  const pid_t other = process([this] {
    const std::string why = join(folder_, "daemon");
    ::_exit(why.find("start lss-sim VEHICLE --lockstep first") != why.npos && !on() ? 0 : 1);
  });
  EXPECT_EQ(outcome(other), 0);
}

TEST_F(Lockstep, a_process_that_dies_with_the_turn_is_left_out) {
  simulator({.speed = 0}, 10 * kSecond);
  const pid_t other = process([this] {
    if (!join(folder_, "daemon").empty()) ::_exit(1);
    std::thread thread([this] {
      const Part part("bus/legs");
      sleep_until(kBegin + kSecond);
      told_->holder = ::getpid();
      for (;;) ::pause();  // with the turn
    });
    begin(1);
    thread.join();
  });
  for (int i = 0; i < 60'000 && told_->holder == 0; ++i) wall_sleep(kMillisecond);
  wall_sleep(200 * kMillisecond);
  EXPECT_FALSE(told_->done);
  ::kill(other, SIGKILL);  // and nobody takes it off: as a child that is not waited for
  await(told_->done);
}

TEST_F(Lockstep, a_stopped_process_keeps_time_still_and_is_named) {
  const pid_t watcher = process([this] {
    if (!create(folder_, {.speed = 0}).empty()) ::_exit(1);
    told_->ready = true;
    const std::thread sim([] {
      const Part part("sim");
      for (;;) sleep_until(now() + kMillisecond);
    });
    while (told_->holder == 0) wall_sleep(kMillisecond);
    ::kill(told_->holder, SIGSTOP);
    wall_sleep(100 * kMillisecond);
    const TimeNs still = now();
    wall_sleep(300 * kMillisecond);
    if (now() != still || waits_for() != "lssd thread bus/legs") ::_exit(4);
    ::kill(told_->holder, SIGCONT);
    while (now() == still) wall_sleep(kMillisecond);
    ::_exit(0);
  });
  await(told_->ready);
  process([this] {
    if (!join(folder_, "lssd").empty()) ::_exit(1);
    std::thread thread([this] {
      const Part part("bus/legs");
      sleep_until(kBegin + kSecond);
      told_->holder = ::getpid();
      wall_sleep(kSecond);  // has the turn while it is stopped
      for (;;) sleep_until(now() + kMillisecond);
    });
    begin(1);
    thread.join();
  });
  EXPECT_EQ(outcome(watcher), 0);
}

TEST_F(Lockstep, at_the_pace_of_the_clock_time_never_runs_ahead) {
  const TimeNs begin_ns = wall_now();
  simulator({.speed = 2}, 400 * kMillisecond);
  process([this] {
    if (!join(folder_, "daemon").empty()) ::_exit(1);
    begin(0);
    for (;;) ::pause();
  });
  await(told_->done);
  EXPECT_GE(wall_now() - begin_ns, 200 * kMillisecond);
}

TEST_F(Lockstep, a_thread_that_takes_no_part_wakes_one_that_does_at_the_time_of_the_clock) {
  process([this] {
    if (!create(folder_, {.speed = 1}).empty()) ::_exit(1);
    told_->ready = true;
    Waiter waiter;
    std::atomic<bool> has_turn = false;
    std::thread waits([&] {
      const Part part("publish");
      has_turn = true;
      waiter.wait(kBegin + 3600 * kSecond);
      told_->woken_ns = now();
      told_->done = true;
    });
    const TimeNs from = wall_now();
    if (!begin(1)) ::_exit(3);
    while (!has_turn || !waits_for().empty()) wall_sleep(kMillisecond);
    wall_sleep(300 * kMillisecond);
    waiter.wake();
    waits.join();
    told_->wall_ns = wall_now() - from;
    for (;;) ::pause();
  });
  await(told_->done);
  while (told_->wall_ns == 0) wall_sleep(kMillisecond);
  EXPECT_GE(told_->woken_ns - kBegin, 300 * kMillisecond);
  EXPECT_LE(told_->woken_ns - kBegin, told_->wall_ns.load());
}

// Otherwise the sleeper's own look at the others gives it the turn at the time of before.
TEST_F(Lockstep, a_wake_is_not_seen_before_time_is_that_of_the_clock) {
  process([this] {
    if (!create(folder_, {.speed = 1}).empty()) ::_exit(1);
    Waiter waiter;
    std::thread waits([&] {
      const Part part("publish");
      waiter.wait(kBegin + 3600 * kSecond);
    });
    if (!begin(1)) ::_exit(3);
    const Seat& seat = shared->seats[0];
    while (!waits_for().empty() || seat.deadline < kBegin + kSecond) wall_sleep(kMillisecond);
    std::atomic<pid_t> waker = 0;
    std::thread wakes;
    {
      const Lock lock;
      wakes = std::thread([&] {
        waker = ::gettid();
        waiter.wake();
      });
      while (waker == 0 || !sleeps(waker)) wall_sleep(kMillisecond);
      told_->woken_ns = seat.woken ? 1 : 2;
    }
    wakes.join();
    waits.join();
    told_->done = true;
    for (;;) ::pause();
  });
  await(told_->done);
  EXPECT_EQ(told_->woken_ns, 2) << "the sleeper was woken before the waker had the lock";
}

TEST_F(Lockstep, time_waits_for_a_client_where_it_shall) {
  simulator({.speed = 0, .client_at = 2 * kSecond}, 4 * kSecond);
  process([this] {
    if (!join(folder_, "daemon").empty()) ::_exit(1);
    begin(0);
    for (;;) ::pause();
  });
  wall_sleep(300 * kMillisecond);
  EXPECT_FALSE(told_->done);
  process([this] {
    if (!join_as_client(folder_).empty()) ::_exit(1);
    const Part part("client");
    told_->woken_ns = now();
  });
  await(told_->done);
  EXPECT_EQ(told_->woken_ns - kBegin, 2 * kSecond);
}

TEST_F(Lockstep, as_many_clients_take_part_as_have_places) {
  simulator({}, kSecond);
  const pid_t clients = process([this] {
    if (!join_as_client(folder_).empty()) ::_exit(1);
    std::vector<std::unique_ptr<Client>> all;
    for (int i = 0; i < kMostClients; ++i) {
      all.push_back(std::make_unique<Client>("client"));
      if (!all.back()->has_place()) ::_exit(2);
    }
    if (Client("client").has_place()) ::_exit(3);
    all.pop_back();
    ::_exit(Client("client").has_place() ? 0 : 4);
  });
  EXPECT_EQ(outcome(clients), 0);
}

}  // namespace
}  // namespace lss::lockstep
