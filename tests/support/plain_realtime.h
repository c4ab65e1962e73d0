// What plain C programs with a real-time loop begin with: SCHED_FIFO on one CPU, memory locked.
// _GNU_SOURCE is defined before any include.
#pragma once

#include <sched.h>
#include <stdbool.h>
#include <stdlib.h>
#include <sys/mman.h>

// `priority` and `cpu`: words of the command line. False without the permission.
static inline bool be_real_time(const char* priority, const char* cpu) {
  cpu_set_t set;
  CPU_ZERO(&set);
  CPU_SET((size_t)atoi(cpu), &set);
  const struct sched_param parameter = {.sched_priority = atoi(priority)};
  return sched_setaffinity(0, sizeof set, &set) == 0 &&
         sched_setscheduler(0, SCHED_FIFO, &parameter) == 0 &&
         mlockall(MCL_CURRENT | MCL_FUTURE) == 0;
}
