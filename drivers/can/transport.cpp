#include "drivers/can/transport.h"

#include <sys/socket.h>
#include <unistd.h>

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

}  // namespace

CanStatus CanTransport::failed() noexcept {
  error_ = errno;
  switch (error_) {
    case ENODEV:
    case ENXIO:
      return CanStatus::absent;
    case ENETDOWN:
      return CanStatus::down;
    case EAFNOSUPPORT:
    case EPROTONOSUPPORT:
    case ESOCKTNOSUPPORT:
      return CanStatus::no_can;
    case EADDRINUSE:
      return CanStatus::in_use;
    case EACCES:
    case EPERM:
      return CanStatus::denied;
    case EADDRNOTAVAIL:
      return CanStatus::bad_address;
    default:
      return CanStatus::failed;
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

}  // namespace lss
