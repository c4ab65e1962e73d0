#include "tools/lss-ground/message.h"

#include <gtest/gtest.h>

#include "idl/commands.h"

namespace lss::ground {
namespace {

TEST(Message, EachTypeIsReadAsItIsWritten) {
  const auto hello = parse_message(R"({"type":"hello","key":"k","session":"s"})");
  ASSERT_TRUE(hello) << hello.error();
  EXPECT_EQ(std::get<Hello>(*hello).key, "k");
  EXPECT_EQ(std::get<Hello>(*hello).session, "s");
  EXPECT_TRUE(parse_message(R"({"type":"hello"})"));

  EXPECT_EQ(std::get<Beat>(*parse_message(R"({"type":"beat","n":7})")).n, 7u);

  const auto order = parse_message(
      R"({"type":"command","id":3,"vehicle":"z","command":"walk","parameters":{"speed":3,"heading":-0.5},
          "dry_run":true,"whole":true,"lease_ms":500})");
  ASSERT_TRUE(order) << order.error();
  const Order& o = std::get<Order>(*order);
  EXPECT_EQ(o.id, 3u);
  EXPECT_EQ(o.vehicle, "z");
  EXPECT_EQ(o.command, "walk");
  EXPECT_EQ(o.parameters, (std::map<std::string, double>{{"heading", -0.5}, {"speed", 3}}));
  EXPECT_TRUE(o.dry_run && o.whole);
  EXPECT_EQ(o.lease_ms, 500u);
  EXPECT_EQ(o.name, "");
  EXPECT_EQ(
      std::get<Order>(
          *parse_message(
              R"({"type":"command","id":3,"vehicle":"z","command":"set-parameter","name":"a.b"})"))
          .name,
      "a.b");

  const auto stop = parse_message(R"({"type":"stop","id":1})");
  ASSERT_TRUE(stop) << stop.error();
  EXPECT_EQ(std::get<Stop>(*stop).vehicle, "") << "all of them";
  EXPECT_FALSE(std::get<Stop>(*stop).land);
  EXPECT_TRUE(
      std::get<Stop>(*parse_message(R"({"type":"stop","id":1,"vehicle":"t","land":true})")).land);

  EXPECT_EQ(
      std::get<Script>(
          *parse_message(R"({"type":"script","id":1,"vehicle":"t","text":"0s valves 1 for 1s"})"))
          .text,
      "0s valves 1 for 1s");
}

TEST(Message, WhatIsNotExactlyThatIsRefusedWithASentence) {
  const std::string long_name(65, 'x');
  for (
      const std::string& text : {
          std::string(""),
          std::string("{"),
          std::string("null"),
          std::string("[]"),
          std::string("7"),
          std::string("{}"),
          std::string(R"({"type":7})"),
          std::string(R"({"type":"fly"})"),
          std::string(R"({"type":"beat"})"),
          std::string(R"({"type":"beat","n":-1})"),
          std::string(R"({"type":"beat","n":1.5})"),
          std::string(R"({"type":"beat","n":"1"})"),
          std::string(R"({"type":"beat","n":1,"m":2})"),
          std::string(R"({"type":"beat","n":1}{})"),
          std::string(R"({"type":"command","id":1,"vehicle":"z","command":"walk","lease_ms":299})"),
          std::string(
              R"({"type":"command","id":1,"vehicle":"z","command":"walk","lease_ms":60001})"),
          std::string(R"({"type":"stop","id":1,"vehicle":null})"),
          std::string(R"({"type":"stop","id":1,"vehicle":"longer than any id"})"),
          std::string(
              R"({"type":"command","id":1,"vehicle":"z","command":"walk","parameters":[1]})"),
          std::string(
              R"({"type":"command","id":1,"vehicle":"z","command":"walk","parameters":{"a":"1"}})"),
          std::string(
              R"({"type":"command","id":1,"vehicle":"z","command":"walk","parameters":{"a":1e999}})"),
          std::string(R"({"type":"command","id":1,"vehicle":"z","command":"walk","parameters":
               {"a":1,"b":1,"c":1,"d":1,"e":1,"f":1,"g":1,"h":1,"i":1}})"),
          std::string(R"({"type":"command","id":1,"vehicle":"z","command":"walk","dry_run":1})"),
          R"({"type":"command","id":1,"vehicle":")" + long_name + R"(","command":"walk"})",
          R"({"type":"command","id":1,"vehicle":"z","command":"c","name":")" +
              std::string(kNameSize, 'x') + "\"}",
          std::string("{\"type\":\"beat\",\"n\":1,\"\xff\":2}"),
          std::string(4000, '['),
      }) {
    const auto message = parse_message(text);
    ASSERT_FALSE(message) << text;
    EXPECT_FALSE(message.error().empty()) << text;
  }
}

}  // namespace
}  // namespace lss::ground
