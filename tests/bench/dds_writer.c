// Writes telemetry samples at a fixed rate, each with the time just before it is written.
//
//   bench-dds-writer DOMAIN PERIOD_US
#define _GNU_SOURCE
#include <time.h>

#include "tests/support/plain_dds.h"
#include "zebro.h"

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  const long period_ns = atol(argv[2]) * 1000;
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  const dds_entity_t writer =
      writer_of(join(argv[1]), &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", qos);
  if (writer < 0) return 2;
  static lss_ZebroTelemetry sample;
  struct timespec next;
  clock_gettime(CLOCK_MONOTONIC, &next);
  for (;;) {
    next.tv_nsec += period_ns;
    next.tv_sec += next.tv_nsec / 1000000000;
    next.tv_nsec %= 1000000000;
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, NULL);
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    sample.time_ns = now.tv_sec * 1000000000LL + now.tv_nsec;
    ++sample.frame;
    if (dds_write(writer, &sample) < 0) return 1;
  }
}
