// Cyclone DDS and iceoryx wait, on condition variables and semaphores, until times of the wall
// clock. A wall clock that is set back by an hour, as by NTP after a start without a battery, would
// stop their timers for that hour: no heartbeats, no announcements, no retransmissions; and RouDi
// drops a program without keep-alive for 1.5 s, frees its ports, and iceoryx ends the program then.
// In this program such waits end after the time that remained when they began. (They use no
// conditions or semaphores of other clocks, 2026-11. The thread sanitizer provides these functions
// itself.)

#ifndef __SANITIZE_THREAD__

#include <pthread.h>
#include <semaphore.h>

#include <ctime>

namespace {

// The time of the monotonic clock that corresponds to `until` of the wall clock.
timespec steady(const timespec& until) {
  constexpr long kSecond_ns = 1'000'000'000;
  timespec wall{}, steady{};
  ::clock_gettime(CLOCK_REALTIME, &wall);
  ::clock_gettime(CLOCK_MONOTONIC, &steady);
  steady.tv_sec += until.tv_sec - wall.tv_sec;
  steady.tv_nsec += until.tv_nsec - wall.tv_nsec;
  if (steady.tv_nsec < 0) {
    steady.tv_nsec += kSecond_ns;
    --steady.tv_sec;
  } else if (steady.tv_nsec >= kSecond_ns) {
    steady.tv_nsec -= kSecond_ns;
    ++steady.tv_sec;
  }
  if (steady.tv_sec < 0) steady = {};  // long past
  return steady;
}

}  // namespace

extern "C" int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                                      const timespec* until) {
  const timespec end = steady(*until);
  return ::pthread_cond_clockwait(condition, mutex, CLOCK_MONOTONIC, &end);
}

extern "C" int sem_timedwait(sem_t* semaphore, const timespec* until) {
  const timespec end = steady(*until);
  return ::sem_clockwait(semaphore, CLOCK_MONOTONIC, &end);
}

#endif
