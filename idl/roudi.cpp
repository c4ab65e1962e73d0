#include "idl/roudi.h"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>
#include <thread>

namespace lss::dds {
namespace {

// iceoryx 2.0 always binds this path, for each value of IOX_UDS_SOCKET_PATH_PREFIX.
constexpr char kSocketPath[] = "/tmp/roudi";

// IpcMessageType::KEEPALIVE of iceoryx 2.0, from a name that no process has: nothing follows. Of
// another version another message, which is not known either.
constexpr char kMessage[] = "17,lss-looks-whether-RouDi-answers,";
constexpr auto kPoll = std::chrono::microseconds(200);

// Connecting to the path succeeds only while a process has the socket bound and we may write to it;
// the file that a killed RouDi leaves refuses. Nothing is sent. (Probing RouDi's lock file instead
// would make a RouDi that starts at that moment give up.) -1: nobody listens.
int connected_to_roudi() {
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return -1;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, kSocketPath, sizeof kSocketPath);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  ::close(fd);
  return -1;
}

bool somebody_listens() {
  const int fd = connected_to_roudi();
  if (fd >= 0) ::close(fd);
  return fd >= 0;
}

}  // namespace

std::optional<RoudiIdentity> find_roudi() {
  struct stat file {};
  if (::stat(kSocketPath, &file) != 0 || !S_ISSOCK(file.st_mode) || !somebody_listens()) return {};
  return RoudiIdentity{file.st_dev, file.st_ino,
                       file.st_ctim.tv_sec * std::int64_t{1'000'000'000} + file.st_ctim.tv_nsec};
}

RoudiCall::RoudiCall()
    : fd_(connected_to_roudi()),
      sent_(fd_ >= 0 && ::send(fd_, kMessage, sizeof kMessage, MSG_NOSIGNAL) > 0) {}

RoudiCall::~RoudiCall() {
  if (fd_ >= 0) ::close(fd_);
}

bool RoudiCall::taken() const {
  int unread = 0;  // of what this socket sent, in its receiver's queue (unix(7))
  return sent_ && ::ioctl(fd_, SIOCOUTQ, &unread) == 0 && unread == 0;
}

bool roudi_answers(std::chrono::milliseconds limit) {
  std::optional<RoudiCall> call(std::in_place);
  const auto end = std::chrono::steady_clock::now() + limit;
  while (!call->taken()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(kPoll);
    if (!call->sent()) call.emplace();  // its queue was full
  }
  return true;
}

}  // namespace lss::dds
