#include "idl/roudi.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

namespace lss::dds {
namespace {

// iceoryx 2.0 always binds this path, for each value of IOX_UDS_SOCKET_PATH_PREFIX.
constexpr char kSocketPath[] = "/tmp/roudi";

// Connecting to the path succeeds only while a process has the socket bound and we may write to it;
// the file that a killed RouDi leaves refuses. Nothing is sent. (Probing RouDi's lock file instead
// would make a RouDi that starts at that moment give up.)
bool somebody_listens() {
  const int fd = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, kSocketPath, sizeof kSocketPath);
  const bool connected =
      ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return connected;
}

}  // namespace

std::optional<RoudiIdentity> find_roudi() {
  struct stat file {};
  if (::stat(kSocketPath, &file) != 0 || !S_ISSOCK(file.st_mode) || !somebody_listens()) return {};
  return RoudiIdentity{file.st_dev, file.st_ino,
                       file.st_ctim.tv_sec * std::int64_t{1'000'000'000} + file.st_ctim.tv_nsec};
}

}  // namespace lss::dds
