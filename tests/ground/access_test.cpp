#include "tools/lss-ground/access.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdio>
#include <fstream>

#include "lss.h"

namespace lss::ground {
namespace {

constexpr const char* kLook = "look-look-look-look";
constexpr const char* kStop = "stop-stop-stop-stop";
constexpr const char* kCommand = "command-command-command";

tl::expected<Door, std::string> door() {
  return Door::parse(std::string("# who\n\nlook ") + kLook + "\n stop  " + kStop +
                         " # the red button\ncommand " + kCommand + "\n",
                     "keys");
}

TEST(Access, AKeyGivesItsRoleAndNothingElseGivesOne) {
  const auto d = door();
  ASSERT_TRUE(d) << d.error();
  EXPECT_EQ(d->admit(kLook), Role::look);
  EXPECT_EQ(d->admit(kStop), Role::stop);
  EXPECT_EQ(d->admit(kCommand), Role::command);
  for (const std::string wrong : {"", "look", "look-look-look-loo", "look-look-look-lookx", "#"})
    EXPECT_EQ(d->admit(wrong), Role::none) << wrong;
}

TEST(Access, WithoutKeysEverybodyMayCommand) {
  EXPECT_FALSE(Door().locked());
  EXPECT_EQ(Door().admit("whatever"), Role::command);
}

TEST(Access, EveryMistakeInAKeyFileIsReportedWithItsLine) {
  const std::string good = std::string("look ") + kLook + "\n";
  for (const std::string& bad : {std::string("pilot ") + kStop, std::string("look"),
                                 std::string("look short"), std::string("look ") + kStop + " more",
                                 std::string("stop ") + kLook, "look " + std::string(129, 'x')}) {
    const auto d = Door::parse(good + bad + "\n", "keys");
    ASSERT_FALSE(d) << bad;
    EXPECT_THAT(d.error(), testing::StartsWith("keys:2: ")) << bad;
    EXPECT_THAT(d.error(), testing::Not(testing::HasSubstr(kLook))) << "a key is not shown";
  }
  EXPECT_FALSE(Door::parse("# nobody\n", "keys"));
}

TEST(Access, AKeyFileThatOthersMayReadIsRefused) {
  const std::string path = testing::TempDir() + "ground_keys";
  std::ofstream(path) << "command " << kCommand << "\n";
  ASSERT_EQ(::chmod(path.c_str(), 0644), 0);
  EXPECT_THAT(Door::read(path).error(), testing::HasSubstr("chmod"));
  ASSERT_EQ(::chmod(path.c_str(), 0640), 0);
  EXPECT_TRUE(Door::read(path));
  std::remove(path.c_str());
  EXPECT_FALSE(Door::read(path));
}

TEST(Access, AddressesAreReadAndNamesAreNot) {
  EXPECT_EQ(parse_listen("8470")->address, "127.0.0.1");
  EXPECT_EQ(parse_listen("localhost:8470")->address, "127.0.0.1");
  EXPECT_EQ(parse_listen("[::1]:80")->address, "::1");
  EXPECT_TRUE(parse_listen("[::1]:80")->loopback());
  EXPECT_TRUE(parse_listen("127.0.0.5:0")->loopback());
  EXPECT_FALSE(parse_listen(":8470")->loopback());
  EXPECT_FALSE(parse_listen("0.0.0.0:8470")->loopback());
  EXPECT_FALSE(parse_listen("10.0.0.7:8470")->loopback());
  for (const char* wrong : {"", "host:80", "127.0.0.1", "127.0.0.1:", "1:2:x", "127.0.0.1:70000",
                            "127.0.0.1:-1", "[::1:80"})
    EXPECT_FALSE(parse_listen(wrong)) << wrong;
}

TEST(Access, OnlyOurOwnPageUnderOurOwnNameMayConnect) {
  const std::string more[] = {"https://ground.example"};
  const auto local = [&](const char* origin, const char* host) {
    return good_origin(origin, host, true, false, more);
  };
  EXPECT_TRUE(local("http://127.0.0.1:8470", "127.0.0.1:8470"));
  EXPECT_TRUE(local("http://localhost:8470", "localhost:8470"));
  EXPECT_TRUE(local("http://[::1]:8470", "[::1]:8470"));
  EXPECT_TRUE(local("http://127.0.0.2:8470", "127.0.0.2:8470"));
  EXPECT_TRUE(local("", "127.0.0.1:8470")) << "no browser";
  EXPECT_TRUE(local("https://ground.example", "ground.example"));
  EXPECT_FALSE(local("http://evil.example", "127.0.0.1:8470"));
  EXPECT_FALSE(local("http://127.0.0.1:9999", "127.0.0.1:8470")) << "another program's page";
  EXPECT_FALSE(local("http://evil.example:8470", "evil.example:8470"))
      << "a foreign name that leads here";
  EXPECT_FALSE(local("", "evil.example:8470"));
  EXPECT_FALSE(local("", "localhost.evil.example"));
  EXPECT_FALSE(local("", "127.evil.example"));
  EXPECT_FALSE(local("null", "127.0.0.1:8470"));
  for (const bool tls : {false, true}) {
    EXPECT_TRUE(good_origin("https://obc:8470", "obc:8470", false, tls, {}));
    EXPECT_EQ(good_origin("http://obc:8470", "obc:8470", false, tls, {}), !tls)
        << "forged on the way";
    EXPECT_FALSE(good_origin("https://evil.example", "obc:8470", false, tls, {}));
    EXPECT_FALSE(good_origin("ftp://obc:8470", "obc:8470", false, tls, {}));
  }
}

TEST(Access, ASourceIsDerivedFromItsSessionAndDoesNotRevealIt) {
  const std::string session(32, 'a');
  EXPECT_EQ(source_of(session), source_of(session));
  EXPECT_NE(source_of(session), source_of(std::string(32, 'b')));
  EXPECT_NE(source_of("short"), source_of("short")) << "anybody could guess it";
  EXPECT_THAT(source_of(session), testing::MatchesRegex("ground:[0-9a-f]{24}"));
  EXPECT_LT(source_of(session).size(), sizeof lss_Command::source) << "it fits as a whole";
}

}  // namespace
}  // namespace lss::ground
