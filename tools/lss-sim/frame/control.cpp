#include "tools/lss-sim/frame/control.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <fmt/std.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <sys/un.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace lss::sim {
namespace {

constexpr const char* kSocket = "lss-sim.sock";
constexpr const char* kLock = ".lss-sim.lock";

// Reached through the folder's descriptor, so that a long path does not exceed the 108 characters
// of sun_path.
sockaddr_un address_in(const File& folder) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  fmt::format_to_n(address.sun_path, sizeof address.sun_path - 1, "/proc/self/fd/{}/{}",
                   folder.get(), kSocket);
  return address;
}

const sockaddr* generic(const sockaddr_un& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

File open_folder(const std::filesystem::path& folder) {
  return File(::open(folder.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
}

// Neither side may block the other.
void bound_waiting(const File& socket) {
  const timeval limit{.tv_sec = 2, .tv_usec = 0};
  ::setsockopt(socket.get(), SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
  ::setsockopt(socket.get(), SOL_SOCKET, SO_SNDTIMEO, &limit, sizeof limit);
}

std::string receive(const File& socket) {
  char buffer[1024];
  const ssize_t bytes = ::recv(socket.get(), buffer, sizeof buffer, 0);
  return {buffer, bytes > 0 ? static_cast<std::size_t>(bytes) : 0};
}

}  // namespace

tl::expected<Control, std::string> Control::open(const std::filesystem::path& folder) {
  const auto failed = [&](const char* what) {
    return tl::unexpected(fmt::format("cannot {} in {}: {}", what, folder, std::strerror(errno)));
  };
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error)
    return tl::unexpected(fmt::format("cannot make the folder {}: {}", folder, error.message()));

  File lock(::open((folder / kLock).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644));
  if (!lock) return failed("make the lock");
  if (::flock(lock.get(), LOCK_EX | LOCK_NB) != 0) {
    char pid[16] = {};
    [[maybe_unused]] const ssize_t bytes = ::read(lock.get(), pid, sizeof pid - 1);
    return tl::unexpected(
        fmt::format("another lss-sim (process {}) uses {}: stop it, or give this one another --dir",
                    pid, folder));
  }
  const std::string pid = std::to_string(::getpid());
  if (::ftruncate(lock.get(), 0) != 0 || ::write(lock.get(), pid.data(), pid.size()) < 0) {
    return failed("write the lock");
  }

  std::filesystem::remove(folder / kSocket, error);
  File listener(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  const File directory = open_folder(folder);
  const sockaddr_un address = address_in(directory);
  if (!listener || ::bind(listener.get(), generic(address), sizeof address) != 0 ||
      ::listen(listener.get(), 8) != 0) {
    return failed("listen for faults");
  }
  return Control(std::filesystem::absolute(folder), std::move(lock), std::move(listener));
}

Control::~Control() {
  if (!socket_) return;
  std::error_code error;
  std::filesystem::remove(folder_ / kSocket, error);
  std::filesystem::remove(folder_ / kLock, error);
}

void Control::serve(const std::function<std::string(const std::string&)>& handle) {
  const File client(::accept4(socket_.get(), nullptr, nullptr, SOCK_CLOEXEC));
  if (!client) return;
  bound_waiting(client);
  const std::string text = receive(client);
  if (text.empty()) return;
  const std::string wrong = handle(text);
  const std::string answer = wrong.empty() ? "ok" : wrong;
  ::send(client.get(), answer.data(), answer.size(), MSG_NOSIGNAL);
}

Answer send_to_simulator(const std::filesystem::path& folder, const std::string& text,
                         std::string& message) {
  const File directory = open_folder(folder);
  const File socket(::socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0));
  const sockaddr_un address = address_in(directory);
  if (!directory || ::connect(socket.get(), generic(address), sizeof address) != 0) {
    message = fmt::format("no lss-sim runs in {}: start one with: lss-sim NAME --dir {}", folder,
                          folder.string());
    return Answer::nobody;
  }
  bound_waiting(socket);
  std::string answer;
  if (::send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL) >= 0) answer = receive(socket);
  if (answer == "ok") return Answer::ok;
  if (answer.empty()) {
    message = fmt::format("the lss-sim in {} does not answer", folder);
    return Answer::nobody;
  }
  message = answer;
  return Answer::refused;
}

}  // namespace lss::sim
