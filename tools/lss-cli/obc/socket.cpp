#include "tools/lss-cli/obc/socket.h"

#include <fmt/format.h>
#include <grp.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::obc {
namespace {

constexpr std::size_t kMostUnsent = 1 << 20;  // bytes; a reply has some 10,000
constexpr std::size_t kAtOnce = 1 << 18;  // bytes, more than fit into the socket: a turn reads all
constexpr mode_t kMode = 0660;

sockaddr_un address_of(const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) {
    throw Failure(ExitCode::usage, fmt::format("--socket: '{}' must have 1 to {} characters", path,
                                               sizeof address.sun_path - 1));
  }
  std::memcpy(address.sun_path, path.data(), path.size());
  return address;
}

gid_t group_of(const std::string& name) {
  if (name.empty()) return getegid();
  const ::group* found = getgrnam(name.c_str());
  if (found == nullptr)
    throw Failure(ExitCode::unknown_name, fmt::format("there is no group '{}'", name),
                  "see: getent group");
  return found->gr_gid;
}

// Whether a process has a socket there; removes the file of one that has ended. The type is another
// than that of the server (EPROTOTYPE): a connection would replace that of the OBC.
bool is_taken(const sockaddr_un& address) {
  struct stat file {};
  if (lstat(address.sun_path, &file) != 0 || !S_ISSOCK(file.st_mode)) return false;
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const bool dead =
      ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
      errno == ECONNREFUSED;
  close(fd);
  if (dead) unlink(address.sun_path);
  return !dead;
}

}  // namespace

Socket::Socket(std::string path, const std::string& group) : path_(std::move(path)) {
  try {
    open(group);
  } catch (...) {
    close(listener_);
    close(epoll_);
    throw;
  }
}

void Socket::open(const std::string& group) {
  const sockaddr_un address = address_of(path_);
  const gid_t gid = group_of(group);
  if (is_taken(address)) {
    throw Failure(ExitCode::usage, fmt::format("another process listens at {}", path_),
                  "end it, or name another --socket");
  }
  listener_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  epoll_ = epoll_create1(EPOLL_CLOEXEC);
  const mode_t before = umask(0777 & ~0600);  // until it has its group
  const bool bound =
      ::bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  const int error = errno;
  umask(before);
  if (!bound) {
    throw Failure(ExitCode::usage,
                  fmt::format("cannot make the socket {}: {}", path_, std::strerror(error)),
                  "its folder must exist and be writable; remove a file of that name");
  }
  if ((!group.empty() && chown(path_.c_str(), static_cast<uid_t>(-1), gid) != 0) ||
      chmod(path_.c_str(), kMode) != 0) {
    const int refused = errno;
    unlink(path_.c_str());
    throw Failure(
        ExitCode::usage,
        fmt::format("cannot give {} to the group '{}': {}", path_, group, std::strerror(refused)),
        "this user must be in it");
  }
  watch(EPOLL_CTL_ADD, listener_, false);
  if (listen(listener_, 4) != 0)
    throw Failure(ExitCode::internal, fmt::format("cannot listen: {}", std::strerror(errno)));
}

Socket::~Socket() {
  disconnect();
  unlink(path_.c_str());
  close(listener_);
  close(epoll_);
}

void Socket::watch(int operation, int fd, bool writes) const {
  epoll_event event{};
  event.events = EPOLLIN | (writes ? EPOLLOUT : 0U);
  event.data.fd = fd;
  epoll_ctl(epoll_, operation, fd, &event);
}

bool Socket::connect() {
  const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client < 0) return false;
  disconnect();
  client_ = client;
  watch(EPOLL_CTL_ADD, client_, false);
  return true;
}

void Socket::disconnect() {
  if (client_ >= 0) close(client_);
  client_ = -1;
  yields_ = false;
  lines_ = {};
  unsent_.clear();
}

Socket::News Socket::take() {
  News news;
  pollfd another{listener_, POLLIN, 0};
  const bool waits = ::poll(&another, 1, 0) == 1;
  if (waits && (client_ < 0 || yields_)) {
    news.connected = connect();
  } else {
    yields_ = waits;
  }
  if (client_ < 0) return news;
  std::array<char, kAtOnce> buffer;
  const ssize_t count = recv(client_, buffer.data(), buffer.size(), 0);
  if (count > 0) {
    news.lines = lines_.add({buffer.data(), static_cast<std::size_t>(count)});
  } else if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
    disconnect();
  }
  flush();
  return news;
}

void Socket::send(std::string_view text) {
  if (client_ < 0) return;
  unsent_ += text;
  flush();
  if (unsent_.size() > kMostUnsent) disconnect();
}

void Socket::flush() {
  if (client_ < 0 || unsent_.empty()) return;
  const ssize_t count = ::send(client_, unsent_.data(), unsent_.size(), MSG_NOSIGNAL);
  if (count > 0) unsent_.erase(0, static_cast<std::size_t>(count));
  if (count < 0 && errno != EAGAIN && errno != EINTR) return disconnect();
  watch(EPOLL_CTL_MOD, client_, !unsent_.empty());
}

}  // namespace lss::cli::obc
