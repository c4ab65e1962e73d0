#include "drivers/serial/serial_port.h"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace lss {
namespace {

using Status = SerialPort::Status;

struct Rate {
  int baud;
  speed_t speed;
};
constexpr Rate kRates[] = {
    {1200, B1200},       {2400, B2400},       {4800, B4800},       {9600, B9600},
    {19200, B19200},     {38400, B38400},     {57600, B57600},     {115200, B115200},
    {230400, B230400},   {460800, B460800},   {500000, B500000},   {576000, B576000},
    {921600, B921600},   {1000000, B1000000}, {1152000, B1152000}, {1500000, B1500000},
    {2000000, B2000000}, {2500000, B2500000}, {3000000, B3000000}, {3500000, B3500000},
    {4000000, B4000000},
};

Status from_errno(int error) {
  switch (error) {
    case ENOENT:
    case ENOTDIR:
    case ENODEV:
    case ENXIO:
    case EIO:  // a pseudo-terminal without its other end
      return Status::absent;
    case EISDIR:
    case ENOTTY: return Status::not_a_terminal;
    case EBUSY:
    case EWOULDBLOCK: return Status::in_use;
    case EACCES:
    case EPERM:
    case EROFS: return Status::denied;
    default: return Status::failed;
  }
}

bool is_pseudo_terminal(int fd) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return false;
  const unsigned number = major(info.st_rdev);
  return number >= 136 && number <= 143;  // UNIX98 slaves
}

}  // namespace

Status SerialPort::open(const char* path, const SerialFormat& format) noexcept {
  close();
  error_ = 0;
  rs485_granted_ = marked_ = false;
  marks_.clear();
  fd_ = ::open(path, O_RDWR | O_NONBLOCK | O_NOCTTY | O_CLOEXEC);
  if (fd_ < 0) {
    error_ = errno;
    return from_errno(error_);
  }
  const Status status = prepare(format);
  if (status != Status::ok) give_up();  // what waits in its queue may be another program's
  return status;
}

// No setting of the line is changed before we have the lock.
Status SerialPort::prepare(const SerialFormat& format) noexcept {
  if (::isatty(fd_) == 0) {
    error_ = errno;
    return Status::not_a_terminal;
  }
  if (::flock(fd_, LOCK_EX | LOCK_NB) != 0) {
    error_ = errno;
    return from_errno(error_);
  }
  // Keeps out programs that do not lock. The kernel clears it at the last close, which on a
  // pseudo-terminal may never come while its other end keeps it open: a killed daemon could then
  // not come back.
  if (!is_pseudo_terminal(fd_) && ::ioctl(fd_, TIOCEXCL) != 0) {
    error_ = errno;
    return from_errno(error_);
  }
  if (const Status status = set_line(format); status != Status::ok) return status;
  set_rs485(format.half_duplex);
  set_low_latency();
  set_no_closing_wait();
  if (::tcflush(fd_, TCIOFLUSH) != 0) {
    error_ = errno;
    return from_errno(error_);
  }
  return Status::ok;
}

Status SerialPort::set_line(const SerialFormat& format) noexcept {
  const Rate* rate = nullptr;
  for (const Rate& known : kRates) {
    if (known.baud == format.baud) rate = &known;
  }
  if (rate == nullptr) {
    error_ = EINVAL;
    return Status::bad_baud;
  }
  termios line{};
  if (::tcgetattr(fd_, &line) != 0) {
    error_ = errno;
    return from_errno(error_);
  }
  ::cfmakeraw(&line);
  line.c_cflag &= ~static_cast<tcflag_t>(CSTOPB | PARODD | CRTSCTS);
  line.c_cflag |= CLOCAL | CREAD;
  const bool even = format.parity == SerialFormat::Parity::even;
  // A pseudo-terminal has no parity: it drops the setting, which libc reports as a failure when
  // nothing else changes, as at reopening. No byte of it is marked.
  const bool has_bits = !is_pseudo_terminal(fd_);
  const tcflag_t framing = (even && has_bits ? PARENB : 0u) | (format.stop_bits == 2 ? CSTOPB : 0u);
  line.c_cflag |= framing;
  if (even) line.c_iflag |= INPCK | PARMRK;
  // With VMIN 0 a read of 0 would mean "no data" as well as "hung up"; O_NONBLOCK distinguishes
  // them.
  line.c_cc[VMIN] = 1;
  line.c_cc[VTIME] = 0;
  ::cfsetispeed(&line, rate->speed);
  ::cfsetospeed(&line, rate->speed);
  if (::tcsetattr(fd_, TCSANOW, &line) != 0) {
    error_ = errno;
    return error_ == EINVAL ? Status::bad_baud : from_errno(error_);
  }
  // tcsetattr succeeds when any setting was applied.
  termios granted{};
  if (::tcgetattr(fd_, &granted) != 0 || ::cfgetospeed(&granted) != rate->speed ||
      ::cfgetispeed(&granted) != rate->speed) {
    error_ = EINVAL;
    return Status::bad_baud;
  }
  if (has_bits && (granted.c_cflag & (PARENB | CSTOPB)) != framing) {
    error_ = EINVAL;
    return Status::bad_format;
  }
  marked_ = (granted.c_iflag & PARMRK) != 0;
  return Status::ok;
}

