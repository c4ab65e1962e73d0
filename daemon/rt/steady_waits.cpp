// Cyclone DDS waits on condition variables until times of the wall clock. A wall clock that is set
// back by an hour, as NTP does after a start without a battery, would stop its timers for that
// hour: no heartbeats, no announcements, no retransmissions. In this program such waits end after
// the time that was left when they began. (Cyclone and iceoryx use no conditions of other
// clocks, 2026-11. The thread sanitizer brings this function itself.)

#ifndef __SANITIZE_THREAD__

#include <pthread.h>

#include <ctime>

extern "C" int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                      const timespec* until) {
  constexpr long kSecond_ns = 1'000'000'000;
  timespec wall{}, steady{};
  ::clock_gettime(CLOCK_REALTIME, &wall);
  ::clock_gettime(CLOCK_MONOTONIC, &steady);
  steady.tv_sec += until->tv_sec - wall.tv_sec;
  steady.tv_nsec += until->tv_nsec - wall.tv_nsec;
  if (steady.tv_nsec < 0) {
    steady.tv_nsec += kSecond_ns;
    --steady.tv_sec;
  } else if (steady.tv_nsec >= kSecond_ns) {
    steady.tv_nsec -= kSecond_ns;
    ++steady.tv_sec;
  }
  if (steady.tv_sec < 0) steady = {};  // long past
  return ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &steady);
}

#endif
