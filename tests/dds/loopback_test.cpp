// Nothing leaves the machine unless configured: reads the kernel's list of sockets of this process.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <net/if.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/dds/dds_support.h"

namespace lss {
namespace {

using namespace testing_support;

// IPv4 UDP sockets of this process.
std::vector<int> udp_sockets() {
  std::vector<int> result;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    const int fd = std::stoi(entry.path().filename());
    int domain = 0, type = 0;
    socklen_t size = sizeof domain;
    if (::getsockopt(fd, SOL_SOCKET, SO_DOMAIN, &domain, &size) != 0 || domain != AF_INET) continue;
    size = sizeof type;
    if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0 && type == SOCK_DGRAM) {
      result.push_back(fd);
    }
  }
  return result;
}

// Where multicast that a socket sends goes out.
std::set<std::string> multicast_exits() {
  std::set<std::string> result;
  for (const int fd : udp_sockets()) {
    in_addr address{};
    socklen_t size = sizeof address;
    EXPECT_EQ(::getsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &address, &size), 0);
    result.insert(::inet_ntoa(address));
  }
  return result;
}

// Users of the DDS discovery group 239.255.0.1 by interface, from /proc/net/igmp.
std::map<std::string, int> discovery_members() {
  std::map<std::string, int> result;
  std::ifstream file("/proc/net/igmp");
  std::string line, device;
  std::getline(file, line);
  while (std::getline(file, line)) {
    std::istringstream words(line);
    std::string first, second;
    words >> first >> second;
    if (line[0] != '\t') {
      device = second;
    } else if (first == "0100FFEF") {
      result[device] += std::stoi(second);
    }
  }
  return result;
}

TEST(Loopback, IsTheOnlyInterfaceThatADefaultFaceSendsOnAndListensOn) {
  ::unsetenv("CYCLONEDDS_URI");
  const auto before = discovery_members();
  const auto face =
      value(Face::create(face_parameters("v1"), [](const Request&, std::uint64_t) {}));
  // Sending sockets name 127.0.0.1; receiving ones send no multicast and name none.
  const auto exits = multicast_exits();
  EXPECT_TRUE(exits.contains("127.0.0.1"));
  for (const std::string& exit : exits)
    EXPECT_TRUE(exit == "127.0.0.1" || exit == "0.0.0.0") << exit;
  const auto after = discovery_members();
  ASSERT_TRUE(after.contains("lo"));
  EXPECT_GT(after.at("lo"), 0);
  for (const auto& [device, members] : after) {
    if (device == "lo") continue;
    const auto old = before.find(device);
    EXPECT_EQ(members, old == before.end() ? 0 : old->second) << device;
  }
}

TEST(Loopback, MayBeNamedByCycloneddsUriToo) {
  ::setenv("CYCLONEDDS_URI",
           "<General><Interfaces><NetworkInterface name=\"lo\" multicast=\"true\"/></Interfaces>"
           "</General>",
           1);
  const auto face = Face::create(face_parameters("v1"), [](const Request&, std::uint64_t) {});
  ::unsetenv("CYCLONEDDS_URI");
  EXPECT_TRUE(face.has_value()) << face.error().text;
}

TEST(Loopback, CycloneddsUriStillWins) {
  const std::string log = testing::TempDir() + "lss-cyclone-" + std::to_string(::getpid()) + ".log";
  const std::string uri =
      "<Tracing><Category>config</Category><OutputFile>" + log + "</OutputFile></Tracing>";
  ::setenv("CYCLONEDDS_URI", uri.c_str(), 1);
  {
    const auto face =
        value(Face::create(face_parameters("v1"), [](const Request&, std::uint64_t) {}));
  }
  ::unsetenv("CYCLONEDDS_URI");
  EXPECT_TRUE(std::filesystem::exists(log)) << "the user's tracing was not taken up";
  std::filesystem::remove(log);
}

// A network that is missing keeps no daemon from its vehicle.
TEST(Network, AnInterfaceThatIsNotThereIsLeftOut) {
  Requests requests;
  FaceParameters parameters = face_parameters("v1");
  for (const std::vector<std::string>& interfaces :
       {std::vector<std::string>{"lo", "none0"}, std::vector<std::string>{"none0"}}) {
    parameters.interfaces = interfaces;
    const auto face = value(Face::create(parameters, requests.sink()));
    EXPECT_EQ(face->missing_interfaces(), std::vector<std::string>{"none0"});
    EXPECT_FALSE(face->interfaces_could_return());
    // Receiving sockets name no exit.
    EXPECT_EQ(multicast_exits(), (std::set<std::string>{"0.0.0.0", "127.0.0.1"}));
    Client client(test_domain(), "v1", "client");
    EXPECT_TRUE(eventually([&] { return client.connected(); }));
  }
}

// In a network namespace loopback is down at first.
TEST(Network, AnInterfaceThatComesUpIsFound) {
  const pid_t child = ::fork();
  if (child == 0) {
    const std::vector<std::string> names{"lo"};
    if (::unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) ::_exit(77);
    if (dds::missing_interfaces(names) != names) ::_exit(1);
    const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    ifreq request{};
    std::strcpy(request.ifr_name, "lo");
    request.ifr_flags = IFF_UP;
    if (::ioctl(fd, SIOCSIFFLAGS, &request) != 0) ::_exit(2);
    ::_exit(dds::missing_interfaces(names).empty() ? 0 : 3);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  if (WEXITSTATUS(status) == 77) GTEST_SKIP() << "no namespaces for this user";
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

}  // namespace
}  // namespace lss
