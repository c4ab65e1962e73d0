#pragma once

// The shared page and the functions of the files in this folder on it.

#include <pthread.h>
#include <sys/types.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <string>

#include "drivers/lockstep/lockstep.h"

namespace lss::lockstep {

inline constexpr std::uint64_t kMagic = 0x3153'4C53'534C'0001;
inline constexpr std::uint32_t kVersion = 2;
inline constexpr const char* kFile = "lockstep";
inline constexpr int kNobody = -1;
inline constexpr int kProcesses = 16, kSeats = 48, kLines = 16, kSides = 2;

struct Process {
  pid_t pid;  // 0: free
  std::uint64_t started;
  bool joining;
  char program[16];
};

struct Seat {  // of a thread that takes part
  bool used;
  int process, rank;
  char name[32];
  TimeNs deadline;
  bool waiting;        // for the turn
  bool was_woken;      // why it has the turn
  std::uint32_t idle;  // turns at one instant without a reason
  std::atomic<bool> woken;
  std::atomic<std::uint32_t> word;
};

struct Line {
  char name[64];                                               // empty: free
  std::array<std::atomic<std::uint64_t>, kSides> sent, taken;  // to that side
  std::array<std::atomic<int>, kSides> reader;                 // the seat; kNobody
  std::array<std::atomic<int>, kSides> process;                // that has it open; kNobody
  std::array<std::atomic<std::uint32_t>, kSides> openings;
};

struct ClientSlot {
  bool used;
  std::atomic<bool> at_speed;  // needs no more than Page::speed
  int process, seat;
  char source[32];
  std::atomic<std::uint64_t> commands, heartbeats, answers;  // taken, taken, given
};

struct Page {
  std::uint64_t magic;
  std::uint32_t version, size;
  pthread_mutex_t mutex;  // for all that is not atomic
  std::atomic<TimeNs> now;
  std::atomic<int> holder;  // the seat that has the turn; kNobody
  bool started;             // a daemon has joined
  std::atomic<bool> over;
  unsigned clients_seen;
  TimeNs client_at;
  double speed, client_speed;  // 0: as fast as the machine goes
  double pace;                 // the one in force
  int cpu;                     // where all run when time is as fast as the machine; kNobody
  TimeNs wall_ns, paced_ns;    // this wall time corresponds to this simulated time
  std::atomic<TimeNs> slipped_ns;
  std::atomic<std::uint64_t> turns, handovers;
  int last;  // seat of the last turn
  std::array<Process, kProcesses> processes;
  std::array<Seat, kSeats> seats;
  std::array<int, kSeats> order;  // of the seats that are used
  int count;
  std::array<Line, kLines> lines;
  std::array<ClientSlot, kMostClients> clients;
  std::atomic<TimeNs> status_ns, telemetry_ns;  // of the newest
};

static_assert(std::atomic<std::uint64_t>::is_always_lock_free &&
              std::atomic<int>::is_always_lock_free);

extern thread_local int own_seat;
extern int own_process;

// The page's lock; removes a process that ended with it.
class Lock {
 public:
  Lock() noexcept;
  ~Lock();
  Lock(const Lock&) = delete;
  Lock& operator=(const Lock&) = delete;
};

// With the lock. Gives the turn to the next seat, which has to be roused() after the lock; kNobody.
int pass_on() noexcept;
void rouse(int seat) noexcept;  // kNobody: nothing
// With the lock.
void pace_from_here() noexcept;
void remove_process(int process) noexcept;
bool remove_dead() noexcept;  // true: there were some
// Any thread.
void wake_seat(int seat) noexcept;
void close_line(Line& line, int side) noexcept;

bool is_alive(const Process& process) noexcept;
std::uint64_t started_of(pid_t pid) noexcept;  // 0: it has ended

}  // namespace lss::lockstep
