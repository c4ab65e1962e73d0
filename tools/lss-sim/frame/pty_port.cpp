#include "tools/lss-sim/frame/pty_port.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/std.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <system_error>

namespace lss::sim {
namespace {

tl::unexpected<std::string> failed(const std::string& what) {
  return tl::unexpected(fmt::format("cannot {}: {}", what, std::strerror(errno)));
}

}  // namespace

tl::expected<void, std::string> PtyPort::open() {
  File master(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  char name[64];
  if (!master || ::grantpt(master.get()) != 0 || ::unlockpt(master.get()) != 0 ||
      ::ptsname_r(master.get(), name, sizeof name) != 0) {
    return failed("make a pseudo-terminal");
  }
  File slave(::open(name, O_RDWR | O_NOCTTY | O_CLOEXEC));
  termios settings{};
  if (!slave || ::tcgetattr(slave.get(), &settings) != 0)
    return failed(fmt::format("open {}", name));
  ::cfmakeraw(&settings);
  if (::tcsetattr(slave.get(), TCSANOW, &settings) != 0)
    return failed(fmt::format("set up {}", name));

  const std::filesystem::path fresh = link_.string() + ".new";
  std::error_code error;
  std::filesystem::remove(fresh, error);
  std::filesystem::create_symlink(name, fresh, error);
  if (!error) std::filesystem::rename(fresh, link_, error);
  if (error)
    return tl::unexpected(fmt::format("cannot make the link {}: {}", link_, error.message()));
  master_ = std::move(master);
  slave_ = std::move(slave);
  terminal_ = name;
  return {};
}

void PtyPort::close() {
  if (!is_open()) return;
  std::error_code error;
  if (std::filesystem::read_symlink(link_, error) == terminal_)
    std::filesystem::remove(link_, error);
  slave_ = File();
  master_ = File();
}

std::span<const std::uint8_t> PtyPort::read() {
  const ssize_t bytes = ::read(master_.get(), buffer_, sizeof buffer_);
  return {buffer_, bytes > 0 ? static_cast<std::size_t>(bytes) : 0};
}

std::size_t PtyPort::write(std::span<const std::uint8_t> bytes) {
  // Short writes happen when nobody reads: the remaining bytes are lost.
  const ssize_t written = ::write(master_.get(), bytes.data(), bytes.size());
  return written > 0 ? static_cast<std::size_t>(written) : 0;
}

}  // namespace lss::sim
