#pragma once

// Simulated time, shared by the processes of one simulation (docs/simulator.md, decision 16). Only
// one thread that takes part runs at a time, at one instant in a fixed order; when all of them
// wait, time moves to the earliest time that one waits for. A thread that is due but does not run
// stops time, so that the speed of the machine has no effect.
//
// A thread takes part while it has a Part. It waits by wait(), or by a Waiter that others may wake.
// Threads that do not take part (DDS listeners, main) may wake those that do. An ended process is
// removed after 100 ms of wall time. Without create() or join() all this is off: one branch on
// `shared`, which never changes after start.

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "drivers/time.h"

namespace lss::lockstep {

struct Page;
inline Page* shared = nullptr;  // nullptr: off

inline constexpr TimeNs kNever = INT64_MAX;
inline constexpr TimeNs kBegin = 1000 * kSecond;  // of simulated time
// Of the wall clock at kBegin: 2026-01-01 00:00:00.
inline constexpr std::int64_t kBeginUtc_ns = 1'767'225'600 * kSecond;

inline bool on() noexcept { return shared != nullptr; }
TimeNs now() noexcept;
TimeNs wall_now() noexcept;  // CLOCK_MONOTONIC, also while this is off
inline std::int64_t utc() noexcept { return kBeginUtc_ns + now() - kBegin; }

struct Settings {
  double speed = 1;          // against the wall clock; 0: as fast as the machine goes
  double client_speed = -1;  // while a client takes part, unless it waits at `speed`; -1: the same
  TimeNs client_at = -1;     // time stops there until a client takes part; below 0: never
};

// Start-up, before any thread. Each returns an error with its remedy; empty: done.
// The simulator: makes the page in the folder, or takes part in one whose processes live.
std::string create(const std::string& folder, const Settings& settings);
// Other processes. Time stands still from here on until begin().
std::string join(const std::string& folder, const char* program);
// A client of a daemon: one of its threads begins with Settings::client_at.
std::string join_as_client(const std::string& folder);

// Time may move when so many threads of this process take part. False: they did not start.
bool begin(unsigned threads);
// The threads of this process take part no more and wait for nothing.
void leave() noexcept;

// The calling thread takes part from its first turn, which the constructor waits for.
class Part {
 public:
  explicit Part(std::string_view name) noexcept;
  ~Part();
  Part(const Part&) = delete;
  Part& operator=(const Part&) = delete;
};
bool takes_part() noexcept;  // the calling thread
bool gone() noexcept;        // this process left

// For a thread that takes part: until that time, or until it is woken. True: woken.
bool wait(TimeNs until) noexcept;
// The same, not ended by being woken.
void sleep_until(TimeNs time) noexcept;

// One thread waits on it and any other wakes it; not lost when no thread waits yet.
class Waiter {
 public:
  bool wait(TimeNs until) noexcept;  // true: woken
  void wake() noexcept;

 private:
  std::atomic<int> seat_{-1};
  std::atomic<bool> rung_{false};
};

// For the simulator's main thread.
void finish() noexcept;              // time never moves again
bool over() noexcept;                // it was finished
std::string waits_for();             // owner of the turn, "lssd thread bus/legs"; empty: none
std::uint64_t turns() noexcept;      // so far
std::uint64_t handovers() noexcept;  // of them, to another thread than the one before
double slipped_s() noexcept;         // wall time by which the machine was too slow for the speed

// A client and its daemon. The client numbers its commands and its heartbeats from 1 on and stops
// time until its messages were taken and the answers to it were received.
inline constexpr int kMostClients = 4;
class Client {
 public:
  explicit Client(std::string_view source) noexcept;  // of a thread that takes part
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  // False: there are kMostClients already, and nothing here waits.
  bool has_place() const noexcept { return at_ >= 0; }
  // Waits until the daemon took a written message. False: it has not within `limit` of wall time.
  bool await_command(std::uint64_t number, TimeNs limit) const noexcept;
  bool await_heartbeat(std::uint64_t number, TimeNs limit) const noexcept;
  void heard_answer(std::uint64_t number) noexcept;  // to the command of that number
  void wait_at_speed(bool on) noexcept;              // time has Settings::speed for this client
  // Up to the status and the telemetry of these times, the newest received.
  bool all_heard(TimeNs status_ns, TimeNs telemetry_ns) const noexcept;

 private:
  int at_ = -1;
  std::uint64_t answers_ = 0;
};
// The daemon, for the client of that source; no effect without one.
void took_command(std::string_view source, std::uint64_t number) noexcept;
void took_heartbeat(std::string_view source, std::uint64_t number) noexcept;
bool has_heartbeat(std::string_view source, std::uint64_t number) noexcept;  // took it before
void answered(std::string_view source, std::uint64_t number) noexcept;
void said_status(TimeNs time) noexcept;
void said_telemetry(TimeNs time) noexcept;

}  // namespace lss::lockstep
