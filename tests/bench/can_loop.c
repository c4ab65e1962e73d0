// The least a program can do as master of the bus of Ardito: SYNC at its time, all measurements in,
// all orders out at theirs.
//
//   bench-can-loop INTERFACE BEGIN_NS PERIOD_NS LEAD_NS OFFSET_NS CYCLES PRIORITY CPU
#define _GNU_SOURCE
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "tests/support/plain_realtime.h"

enum { MEASUREMENTS = 23, ORDERS = 11 };

static void sleep_until(long long ns) {
  const struct timespec t = {.tv_sec = ns / 1000000000, .tv_nsec = ns % 1000000000};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &t, NULL) != 0) {
  }
}

int main(int argc, char** argv) {
  if (argc < 9) return 2;
  long long boundary = atoll(argv[2]);
  const long long period = atoll(argv[3]), lead = atoll(argv[4]), offset = atoll(argv[5]);
  const int fd = socket(PF_CAN, SOCK_RAW, CAN_RAW);
  const struct can_filter filter[] = {{0x180, 0x780}, {0x280, 0x780}, {0x380, 0x780}};
  const struct timeval limit = {.tv_usec = 50000};
  const struct sockaddr_can address = {.can_family = AF_CAN,
                                       .can_ifindex = (int)if_nametoindex(argv[1])};
  if (fd < 0 || setsockopt(fd, SOL_CAN_RAW, CAN_RAW_FILTER, filter, sizeof filter) != 0 ||
      setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit) != 0 ||
      bind(fd, (const struct sockaddr*)&address, sizeof address) != 0)
    return 2;
  if (!be_real_time(argv[7], argv[8])) return 2;

  const struct can_frame sync = {.can_id = 0x080};
  struct can_frame order[ORDERS], in;
  memset(order, 0, sizeof order);
  static const unsigned ids[ORDERS] = {0x201, 0x202, 0x203, 0x204, 0x205, 0x206,
                                       0x211, 0x212, 0x215, 0x216, 0x220};
  for (int i = 0; i < ORDERS; ++i) {
    order[i].can_id = ids[i];
    order[i].can_dlc = i == ORDERS - 1 ? 1 : 6;
  }
  for (long cycle = atol(argv[6]); cycle > 0; --cycle, boundary += period) {
    sleep_until(boundary - lead);
    if (write(fd, &sync, sizeof sync) != sizeof sync) return 1;
    for (int i = 0; i < MEASUREMENTS; ++i) {
      if (read(fd, &in, sizeof in) != sizeof in) break;
    }
    sleep_until(boundary + offset);
    for (int i = 0; i < ORDERS; ++i) {
      if (write(fd, &order[i], sizeof order[i]) != sizeof order[i]) return 1;
    }
  }
  return 0;
}
