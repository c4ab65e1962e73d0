#include "tests/bench/stop_line.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include "daemon/runtime/clock.h"

namespace lss::bench {
namespace {

constexpr int kWait_ms = 50;
constexpr std::size_t kLineLength = 24;  // of a frame of Lunar Zebro
constexpr std::size_t kDatagram = 1472;

int udp() {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) throw NotHere("no UDP socket on the loopback");
  return fd;
}

sockaddr_in loopback_port(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

}  // namespace

void StopLine::expect(TimeNs since_ns) {
  since_ns_ = INT64_MAX;
  first_ns_ = 0;
  since_ns_ = since_ns;
}

void StopLine::saw_stop(TimeNs begin_ns) {
  last_ns_ = begin_ns;
  if (begin_ns >= since_ns_ && first_ns_ == 0) first_ns_ = begin_ns;
}

void StopLine::begin() {
  thread_.emplace("line", kHardwarePriority, kHardwareCpu, [this] {
    while (!stop_) forward();
  });
}

void StopLine::end() {
  stop_ = true;
  thread_.reset();
}

PtyStopLine::PtyStopLine(const std::filesystem::path& simulator) {
  if (!simulator.empty()) {
    simulator_ = ::open(simulator.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    termios settings{};
    if (simulator_ < 0 || ::tcgetattr(simulator_, &settings) != 0)
      throw NotHere("the simulator's port cannot be opened");
    ::cfmakeraw(&settings);
    ::tcsetattr(simulator_, TCSANOW, &settings);
  }
  line_.reserve(kLineLength);
  begin();
}

PtyStopLine::~PtyStopLine() {
  end();
  if (simulator_ >= 0) ::close(simulator_);
}

void PtyStopLine::forward() {
  std::array<pollfd, 2> files{{{terminal_.fd(), POLLIN, 0}, {simulator_, POLLIN, 0}}};
  if (::poll(files.data(), files.size(), kWait_ms) <= 0) return;
  const TimeNs now = now_ns();
  std::array<char, 4096> bytes;
  if (const ssize_t got = ::read(terminal_.fd(), bytes.data(), bytes.size()); got > 0) {
    const auto size = static_cast<std::size_t>(got);
    if (simulator_ >= 0) [[maybe_unused]]
      const auto sent = ::write(simulator_, bytes.data(), size);
    look_at(std::span(bytes).first(size), now);
  }
  if (simulator_ < 0) return;
  if (const ssize_t got = ::read(simulator_, bytes.data(), bytes.size()); got > 0) {
    [[maybe_unused]] const auto sent =
        ::write(terminal_.fd(), bytes.data(), static_cast<std::size_t>(got));
  }
}

void PtyStopLine::look_at(std::span<const char> bytes, TimeNs now_ns) {
  for (const char byte : bytes) {
    if (byte == ':') {
      line_.clear();
      line_ns_ = now_ns;
    }
    if (line_.size() < kLineLength) line_ += byte;
    // ':' AA CC ...: the code 06.
    if (byte == '\n' && line_.size() == kLineLength && line_.compare(3, 2, "06") == 0)
      saw_stop(line_ns_);
  }
}

CanStopLine::CanStopLine(IsStop is_stop, std::uint16_t simulator)
    : is_stop_(is_stop), daemon_(udp()) {
  sockaddr_in address = loopback_port(0);
  socklen_t size = sizeof address;
  auto* generic = reinterpret_cast<sockaddr*>(&address);
  if (::bind(daemon_, generic, size) != 0 || ::getsockname(daemon_, generic, &size) != 0)
    throw NotHere("no UDP port on the loopback");
  port_ = ntohs(address.sin_port);
  if (simulator != 0) {
    simulator_ = udp();
    const sockaddr_in far_end = loopback_port(simulator);
    if (::connect(simulator_, reinterpret_cast<const sockaddr*>(&far_end), sizeof far_end) != 0)
      throw NotHere("the simulator's port cannot be reached");
  }
  begin();
}

CanStopLine::~CanStopLine() {
  end();
  ::close(daemon_);
  if (simulator_ >= 0) ::close(simulator_);
}

void CanStopLine::forward() {
  std::array<pollfd, 2> files{{{daemon_, POLLIN, 0}, {simulator_, POLLIN, 0}}};
  if (::poll(files.data(), files.size(), kWait_ms) <= 0) return;
  const TimeNs now = now_ns();
  std::array<std::uint8_t, kDatagram> bytes;
  sockaddr_in from{};
  socklen_t size = sizeof from;
  auto* sender = reinterpret_cast<sockaddr*>(&from);
  const ssize_t got = ::recvfrom(daemon_, bytes.data(), bytes.size(), 0, sender, &size);
  if (got > 0) {
    const auto datagram = std::span(bytes).first(static_cast<std::size_t>(got));
    if (simulator_ >= 0) {
      [[maybe_unused]] const auto sent = ::send(simulator_, bytes.data(), datagram.size(), 0);
      if (!known_) known_ = ::connect(daemon_, sender, size) == 0;
    }
    look_at(datagram, now);
  }
  if (simulator_ < 0) return;
  const ssize_t answer = ::recv(simulator_, bytes.data(), bytes.size(), 0);
  if (answer > 0 && known_) {
    [[maybe_unused]] const auto sent =
        ::send(daemon_, bytes.data(), static_cast<std::size_t>(answer), 0);
  }
}

// Cannelloni, icd-ardito.md section 12.
void CanStopLine::look_at(std::span<const std::uint8_t> datagram, TimeNs now_ns) {
  constexpr std::size_t kHead = 5, kFrameHead = 5;
  if (datagram.size() < kHead || datagram[0] != 2 || datagram[1] != 0) return;
  for (auto rest = datagram.subspan(kHead); rest.size() >= kFrameHead;) {
    const std::uint32_t id = static_cast<std::uint32_t>(rest[0]) << 24 |
                             static_cast<std::uint32_t>(rest[1]) << 16 |
                             static_cast<std::uint32_t>(rest[2]) << 8 | rest[3];
    const std::size_t length = rest[4];
    if (rest.size() < kFrameHead + length) return;
    if (is_stop_(id, rest.subspan(kFrameHead, length))) saw_stop(now_ns);
    rest = rest.subspan(kFrameHead + length);
  }
}

}  // namespace lss::bench
