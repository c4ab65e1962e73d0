// A minimal daemon of this type: a DDS participant with a reader and a writer, six threads that
// sleep, memory locked as it is touched; says READY=1 as systemd's services do, and waits.
//
//   bench-dds-minimal DOMAIN
#define _GNU_SOURCE
#include <pthread.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "tests/support/plain_dds.h"
#include "zebro.h"

static void* sleep_on(void* argument) {
  while (pause() == -1) {
  }
  return argument;
}

static void say_ready(void) {
  const char* path = getenv("NOTIFY_SOCKET");
  if (path == NULL) return;
  const int fd = socket(AF_UNIX, SOCK_DGRAM, 0);
  struct sockaddr_un address = {.sun_family = AF_UNIX};
  strncpy(address.sun_path, path, sizeof address.sun_path - 1);
  sendto(fd, "READY=1", 7, 0, (struct sockaddr*)&address, sizeof address);
  close(fd);
}

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const dds_entity_t participant = join(argv[1]);
  const dds_entity_t writer =
      writer_of(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", NULL);
  const dds_entity_t reader = reader_of(participant, &lss_Command_desc, "lss/command", NULL, NULL);
  if (writer < 0 || reader < 0) return 2;
  mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT);
  for (int i = 0; i < 6; ++i) {
    pthread_t thread;
    if (pthread_create(&thread, NULL, sleep_on, NULL) != 0) return 2;
  }
  say_ready();
  for (;;) {
    static lss_ZebroTelemetry sample;
    ++sample.frame;
    dds_write(writer, &sample);
    usleep(20000);
  }
}
