#include "tools/lss-sim/frame/can_end.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/can.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>

namespace lss::sim {
namespace {

constexpr std::string_view kUdp = "udp://";

tl::unexpected<std::string> failed(const std::string& what) {
  return tl::unexpected(fmt::format("cannot {}: {}", what, std::strerror(errno)));
}

std::optional<sockaddr_in> parse_udp(std::string_view text) {
  text.remove_prefix(kUdp.size());
  const std::size_t colon = text.rfind(':');
  if (colon == std::string_view::npos) return {};
  const std::string host(text.substr(0, colon));
  const std::string_view port = text.substr(colon + 1);
  std::uint16_t number = 0;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), number);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  const bool good = error == std::errc{} && end == port.data() + port.size() &&
                    ::inet_pton(AF_INET, host.c_str(), &address.sin_addr) == 1;
  if (!good) return {};
  address.sin_port = htons(number);
  return address;
}

template <typename Address>
const sockaddr* generic(const Address& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

CanFrame from_kernel(const can_frame& raw) {
  CanFrame frame{
      .id = raw.can_id & ((raw.can_id & CAN_EFF_FLAG) != 0 ? CAN_EFF_MASK : CAN_SFF_MASK),
      .extended = (raw.can_id & CAN_EFF_FLAG) != 0,
      .remote = (raw.can_id & CAN_RTR_FLAG) != 0,
      .size = std::min<std::uint8_t>(raw.can_dlc, CAN_MAX_DLEN)};
  std::copy_n(raw.data, frame.size, frame.data.begin());
  return frame;
}

can_frame to_kernel(const CanFrame& frame) {
  can_frame raw{};
  raw.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0) | (frame.remote ? CAN_RTR_FLAG : 0);
  raw.can_dlc = frame.size;
  std::copy_n(frame.data.begin(), frame.size, raw.data);
  return raw;
}

}  // namespace

tl::expected<void, std::string> CanEnd::open() {
  udp_ = address_.starts_with(kUdp);
  return udp_ ? open_udp() : open_interface();
}

tl::expected<void, std::string> CanEnd::open_udp() {
  const auto parsed = parse_udp(address_);
  if (!parsed) {
    return tl::unexpected(fmt::format(
        "'{}' is no address of a CAN bus: write udp://127.0.0.1:PORT, or an interface", address_));
  }
  sockaddr_in own = *parsed;
  File file(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!file || ::bind(file.get(), generic(own), sizeof own) != 0) {
    if (errno != EADDRINUSE) return failed(fmt::format("listen at {}", address_));
    return tl::unexpected(
        fmt::format("{} is in use: stop who has it, or give another --can", address_));
  }
  if (own.sin_port == 0) {
    socklen_t size = sizeof own;
    ::getsockname(file.get(), reinterpret_cast<sockaddr*>(&own), &size);
    address_ = fmt::format("{}:{}", address_.substr(0, address_.rfind(':')), ntohs(own.sin_port));
  }
  file_ = std::move(file);
  wire_.open(address_);
  return {};
}

tl::expected<void, std::string> CanEnd::open_interface() {
  File file(::socket(PF_CAN, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, CAN_RAW));
  if (!file) return failed("use SocketCAN (give --can udp://127.0.0.1:PORT where there is none)");
  sockaddr_can own{};
  own.can_family = AF_CAN;
  own.can_ifindex = static_cast<int>(::if_nametoindex(address_.c_str()));
  if (own.can_ifindex == 0 || ::bind(file.get(), generic(own), sizeof own) != 0) {
    return failed(fmt::format("open the CAN interface '{}'", address_));
  }
  file_ = std::move(file);
  return {};
}

void CanEnd::close() {
  wire_.close();
  file_ = File();
  master_.reset();
}

std::span<const CanFrame> CanEnd::read() {
  frames_.clear();
  udp_ ? read_udp() : read_interface();
  return frames_;
}

void CanEnd::read_udp() {
  if (lockstep::on() && !wire_.coming()) return;
  std::array<std::uint8_t, kMaxDatagram> bytes;
  sockaddr_in from{};
  for (;;) {
    socklen_t size = sizeof from;
    const ssize_t count = ::recvfrom(file_.get(), bytes.data(), bytes.size(), 0,
                                     reinterpret_cast<sockaddr*>(&from), &size);
    if (count < 0 && errno == ECONNREFUSED) continue;  // the master went away meanwhile
    if (count < 0 && wire_.awaits(file_.get())) continue;
    if (count < 0) return;
    wire_.took(1);
    heard_ = wire_.openings();
    master_ = from;
    reader_.begin(std::span(bytes).first(static_cast<std::size_t>(count)));
    for (CanFrame frame; reader_.next(frame);) frames_.push_back(frame);
  }
}

void CanEnd::read_interface() {
  can_frame raw{};
  while (::read(file_.get(), &raw, sizeof raw) == sizeof raw) frames_.push_back(from_kernel(raw));
}

void CanEnd::write(std::span<const CanFrame> frames) {
  for (const CanFrame& frame : frames) {
    if (!udp_) {
      if (frame.error) continue;  // only a kernel sends these
      const can_frame raw = to_kernel(frame);
      [[maybe_unused]] const ssize_t written = ::write(file_.get(), &raw, sizeof raw);
    } else if (!writer_.add(frame)) {
      send_datagram();
      writer_.add(frame);
    }
  }
  if (udp_) send_datagram();
}

void CanEnd::send_datagram() {
  if (writer_.empty()) return;
  const auto bytes = writer_.take();
  if (!master_) return;
  // Another process has the other end, at a port of its own.
  if (lockstep::on() && (!wire_.is_heard() || heard_ != wire_.openings())) return;
  const ssize_t sent =
      ::sendto(file_.get(), bytes.data(), bytes.size(), 0, generic(*master_), sizeof *master_);
  if (sent >= 0) wire_.sent(1);
}

}  // namespace lss::sim
