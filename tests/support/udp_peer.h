#pragma once

// A datagram socket on a free port of the loopback interface: the other end of a CAN bus over UDP.

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <string>

namespace lss::testing_support {

class UdpPeer {
 public:
  UdpPeer() {
    const sockaddr_in own = loopback(0);
    if (::bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own) == 0) port_ = port_of(fd_);
  }
  ~UdpPeer() { ::close(fd_); }
  UdpPeer(const UdpPeer&) = delete;
  UdpPeer& operator=(const UdpPeer&) = delete;

  static sockaddr_in loopback(std::uint16_t port) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    address.sin_port = htons(port);
    return address;
  }
  static std::uint16_t port_of(int fd) {
    sockaddr_in own{};
    socklen_t size = sizeof own;
    const int failed = ::getsockname(fd, reinterpret_cast<sockaddr*>(&own), &size);
    return failed == 0 ? ntohs(own.sin_port) : std::uint16_t{0};
  }

  int fd() const { return fd_; }
  std::uint16_t port() const { return port_; }  // 0: there is none
  std::string path() const { return "udp://127.0.0.1:" + std::to_string(port_); }

 private:
  int fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  std::uint16_t port_ = 0;
};

}  // namespace lss::testing_support
