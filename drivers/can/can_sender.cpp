#include "drivers/can/can_sender.h"

#include <fcntl.h>
#include <linux/can.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>

#include "drivers/can/socket_can.h"

namespace lss {
namespace {

constexpr std::uint64_t kMostFd = 0xFFFE;

std::uint64_t pack(int fd, std::uint32_t address, std::uint16_t port) {
  return std::uint64_t{address} << 32 | std::uint64_t{port} << 16 | static_cast<std::uint16_t>(fd);
}
int fd_of(std::uint64_t handle) { return static_cast<int>(handle & 0xFFFF); }

}  // namespace

void CanSender::offer(int fd, std::uint32_t peer_address, std::uint16_t peer_port) noexcept {
  withdraw();
  // First: a thread that takes the new port then sees the new generation.
  renew();
  const int own = ::fcntl(fd, F_DUPFD_CLOEXEC, 0);
  if (own >= 0 && static_cast<std::uint64_t>(own) <= kMostFd) {
    handle_.store(pack(own, peer_address, peer_port), std::memory_order_release);
  } else if (own >= 0) {
    ::close(own);
  }
}

// When the second thread has the handle, the handle changes here: that thread notices it and closes
// the descriptor.
void CanSender::withdraw() noexcept {
  const std::uint64_t handle = handle_.exchange(kNone, std::memory_order_acq_rel);
  if (handle != kNone && handle != kTaken) ::close(fd_of(handle));
}

CanSender::Result CanSender::send(const CanFrame& frame) noexcept {
  const std::uint64_t handle = handle_.exchange(kTaken, std::memory_order_acq_rel);
  if (handle == kNone) {
    std::uint64_t taken = kTaken;  // unless a port was offered meanwhile
    handle_.compare_exchange_strong(taken, kNone, std::memory_order_acq_rel);
    closed_.fetch_add(1, std::memory_order_relaxed);
    return Result::closed;
  }
  // Frames for the earlier bus are not for this one.
  const bool same = generation_.load(std::memory_order_acquire) == seen_;
  const Result result = same ? put(handle, frame) : Result::closed;
  std::uint64_t taken = kTaken;
  if (!handle_.compare_exchange_strong(taken, handle, std::memory_order_acq_rel)) {
    ::close(fd_of(handle));
  }
  (result == Result::sent     ? sent_
   : result == Result::full   ? full_
   : result == Result::closed ? closed_
                              : failed_)
      .fetch_add(1, std::memory_order_relaxed);
  return result;
}

CanSender::Result CanSender::put(std::uint64_t handle, const CanFrame& frame) noexcept {
  const auto port = static_cast<std::uint16_t>(handle >> 16);
  ssize_t done = 0;
  if (port == 0) {
    const can_frame raw = to_kernel(frame);
    done = ::write(fd_of(handle), &raw, sizeof raw);
  } else {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = static_cast<std::uint32_t>(handle >> 32);
    to.sin_port = port;
    writer_.add(frame);
    const auto datagram = writer_.take(next_sequence());
    done = ::sendto(fd_of(handle), datagram.data(), datagram.size(), MSG_DONTWAIT,
                    reinterpret_cast<const sockaddr*>(&to), sizeof to);
    if (lockstep::Wire* const wire = wire_.load(); wire != nullptr && done >= 0) wire->sent(1);
  }
  if (done >= 0) return Result::sent;
  return errno == EAGAIN || errno == ENOBUFS || errno == EINTR ? Result::full : Result::failed;
}

CanSender::Counters CanSender::counters() const noexcept {
  const auto read = [](const std::atomic<std::uint64_t>& n) {
    return n.load(std::memory_order_relaxed);
  };
  return {read(sent_), read(closed_), read(full_), read(failed_)};
}

}  // namespace lss