// Absent on pseudo-terminals and many USB adapters, which switch by themselves or not at all: not
// fatal. Full duplex leaves driver enable to the board, but never lets it mute the receiver.
void SerialPort::set_rs485(bool half_duplex) noexcept {
  serial_rs485 mode{};
  if (::ioctl(fd_, TIOCGRS485, &mode) != 0) return;
  if (half_duplex) {
    mode.flags |= SER_RS485_ENABLED | SER_RS485_RTS_ON_SEND;
    mode.flags &= ~static_cast<std::uint32_t>(SER_RS485_RTS_AFTER_SEND | SER_RS485_RX_DURING_TX);
  } else {
    if ((mode.flags & SER_RS485_ENABLED) == 0) return;
    mode.flags |= SER_RS485_RX_DURING_TX;
  }
  if (::ioctl(fd_, TIOCSRS485, &mode) != 0) return;
  serial_rs485 granted{};
  if (::ioctl(fd_, TIOCGRS485, &granted) != 0) return;
  rs485_granted_ = (granted.flags & mode.flags) == mode.flags;
}

// Otherwise USB adapters delay bytes by up to 16 ms.
void SerialPort::set_low_latency() noexcept {
  serial_struct settings{};
  if (::ioctl(fd_, TIOCGSERIAL, &settings) != 0) return;
  settings.flags |= static_cast<int>(ASYNC_LOW_LATENCY);
  ::ioctl(fd_, TIOCSSERIAL, &settings);  // an improvement: it goes without, too
}

// See close(). The drivers of many USB adapters ignore TCOFLUSH, so there only this helps. Linux
// permits it to root: docs/install.md has a rule for an OBC.
void SerialPort::set_no_closing_wait() noexcept {
  serial_struct settings{};
  if (::ioctl(fd_, TIOCGSERIAL, &settings) != 0) return;
  if (settings.closing_wait == ASYNC_CLOSING_WAIT_NONE) return;
  settings.closing_wait = ASYNC_CLOSING_WAIT_NONE;
  ::ioctl(fd_, TIOCSSERIAL, &settings);
}

// In close() Linux waits until the line has taken the queue, by default for 30 s, with O_NONBLOCK
// too: a line that takes nothing would hold the thread, and be sent stale bytes later.
void SerialPort::close() noexcept {
  if (fd_ >= 0) ::tcflush(fd_, TCOFLUSH);
  give_up();
}

void SerialPort::give_up() noexcept {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
}

SerialPort::Transfer SerialPort::read(std::span<std::uint8_t> into) noexcept {
  if (into.empty()) return {};
  return outcome(::read(fd_, into.data(), into.size()), true);
}

SerialPort::Transfer SerialPort::read(std::span<LineByte> into) noexcept {
  std::array<std::uint8_t, kMostRaw> raw;
  Transfer got = read(std::span(raw).first(std::min(into.size(), raw.size())));
  const std::span<const std::uint8_t> bytes = std::span(raw).first(got.bytes);
  if (marked_) {
    got.bytes = marks_.decode(bytes, into);
  } else {
    std::transform(bytes.begin(), bytes.end(), into.begin(), [](std::uint8_t byte) {
      return LineByte{byte, false};
    });
  }
  return got;
}

SerialPort::Transfer SerialPort::write(std::span<const std::uint8_t> bytes) noexcept {
  if (bytes.empty()) return {};
  return outcome(::write(fd_, bytes.data(), bytes.size()), false);
}

SerialPort::Transfer SerialPort::outcome(std::ptrdiff_t result, bool zero_is_lost) noexcept {
  if (result > 0) return {static_cast<std::size_t>(result), false};
  if (result == 0) return {0, zero_is_lost};
  error_ = errno;
  return {0, error_ != EAGAIN && error_ != EINTR};
}

const char* text(SerialPort::Status status) noexcept {
  constexpr const char* kTexts[] = {
      // in the order of Status
      "open",
      "there is no such port: plug it in, or name another in the config",
      "it is no serial port: name another in the config",
      "another program has it open: stop that one first",
      "no permission: add the user to the group of the device (often dialout)",
      "it does not have this baud rate: use another in the config",
      "it does not have even parity or two stop bits: use another port",
      "it could not be opened"};
  return kTexts[static_cast<std::size_t>(status)];
}

}  // namespace lss
