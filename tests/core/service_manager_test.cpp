#include "daemon/runtime/service_manager.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <string>

#include "tests/support/temp_folder.h"

namespace lss {
namespace {

// A socket of a service manager; "@..." is abstract.
class Manager {
 public:
  explicit Manager(const std::string& path) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::memcpy(address.sun_path, path.data(), path.size());
    if (path.front() == '@') address.sun_path[0] = '\0';
    fd_ = ::socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK, 0);
    bound_ = ::bind(fd_, reinterpret_cast<const sockaddr*>(&address),
                    static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size())) == 0;
    ::setenv("NOTIFY_SOCKET", path.c_str(), 1);
  }
  ~Manager() {
    ::unsetenv("NOTIFY_SOCKET");
    ::close(fd_);
  }
  bool bound() const { return bound_; }
  std::string read() const {
    char text[64];
    const ssize_t size = ::recv(fd_, text, sizeof text, 0);
    return size < 0 ? "" : std::string(text, static_cast<std::size_t>(size));
  }

 private:
  int fd_ = -1;
  bool bound_ = false;
};

TEST(ServiceManager, ReceivesTheStateOnEachKindOfSocket) {
  const testing_support::TempFolder folder;
  for (const std::string& path :
       {(folder / "notify").string(), "@lss-notify-" + std::to_string(::getpid())}) {
    const Manager manager(path);
    ASSERT_TRUE(manager.bound()) << path;
    EXPECT_TRUE(tell_service_manager("READY=1"));
    EXPECT_EQ(manager.read(), "READY=1");
    EXPECT_EQ(manager.read(), "");
  }
}

// The queue of a datagram socket is short; without the cure the test hangs.
TEST(ServiceManager, OneThatDoesNotReadIsNotWaitedFor) {
  const testing_support::TempFolder folder;
  const Manager manager((folder / "notify").string());
  ASSERT_TRUE(manager.bound());
  int taken = 0;
  while (taken < 100'000 && tell_service_manager("WATCHDOG=1")) ++taken;
  EXPECT_GT(taken, 0);
  EXPECT_LT(taken, 100'000);
  EXPECT_EQ(manager.read(), "WATCHDOG=1");
  EXPECT_TRUE(tell_service_manager("STOPPING=1")) << "it reads again";
}

TEST(ServiceManager, WithoutOneNothingIsSent) {
  ::unsetenv("NOTIFY_SOCKET");
  EXPECT_FALSE(tell_service_manager("READY=1"));
  ::setenv("NOTIFY_SOCKET", std::string(300, 'x').c_str(), 1);
  EXPECT_FALSE(tell_service_manager("READY=1"));
  ::setenv("NOTIFY_SOCKET", "/nowhere/notify", 1);
  EXPECT_FALSE(tell_service_manager("READY=1"));
  ::unsetenv("NOTIFY_SOCKET");
}

}  // namespace
}  // namespace lss
