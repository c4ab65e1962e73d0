#include "drivers/can/can_udp.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <string_view>

namespace lss {
namespace {

constexpr std::string_view kLocal = "?local=";
constexpr int kMaxDatagrams = 32;  // of one receive(): a flood must not block the thread

struct Address {
  in_addr host{};
  std::uint16_t port = 0;
  std::uint16_t local = 0;  // 0: the kernel chooses
};

bool read_port(std::string_view text, std::uint16_t& port) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  return error == std::errc{} && end == text.data() + text.size() && port != 0;
}

bool parse(std::string_view text, Address& address) {
  constexpr std::string_view kScheme = CanUdp::kScheme;
  if (!text.starts_with(kScheme)) return false;
  text.remove_prefix(kScheme.size());
  if (const auto at = text.find('?'); at != text.npos) {
    const std::string_view query = text.substr(at);
    if (!query.starts_with(kLocal)) return false;
    if (!read_port(query.substr(kLocal.size()), address.local)) return false;
    text = text.substr(0, at);
  }
  const auto colon = text.rfind(':');
  std::array<char, INET_ADDRSTRLEN> host{};
  if (colon == text.npos || colon == 0 || colon >= host.size()) return false;
  std::copy_n(text.begin(), colon, host.begin());
  return ::inet_pton(AF_INET, host.data(), &address.host) == 1 &&
         read_port(text.substr(colon + 1), address.port);
}

bool is_loopback(in_addr host) { return ntohl(host.s_addr) >> 24 == 127; }

}  // namespace

CanStatus CanUdp::open(const char* path, std::span<const CanFilter> filters) noexcept {
  close_fd();
  error_ = 0;
  dropped_ = 0;
  reader_.clear();
  writer_ = {};
  if (sender_ != nullptr) sender_->restart_sequence();
  filters_ = filters;
  Address address;
  if (!parse(path, address)) return CanStatus::bad_address;
  if (!is_loopback(address.host)) return CanStatus::not_local;
  peer_address_ = address.host.s_addr;
  peer_port_ = htons(address.port);

  fd_ = ::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (fd_ < 0) return failed();
  sockaddr_in own{};
  own.sin_family = AF_INET;
  own.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  own.sin_port = htons(address.local);
  if (::bind(fd_, reinterpret_cast<const sockaddr*>(&own), sizeof own) != 0) {
    const CanStatus status = failed();
    close_fd();
    return status;
  }
  ask_for_stamps(fd_);
  wire_.open(lockstep::line_name(path));
  return CanStatus::ok;
}

bool CanUdp::passes(const CanFrame& frame) const noexcept {
  if (filters_.empty()) return true;
  if (frame.extended || frame.remote) return false;
  return std::any_of(filters_.begin(), filters_.end(), [&frame](const CanFilter& f) {
    return (frame.id & f.mask) == (f.id & f.mask);
  });
}

CanUdp::Datagram CanUdp::next_datagram(CanCounters& counters) noexcept {
  sockaddr_in from{};
  const ssize_t got = take(bytes_, time_ns_, counters, &from);
  if (got < 0) {
    if (error_ == EAGAIN || error_ == EINTR)
      return wire_.awaits(fd_) ? Datagram::skipped : Datagram::none;
    return error_ == ECONNREFUSED ? Datagram::skipped : Datagram::lost;
  }
  if (from.sin_family != AF_INET || from.sin_addr.s_addr != peer_address_ ||
      from.sin_port != peer_port_) {
    ++counters.foreign;
    return Datagram::skipped;
  }
  wire_.took(1);
  reader_.begin(std::span(bytes_).first(static_cast<std::size_t>(got)));
  return Datagram::read;
}

CanTransport::Received CanUdp::receive(std::span<CanFrame> into, CanCounters& counters) noexcept {
  Received result;
  bool left = true;  // there may be more in the kernel
  for (int datagrams = 0; left; ++datagrams) {
    while (result.frames < into.size() && reader_.next(into[result.frames])) {
      CanFrame& frame = into[result.frames];
      frame.time_ns = time_ns_;
      if (frame.error) {
        ++counters.error_frames;  // of the other end's bus, not ours
      } else if (passes(frame)) {
        ++result.frames;
      } else {
        ++counters.filtered;
      }
    }
    if (result.frames == into.size() || datagrams == kMaxDatagrams) break;
    const Datagram datagram = next_datagram(counters);
    left = datagram == Datagram::read || datagram == Datagram::skipped;
    result.lost = datagram == Datagram::lost;
  }
  result.more = left;
  counters.received += result.frames;
  counters.cannelloni = reader_.counters();
  return result;
}

CanTransport::Sent CanUdp::send(std::span<const CanFrame> frames, CanCounters& counters) noexcept {
  Sent result;
  while (result.frames < frames.size()) {
    std::size_t count = 0;
    for (const CanFrame& frame : frames.subspan(result.frames)) {
      if (!writer_.add(frame)) break;
      ++count;
    }
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = peer_address_;
    to.sin_port = peer_port_;
    const std::span<const std::uint8_t> datagram =
        sender_ != nullptr ? writer_.take(sender_->next_sequence()) : writer_.take();
    const ssize_t sent = ::sendto(fd_, datagram.data(), datagram.size(), MSG_DONTWAIT,
                                  reinterpret_cast<const sockaddr*>(&to), sizeof to);
    if (sent < 0) {
      error_ = errno;
      if (error_ == EAGAIN || error_ == ENOBUFS || error_ == EINTR) break;
      counters.send_errors += count;  // they will never be sent
    } else {
      counters.sent += count;
      wire_.sent(1);
    }
    result.frames += count;
  }
  return result;
}

}  // namespace lss
