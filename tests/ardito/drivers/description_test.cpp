// Device descriptions: what is taken from EDS and DCF files, and what hostile ones are answered.

#include "drivers/canopen/description.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "drivers/ardito/profile.h"
#include "rover_world.h"

namespace lss::ardito {
namespace {

using canopen::read_description;

std::string shipped(Kind kind) {
  std::ifstream file(std::string(LSS_DEVICES) + "/ardito-" +
                     kKindNames[static_cast<std::size_t>(kind)] + ".dcf");
  return {std::istreambuf_iterator<char>(file), {}};
}
std::string altered(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : text.replace(at, from.size(), to);
}
std::string errors_of(const std::string& text, Kind kind = Kind::wheel) {
  std::vector<std::string> errors;
  make_profile(kind, text, errors);
  std::string all;
  for (const std::string& error : errors) all += error + "\n";
  return all;
}
std::string object(const std::string& section, const std::string& rest) {
  return "[" + section + "]\nDataType=0x0006\nAccessType=rw\n" + rest + "\n";
}

TEST(Description, TheShippedOnesAreThoseOfTheProgramWithoutErrors) {
  for (std::size_t i = 0; i < kKinds; ++i) {
    const auto kind = static_cast<Kind>(i);
    std::vector<std::string> errors;
    const Profile profile = make_profile(kind, shipped(kind), errors);
    EXPECT_TRUE(errors.empty()) << errors.front();
    EXPECT_EQ(profile.device_type, default_profiles()[i].device_type);
    EXPECT_EQ(profile.entries, default_profiles()[i].entries);
  }
}

TEST(Description, NumbersTypesAndComments) {
  const auto read = read_description(
      "; comment\r\n[DeviceInfo]\r\nProductName = A drive \r\n\r\n" +
      object("2000", "DefaultValue=010\nParameterValue=0x1F") +
      object("2001sub2", "DefaultValue=$NODEID+0x180\nPDOMapping=1") +
      "[2002]\nDataType=3\nAccessType=ro\nDefaultValue=-2\n[2003]\nObjectType=9\nSubNumber=2\n"
      "[2004]\nDataType=0x5\nAccessType=rw\nCompactSubObj=3\nDefaultValue=7\n");
  ASSERT_TRUE(read.errors.empty()) << read.errors.front();
  const canopen::Description& d = read.description;
  EXPECT_EQ(d.product, "A drive");
  EXPECT_EQ(d.find(0x2000, 0)->by_itself, 8u) << "octal";
  EXPECT_EQ(d.find(0x2000, 0)->value, 0x1Fu);
  EXPECT_EQ(d.find(0x2000, 0)->bytes, 2);
  EXPECT_FALSE(d.find(0x2001, 2)->by_itself.has_value()) << "depends on the node";
  EXPECT_TRUE(d.find(0x2001, 2)->mappable);
  EXPECT_EQ(d.find(0x2002, 0)->by_itself, 0xFFFEu);
  EXPECT_TRUE(d.find(0x2002, 0)->is_signed);
  EXPECT_FALSE(d.find(0x2002, 0)->writable);
  EXPECT_EQ(d.find(0x2003, 0), nullptr) << "an array";
  EXPECT_EQ(d.find(0x2004, 3)->by_itself, 7u);
}

TEST(Description, WhatIsWrongIsSaidWithItsLine) {
  const auto said = [](const std::string& text) {
    std::string all;
    for (const std::string& error : read_description(text).errors) all += error + "\n";
    return all;
  };
  EXPECT_NE(said("").find("no section"), std::string::npos);
  EXPECT_NE(said("[A\n").find("line 1: \"[A\" is no section"), std::string::npos);
  EXPECT_NE(said("[A]\nb\n").find("line 2: \"b\" is neither"), std::string::npos);
  EXPECT_NE(said("a=1\n").find("no section before"), std::string::npos);
  EXPECT_NE(said("[A]\n[a]\n").find("there twice"), std::string::npos);
  EXPECT_NE(said("[A]\nb=1\nB=2\n").find("line 3"), std::string::npos);
  EXPECT_NE(said(object("2000", "DefaultValue=x")).find("\"x\" is no number"), std::string::npos);
  EXPECT_NE(said(object("2000", "DefaultValue=65536")).find("does not fit"), std::string::npos);
  EXPECT_NE(said("[2000]\nDataType=6\nAccessType=maybe\n").find("AccessType"), std::string::npos);
  EXPECT_NE(said(std::string("[A]\nb=\0c\n", 9)).find("NUL"), std::string::npos);
  EXPECT_NE(said("[A]\nb=" + std::string(2000, 'x')).find("longer"), std::string::npos);
  EXPECT_NE(said(std::string(300 * 1024, '\n')).find("256 KiB"), std::string::npos);
  EXPECT_NE(said("[LssSignals]\nA=0x2000:0\n").find("no such object"), std::string::npos);
  EXPECT_NE(said("[LssSignals]\nA=hello\n").find("is no object"), std::string::npos);
  EXPECT_NE(said(object("2000", "") + "[LssSignals]\nA=0x2000:0, 0\n").find("is no unit"),
            std::string::npos);
  EXPECT_NE(said("[2000]\nDataType=6\nAccessType=rw\nCompactSubObj=4000000000\n").find("1 to 254"),
            std::string::npos);
}

TEST(Description, AProfileSaysWhatADriveLacks) {
  const std::string wheel = shipped(Kind::wheel);
  EXPECT_EQ(errors_of(wheel), "");
  EXPECT_NE(errors_of(altered(wheel, "HallVelocity=", "Other=")).find("signal HallVelocity"),
            std::string::npos);
  EXPECT_EQ(errors_of(altered(wheel, "LinkVoltage=", "Other=")), "") << "it may be missing";
  EXPECT_NE(errors_of(altered(wheel, "DefaultValue=1\nParameterValue=3", "DefaultValue=1"))
                .find("0x6007 needs"),
            std::string::npos);
  EXPECT_NE(errors_of(wheel, Kind::steering).find("signal TargetPosition"), std::string::npos);
  EXPECT_NE(errors_of(altered(wheel, "Current=0x6078", "Current=0x606C")).find("more than 8 bytes"),
            std::string::npos);
  EXPECT_NE(errors_of(altered(wheel, "Temperature=0x2101:1", "Temperature=0x6083:0"))
                .find("cannot be mapped"),
            std::string::npos);
}

// A wheel drive of another make: other objects, sizes and units, no error behaviour.
TEST(Description, ADriveWithOtherObjectsAndUnitsDrives) {
  std::string text = shipped(Kind::wheel);
  text = altered(text, "DefaultValue=0x00020192", "DefaultValue=0x00420192");
  const std::size_t from = text.find("[1029]"), to = text.find("[6007]");
  text.erase(from, to - from);
  text = altered(text, "Velocity=0x606C:0, 1", "Velocity=0x606C:0, 0.5");
  text = altered(text, "TargetVelocity=0x60FF:0, 1", "TargetVelocity=0x60FF:0, 0.25");
  text = altered(text, "[6083]", "[2183]");
  text = altered(text, "Acceleration=0x6083:0, 1", "Acceleration=0x2183:0, 10");
  std::vector<std::string> errors;
  const Profile profile = make_profile(Kind::wheel, text, errors);
  ASSERT_TRUE(errors.empty()) << errors.front();
  RoverBusParameters parameters;
  parameters.profile[static_cast<std::size_t>(Kind::wheel)] = profile;
  const canopen::MasterParameters master = master_parameters(parameters);
  const canopen::NodeParameters& node = master.nodes[0];
  EXPECT_EQ(node.device_type, 0x00420192u);
  const auto writes = [&](std::uint16_t index) {
    return std::ranges::find(node.entries, index, &canopen::Entry::index);
  };
  EXPECT_EQ(writes(0x1029), node.entries.end()) << "it has none";
  EXPECT_EQ(writes(0x6083), node.entries.end());
  ASSERT_NE(writes(0x2183), node.entries.end());
  EXPECT_EQ(writes(0x2183)->value, 800u);
  Profiles profiles = default_profiles();
  profiles[0] = profile;
  const std::vector<std::uint8_t> data = {0x37, 0x02, 0x64, 0, 0, 0, 0x78, 0};
  EXPECT_EQ(std::get<WheelMotion>(*decode(profiles, 0, 1, data)).motor_rpm, 50);
  EXPECT_EQ(counts(profile.of(WheelSignal::target_velocity), 100), 400);
}

// Any bytes: an answer, no crash, a bounded number of sentences.
RC_GTEST_PROP(Description, AnyBytesAreAnswered, (const std::string& text)) {
  RC_ASSERT(read_description(text).errors.size() <= canopen::kMostSentences);
}
RC_GTEST_PROP(Description, AnyDamageIsAnswered, ()) {
  const auto kind = *rc::gen::element(Kind::wheel, Kind::steering, Kind::io, Kind::imu);
  std::string text = shipped(kind);
  const int hits = *rc::gen::inRange(1, 30);
  for (int n = 0; n < hits; ++n) {
    const auto at = *rc::gen::inRange<std::size_t>(0, text.size());
    switch (*rc::gen::inRange(0, 4)) {
      case 0:
        text[at] = static_cast<char>(*rc::gen::inRange(0, 256));
        break;
      case 1:
        text.erase(at, *rc::gen::inRange<std::size_t>(1, 60));
        break;
      case 2:
        text.insert(at, *rc::gen::element<std::string>(
                            "\n[", "=", "0x", "-", "99999999999999999999", "$NODEID", "\n",
                            "CompactSubObj=254\n", "ParameterValue=1\n", ":", ","));
        break;
      default:
        text.insert(at, text.substr(at, *rc::gen::inRange<std::size_t>(1, 400)));
        break;
    }
  }
  std::vector<std::string> errors;
  const Profile profile = make_profile(kind, text, errors);
  RC_ASSERT(errors.size() <= 100);
  if (!errors.empty()) return;
  // usable: what the master makes of it fits
  RoverBusParameters parameters;
  parameters.profile[static_cast<std::size_t>(kind)] = profile;
  RC_ASSERT(RoverBus(parameters).parameters_fit());
}

}  // namespace
}  // namespace lss::ardito
