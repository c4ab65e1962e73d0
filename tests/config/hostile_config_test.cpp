// Configurations from others: each is read or refused, and none takes the program with it.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "daemon/config/config.h"
#include "daemon/config/document.h"
#include "daemon/config/syntax.h"

namespace lss::config {
namespace {

std::string minimal(const std::string& more) {
  return "vehicle = 'zebro'\n[[port]]\nname = 'legs'\npath = 'sim:legs'\n" + more;
}
// Empty: it was read.
std::string errors_of(const std::string& text) {
  const auto config = parse(text, "a.toml", {"zebro"}, [](const std::string&, Section&) {});
  return config ? "" : config.error();
}
std::string repeated(std::string_view text, std::size_t times) {
  std::string all;
  for (std::size_t i = 0; i < times; ++i) all += text;
  return all;
}

TEST(HostileConfig, ATextIsOnlySoLong) {
  for (const char* start : {"/dev/", "sim:", "can", "udp://127.0.0.1:"}) {
    const std::string path = start + std::string(200'000, '1');
    EXPECT_NE(
        errors_of(minimal("[[port]]\nname = 'b'\npath = '" + path + "'\n"))
            .find("has " + std::to_string(path.size()) + " characters; at most 1000 are read"),
        std::string::npos);
  }
  EXPECT_NE(errors_of(minimal("[dds]\ninterfaces = ['" + std::string(200'000, 'x') + "']\n"))
                .find("more than 1000 characters"),
            std::string::npos);
}

TEST(HostileConfig, KeysAreOnlySoDeep) {
  for (const char* form :
       {"{} = 1\n", "[{}]\n", "x = {{ {} = 1 }}\n", "x = [\"\"\"a\"\"\"\", {{ {} = 1 }}]\n"}) {
    const std::string key = repeated("a.", 20'000) + "a";
    EXPECT_EQ(errors_of(fmt::format(fmt::runtime(form), key)),
              "a.toml: has a key of more than 16 parts\n");
  }
  EXPECT_EQ(too_much("a = '" + repeated("a.", 1000) + "' # " + repeated("a.", 1000)), std::nullopt);
}

TEST(HostileConfig, AFileIsOnlySoLarge) {
  EXPECT_NE(errors_of(std::string(300'000, '\n')).find("larger than a configuration may be"),
            std::string::npos);
  EXPECT_NE(errors_of(minimal(repeated("[[port]]\nname = 'b'\npath = 'sim:b'\n", 200)))
                .find("has 201 tables; at most 100 are read"),
            std::string::npos);
  EXPECT_NE(errors_of(minimal(repeated("[", 100'000))), "");
  EXPECT_NE(errors_of(minimal(std::string(200'000, 'k') + " = 1\n")).find("unknown key kkk"),
            std::string::npos);
}

TEST(Syntax, OfPathsOfPorts) {
  for (const char* good : {"sim:b", "sim:_.-", "/dev/ttyS1", "can0", "vcan9999",
                           "udp://127.0.0.1:7000", "udp://10.0.0.255:1?local=65535"})
    EXPECT_EQ(path_fault(good), std::nullopt) << good;
  for (const char* bad : {"",
                          "sim:",
                          "sim:.b",
                          "sim:a b",
                          "/",
                          "/dev/",
                          "/dev/a b",
                          "can",
                          "can12345",
                          "xcan0",
                          "udp://127.0.0.1",
                          "udp://127.0.0:1",
                          "udp://127.0.0.1.1:1",
                          "udp://127.0.0.1.:1",
                          "udp://127.0..1:1",
                          "udp://127.0.0.1:",
                          "udp://127.0.0.1:123456",
                          "udp://127.0.0.1:1?local=",
                          "udp://127.0.0.1:1?remote=1",
                          "udp://127.0.0.1:1?local=1x",
                          "udp://:1",
                          "udp://1234.0.0.1:1"})
    EXPECT_NE(path_fault(bad).value_or("").find("is no port"), std::string::npos) << bad;
}

}  // namespace
}  // namespace lss::config
