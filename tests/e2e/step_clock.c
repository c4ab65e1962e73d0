// Preloaded into the daemon: sets its wall clock, and only that, by as many seconds as the file says that
// LSS_E2E_CLOCK names, as `date -s` would set the machine's. Eight bytes, read at each call.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <time.h>

static const volatile int64_t *step_s;
static int (*real)(clockid_t, struct timespec *);

__attribute__((constructor)) static void begin(void) {
  real = (int (*)(clockid_t, struct timespec *))dlsym(RTLD_NEXT, "clock_gettime");
  const char *path = getenv("LSS_E2E_CLOCK");
  const int fd = path != NULL ? open(path, O_RDONLY | O_CLOEXEC) : -1;
  if (fd < 0) return;
  void *file = mmap(NULL, sizeof *step_s, PROT_READ, MAP_SHARED | MAP_POPULATE, fd, 0);
  if (file != MAP_FAILED) step_s = file;
}

time_t time(time_t *into) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (into != NULL) *into = now.tv_sec;
  return now.tv_sec;
}

int clock_gettime(clockid_t clock, struct timespec *time) {
  if (real == NULL) begin();
  const int result = real(clock, time);
  if (clock == CLOCK_REALTIME && step_s != NULL) time->tv_sec += *step_s;
  return result;
}
