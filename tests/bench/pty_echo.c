// The least a program can do to answer bytes on a terminal: reads, and writes one byte for each so
// many that came in, there or, with PORT, as a datagram to that port of the loopback.
//
//   bench-pty-echo PATH BYTES PRIORITY CPU [PORT]
#define _GNU_SOURCE
#include <arpa/inet.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "tests/support/plain_realtime.h"

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const int fd = open(argv[1], O_RDWR | O_NOCTTY);
  const long wanted = atol(argv[2]);
  struct termios settings;
  if (fd < 0 || tcgetattr(fd, &settings) != 0) return 2;
  cfmakeraw(&settings);
  tcsetattr(fd, TCSANOW, &settings);
  int answer = fd;
  if (argc > 5) {
    const struct sockaddr_in address = {.sin_family = AF_INET,
                                        .sin_port = htons((uint16_t)atoi(argv[5])),
                                        .sin_addr = {htonl(INADDR_LOOPBACK)}};
    answer = socket(AF_INET, SOCK_DGRAM, 0);
    if (connect(answer, (const struct sockaddr*)&address, sizeof address) != 0) return 2;
  }
  if (!be_real_time(argv[3], argv[4])) return 2;
  printf("ready\n");
  fflush(stdout);

  char bytes[512];
  long got = 0;
  for (;;) {
    const ssize_t count = read(fd, bytes, sizeof bytes);
    if (count <= 0) return 0;
    got += count;
    for (; got >= wanted; got -= wanted) {
      if (write(answer, "a", 1) != 1) return 1;
    }
  }
}
