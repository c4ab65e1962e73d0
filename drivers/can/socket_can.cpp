#include "drivers/can/socket_can.h"

#include <linux/can.h>
#include <linux/can/error.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <net/if_arp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace lss {
namespace {

constexpr int kReceiveBuffer = 256 * 1024;

bool from_kernel(const can_frame& raw, CanFrame& frame) noexcept {
  frame = {};
  frame.error = (raw.can_id & CAN_ERR_FLAG) != 0;
  frame.extended = (raw.can_id & CAN_EFF_FLAG) != 0;
  frame.remote = (raw.can_id & CAN_RTR_FLAG) != 0;
  frame.id = raw.can_id & (frame.error || frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
  if (raw.can_dlc > CAN_MAX_DLEN) return false;
  frame.size = raw.can_dlc;
  if (!frame.remote) std::copy_n(raw.data, frame.size, frame.data.begin());
  return true;
}

}  // namespace

can_frame to_kernel(const CanFrame& frame) noexcept {
  can_frame raw{};
  raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0u) | (frame.remote ? CAN_RTR_FLAG : 0u);
  raw.can_dlc = std::min<std::uint8_t>(frame.size, CAN_MAX_DLEN);
  std::copy_n(frame.data.begin(), raw.can_dlc, raw.data);
  return raw;
}

CanStatus SocketCan::open(const char* interface, std::span<const CanFilter> filters) noexcept {
  close_fd();
  error_ = 0;
  dropped_ = 0;
  const std::size_t length = std::strlen(interface);
  if (length == 0 || length >= IFNAMSIZ) return CanStatus::bad_address;
  fd_ = ::socket(PF_CAN, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, CAN_RAW);
  if (fd_ < 0) return failed();
  const CanStatus status = prepare(interface, filters);
  if (status != CanStatus::ok) close_fd();
  return status;
}

CanStatus SocketCan::prepare(const char* interface, std::span<const CanFilter> filters) noexcept {
  ifreq request{};
  std::strncpy(request.ifr_name, interface, IFNAMSIZ - 1);
  if (::ioctl(fd_, SIOCGIFINDEX, &request) != 0) return failed();
  const int index = request.ifr_ifindex;
  if (::ioctl(fd_, SIOCGIFHWADDR, &request) != 0) return failed();
  if (request.ifr_hwaddr.sa_family != ARPHRD_CAN) return CanStatus::not_can;
  if (::ioctl(fd_, SIOCGIFFLAGS, &request) != 0) return failed();
  if ((request.ifr_flags & IFF_UP) == 0) return CanStatus::down;

  if (filters.size() > kMaxFilters) {
    error_ = EINVAL;
    return CanStatus::failed;
  }
  if (!filters.empty()) {  // none: all pass
    std::array<can_filter, kMaxFilters> raw{};
    std::transform(filters.begin(), filters.end(), raw.begin(), [](const CanFilter& f) {
      return can_filter{f.id, f.mask | CAN_EFF_FLAG | CAN_RTR_FLAG};
    });
    const auto size = static_cast<socklen_t>(filters.size() * sizeof(can_filter));
    if (::setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_FILTER, raw.data(), size) != 0) return failed();
  }
  const can_err_mask_t errors = CAN_ERR_BUSOFF | CAN_ERR_RESTARTED | CAN_ERR_CRTL;
  if (::setsockopt(fd_, SOL_CAN_RAW, CAN_RAW_ERR_FILTER, &errors, sizeof errors) != 0) {
    return failed();
  }
  // A flood of foreign frames must not displace an answer. A smaller buffer is no error.
  ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &kReceiveBuffer, sizeof kReceiveBuffer);
  ask_for_stamps(fd_);

  sockaddr_can address{};
  address.can_family = AF_CAN;
  address.can_ifindex = index;
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return failed();
  }
  return CanStatus::ok;
}

// One frame per call: frames come one by one at the pace of a bus, and checking for another one
// takes as long as this. poll reports it.
CanTransport::Received SocketCan::receive(std::span<CanFrame> into,
                                          CanCounters& counters) noexcept {
  can_frame raw{};
  TimeNs time = 0;
  const ssize_t got = take({reinterpret_cast<std::uint8_t*>(&raw), sizeof raw}, time, counters);
  if (got < 0) return {0, false, error_ != EAGAIN && error_ != EINTR && error_ != ENOBUFS};
  CanFrame& frame = into.front();
  if (got != sizeof raw || !from_kernel(raw, frame)) return {};
  frame.time_ns = time;
  if (frame.error) {
    told(frame, counters);
    return {};
  }
  ++counters.received;
  return {1, false, false};
}

// Bus-off ends by `restart-ms` of the interface, by `ip link set can0 type can restart`, or by
// taking it down and up, which is `lost` here.
void SocketCan::told(const CanFrame& error, CanCounters& counters) noexcept {
  ++counters.error_frames;
  if ((error.id & CAN_ERR_BUSOFF) != 0) {
    if (state_ != CanState::bus_off) ++counters.bus_offs;
    state_ = CanState::bus_off;
  }
  if ((error.id & CAN_ERR_RESTARTED) != 0) {
    ++counters.restarts;
    state_ = CanState::active;
  }
  if ((error.id & CAN_ERR_CRTL) != 0 && state_ != CanState::bus_off) {
    if ((error.data[1] & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0) {
      if (state_ != CanState::passive) ++counters.error_passive;
      state_ = CanState::passive;
    } else if ((error.data[1] & CAN_ERR_CRTL_ACTIVE) != 0) {
      state_ = CanState::active;
    }
    if ((error.data[1] & CAN_ERR_CRTL_RX_OVERFLOW) != 0) ++counters.overflows;
  }
}

CanTransport::Sent SocketCan::send(std::span<const CanFrame> frames,
                                   CanCounters& counters) noexcept {
  Sent result;
  for (const CanFrame& frame : frames) {
    const can_frame raw = to_kernel(frame);
    if (::write(fd_, &raw, sizeof raw) == static_cast<ssize_t>(sizeof raw)) {
      ++result.frames;
      ++counters.sent;
      continue;
    }
    error_ = errno;
    // The queue of the device is full (ENOBUFS, which poll does not report) or of the socket.
    if (error_ == ENOBUFS || error_ == EAGAIN || error_ == EINTR) break;
    if (error_ == ENETDOWN || error_ == ENODEV || error_ == ENXIO) {
      result.lost = true;
      break;
    }
    ++counters.send_errors;  // this frame will never be sent
    ++result.frames;
  }
  return result;
}

}  // namespace lss
