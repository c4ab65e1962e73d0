#include "drivers/can/transport.h"

#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>

#include "drivers/lockstep/lockstep.h"

namespace lss {
namespace {

TimeNs read(clockid_t clock) noexcept {
  timespec t{};
  ::clock_gettime(clock, &t);
  return t.tv_sec * kSecond + t.tv_nsec;
}

// From the control data of one message: when the kernel had it, on CLOCK_MONOTONIC; now, without a
// stamp or when the wall clock was set in between. `dropped`: by the kernel since the socket was
// opened, unchanged when not reported.
TimeNs stamp(msghdr& message, const CanClocks& now, std::uint32_t& dropped) noexcept {
  constexpr TimeNs kOldest = kSecond;  // nothing waits that long: the wall clock was set
  TimeNs result = now.monotonic_ns;
  for (cmsghdr* c = CMSG_FIRSTHDR(&message); c != nullptr; c = CMSG_NXTHDR(&message, c)) {
    if (c->cmsg_level != SOL_SOCKET) continue;
    if (c->cmsg_type == SCM_TIMESTAMPNS) {
      timespec t{};
      std::memcpy(&t, CMSG_DATA(c), sizeof t);
      const TimeNs age = now.real_ns - (t.tv_sec * kSecond + t.tv_nsec);
      if (age >= 0 && age < kOldest) result = now.monotonic_ns - age;
    } else if (c->cmsg_type == SO_RXQ_OVFL) {
      std::memcpy(&dropped, CMSG_DATA(c), sizeof dropped);
    }
  }
  return result;
}

}  // namespace

CanStatus CanTransport::failed() noexcept {
  error_ = errno;
  switch (error_) {
    case ENODEV:
    case ENXIO: return CanStatus::absent;
    case ENETDOWN: return CanStatus::down;
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT: return CanStatus::no_can;
    case EADDRINUSE: return CanStatus::in_use;
    case EACCES:
    case EPERM: return CanStatus::denied;
    case EADDRNOTAVAIL: return CanStatus::bad_address;
    default: return CanStatus::failed;
  }
}

void CanTransport::close_fd() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  state_ = CanState::active;
}

CanClocks read_clocks() noexcept {
  if (lockstep::on()) return {lockstep::now(), 0};  // no stamp of the kernel is older
  return {read(CLOCK_MONOTONIC), read(CLOCK_REALTIME)};
}

void ask_for_stamps(int fd) noexcept {
  const int on = 1;
  ::setsockopt(fd, SOL_SOCKET, SO_TIMESTAMPNS, &on, sizeof on);
  ::setsockopt(fd, SOL_SOCKET, SO_RXQ_OVFL, &on, sizeof on);
}

ssize_t CanTransport::take(std::span<std::uint8_t> into, TimeNs& time_ns, CanCounters& counters,
                           sockaddr_in* from) noexcept {
  iovec piece{into.data(), into.size()};
  alignas(cmsghdr) std::array<std::uint8_t, 128> control;
  msghdr message{};
  message.msg_name = from;
  message.msg_namelen = from != nullptr ? sizeof *from : 0;
  message.msg_iov = &piece;
  message.msg_iovlen = 1;
  message.msg_control = control.data();
  message.msg_controllen = control.size();
  const ssize_t got = ::recvmsg(fd_, &message, MSG_DONTWAIT);
  if (got < 0) {
    error_ = errno;
    return got;
  }
  const std::uint32_t dropped = dropped_;
  time_ns = stamp(message, read_clocks(), dropped_);
  counters.overflows += dropped_ - dropped;  // wraps as the kernel's does
  return got;
}

}  // namespace lss
