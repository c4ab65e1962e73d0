// The least a program can do to stop something by a command: a listener that takes commands and
// heartbeats, an event for each emergency stop, and a FIFO thread that writes the stop to its line,
// a pseudo-terminal or a UDP port of the loopback.
//
//   bench-stop-echo DOMAIN PATH|PORT HEX PRIORITY
//
// Where SCHED_FIFO or locked memory is not permitted, it does without, as the daemon.
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "tests/support/plain_dds.h"

enum { EMERGENCY_STOP = 3, DRY_RUN = 1 };

static int event, line;
static uint8_t stop[64];
static size_t stop_size;

static void on_command(dds_entity_t reader, void* argument) {
  (void)argument;
  static lss_Command sample;
  void* pointer = &sample;
  dds_sample_info_t info;
  while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
    if (!info.valid_data || sample.kind != EMERGENCY_STOP || (sample.flags & DRY_RUN) != 0)
      continue;
    const uint64_t one = 1;
    if (write(event, &one, sizeof one) != sizeof one) exit(1);
  }
}

static void on_heartbeat(dds_entity_t reader, void* argument) {
  (void)argument;
  static lss_Heartbeat sample;
  drain(reader, &sample);
}

static void* act(void* argument) {
  (void)argument;
  uint64_t count;
  while (read(event, &count, sizeof count) == sizeof count) {
    for (; count > 0; --count) {
      if (write(line, stop, stop_size) != (ssize_t)stop_size) exit(1);
    }
  }
  return NULL;
}

static int open_line(const char* where) {
  if (where[0] == '/') {
    const int fd = open(where, O_RDWR | O_NOCTTY);
    struct termios settings;
    if (fd < 0 || tcgetattr(fd, &settings) != 0) return -1;
    cfmakeraw(&settings);
    tcsetattr(fd, TCSANOW, &settings);
    return fd;
  }
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  const struct sockaddr_in address = {.sin_family = AF_INET,
                                      .sin_port = htons((uint16_t)atoi(where)),
                                      .sin_addr = {htonl(INADDR_LOOPBACK)}};
  if (connect(fd, (const struct sockaddr*)&address, sizeof address) != 0) return -1;
  return fd;
}

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  for (const char* hex = argv[3]; hex[0] != 0 && hex[1] != 0 && stop_size < sizeof stop; hex += 2) {
    const char digits[3] = {hex[0], hex[1], 0};
    stop[stop_size++] = (uint8_t)strtoul(digits, NULL, 16);
  }
  event = eventfd(0, 0);
  line = open_line(argv[2]);
  if (event < 0 || line < 0) return 2;
  if (mlockall(MCL_CURRENT | MCL_FUTURE) != 0) perror("bench-stop-echo: mlockall");

  pthread_attr_t attributes;
  const struct sched_param parameter = {.sched_priority = atoi(argv[4])};
  pthread_attr_init(&attributes);
  pthread_attr_setinheritsched(&attributes, PTHREAD_EXPLICIT_SCHED);
  pthread_attr_setschedpolicy(&attributes, SCHED_FIFO);
  pthread_attr_setschedparam(&attributes, &parameter);
  pthread_t thread;
  if (pthread_create(&thread, &attributes, act, NULL) != 0 &&
      pthread_create(&thread, NULL, act, NULL) != 0)
    return 2;

  const dds_entity_t participant = join(argv[1]);
  dds_qos_t* qos = reliable_qos();
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  dds_listener_t* listener = dds_create_listener(NULL);
  dds_lset_data_available(listener, on_command);
  const dds_entity_t commands =
      reader_of(participant, &lss_Command_desc, "lss/command", qos, listener);
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  dds_lset_data_available(listener, on_heartbeat);
  const dds_entity_t heartbeats =
      reader_of(participant, &lss_Heartbeat_desc, "lss/heartbeat", qos, listener);
  if (commands < 0 || heartbeats < 0) return 2;
  printf("ready\n");
  fflush(stdout);
  for (;;) pause();
}
