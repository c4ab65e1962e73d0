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
  EXPECT_NE(said("[2000Value]\nNrOfEntries=1\n1=5\n").find("line 1: [2000value] is not read"),
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

// CiA 402: 0x6007 0 nothing, 1 fault, 2 off, 3 quick stop; 0x605A 0 off at once, 1 to 4 off when it
// stands, 5 to 8 holds.
TEST(Description, ADriveThatWouldGoOnOrRollAtAStopIsRefused) {
  for (const Kind kind : {Kind::wheel, Kind::steering}) {
    const auto with = [&](const std::string& as_shipped, int value) {
      return errors_of(altered(shipped(kind), as_shipped + "\nParameterValue=",
                               as_shipped + "\nParameterValue=" + std::to_string(value) + "\n;"),
                       kind);
    };
    const std::string abort_connection = "DefaultValue=1", quick_stop = "DefaultValue=2";
    for (const int value : {-1, 0, 1, 2, 4})
      EXPECT_NE(with(abort_connection, value).find("0x6007 needs the ParameterValue 3"),
                std::string::npos)
          << value;
    for (const int value : {-1, 0, 1, 2, 3, 4, 9})
      EXPECT_NE(with(quick_stop, value).find("0x605A needs a ParameterValue of 5 to 8"),
                std::string::npos)
          << value;
    EXPECT_EQ(with(abort_connection, 3), "");
    for (const int value : {5, 6, 7, 8}) EXPECT_EQ(with(quick_stop, value), "") << value;
  }
}

// As manufacturers publish them: with every section of CiA 306, ends of lines of DOS.
std::string published() {
  std::ifstream file(LSS_PUBLISHED_EDS, std::ios::binary);
  std::string text = "\xEF\xBB\xBF";
  for (std::string line; std::getline(file, line);) text += line + "\r\n";
  return text;
}

TEST(Description, APublishedFileIsReadAsItIs) {
  const auto read = read_description(published());
  ASSERT_TRUE(read.errors.empty()) << read.errors.front();
  const canopen::Description& d = read.description;
  EXPECT_EQ(d.product, "Servo drive 48/10");
  EXPECT_EQ(d.find(0x1000, 0)->by_itself, 0x0042'0192u);
  EXPECT_EQ(d.find(0x1003, 8)->bytes, 4) << "CompactSubObj";
  EXPECT_EQ(d.find(0x1003, 9), nullptr);
  EXPECT_EQ(d.find(0x1008, 0)->bytes, 0) << "text";
  ASSERT_NE(d.find(0x1010, 0), nullptr);
  EXPECT_EQ(d.find(0x1010, 0)->bytes, 1) << "of its sub-index, not of the array";
  EXPECT_FALSE(d.find(0x1014, 0)->by_itself.has_value()) << "depends on the node";
  EXPECT_EQ(d.find(0x1A00, 2)->by_itself, 0x606C'0020u);
  EXPECT_TRUE(d.find(0x1F50, 1)->writable) << "a domain";
  EXPECT_EQ(d.find(0x2000, 2)->bytes, 0) << "REAL32";
  EXPECT_EQ(d.find(0x2000, 0x0A)->bytes, 2) << "sub-indices are hexadecimal";
  EXPECT_TRUE(d.find(0x2000, 0x10)->is_signed && d.find(0x2000, 0x10)->mappable);
  EXPECT_FALSE(d.find(0x2000, 0x10)->writable) << "RO in capitals";
  EXPECT_EQ(d.find(0x2010, 2)->bytes, 0) << "64 bits";
  EXPECT_EQ(d.find(0x2020, 0)->by_itself, 8u) << "octal";
  EXPECT_EQ(d.find(0x2030, 0x10)->by_itself, 0xFFu) << "-1 of 8 bits";
  EXPECT_TRUE(d.find(0x6060, 0)->mappable && d.find(0x6060, 0)->writable);
  EXPECT_EQ(d.find(0x67FF, 0)->by_itself, 0x0042'0192u);
  for (const canopen::DescribedObject& o : d.objects)
    EXPECT_FALSE(o.value.has_value()) << "an EDS configures nothing";
}

// What docs/icd-ardito.md, 14, asks for: values of three objects, and the signals. Then its drives
// boot and are driven in their own objects and units.
TEST(Description, ARoverWithDrivesOfAPublishedFileBootsAndDrives) {
  std::string text = published();
  EXPECT_NE(errors_of(text).find("signal Controlword is missing"), std::string::npos);
  const auto set = [&](const std::string& section, const std::string& value) {
    text = altered(text, "[" + section + "]\r\n",
                   "[" + section + "]\r\nParameterValue=" + value + "\r\n");
  };
  set("6007", "3");
  set("605A", "6");
  set("6060", "3");
  set("607E", "0x40");
  text +=
      "\r\n[LssSignals]\r\nControlword=0x6040\r\nTargetVelocity=0x60FF:0, 1\r\n"
      "Statusword=0x6041\r\nVelocity=0x606C:0, 1\r\nCurrent=0x6078:0, 1\r\n"
      "HallVelocity=0x2000:0x0A, 1\r\nWheelVelocity=0x2010:1, 0.1\r\n"
      "Temperature=0x2000:0x10, 0.1\r\nLinkVoltage=0x6079:0, 0.001\r\n"
      "Acceleration=0x2020:0, 10\r\nDeceleration=0x6084:0, 1\r\n"
      "QuickStopDeceleration=0x6085:0, 1\r\n";
  std::vector<std::string> errors;
  RoverBusParameters parameters;
  parameters.profile[static_cast<std::size_t>(Kind::wheel)] =
      make_profile(Kind::wheel, text, errors);
  ASSERT_TRUE(errors.empty()) << errors.front();
  RoverWorld world(parameters);
  for (std::size_t i = 0; i < kFirstSteering; ++i) {
    CanNode& wheel = world.wheel(i);
    wheel.object(0x1000) = 0x0042'0192;
    wheel.added[0x607E << 8] = {1, 0};
    wheel.added[0x2000 << 8 | 0x0A] = {2, 1'300};
    wheel.added[0x2000 << 8 | 0x10] = {2, 0xFFE7};
    wheel.added[0x2010 << 8 | 1] = {2, 260};
    wheel.added[0x2020 << 8] = {2, 0};
    wheel.added[0x6079 << 8] = {4, 47'900};
  }
  world.boot();
  CanNode& wheel = world.wheel(2);
  EXPECT_EQ(wheel.object(0x2020), 800u) << "8000 rpm/s in units of 10";
  EXPECT_EQ(wheel.object(0x607E), 0x40u);
  EXPECT_EQ(wheel.object(0x1A01, 1), 0x2000'0A10u);
  EXPECT_EQ(wheel.object(0x1A01, 2), 0x2010'0110u);
  EXPECT_EQ(wheel.object(0x1A02, 2), 0x6079'0020u);
  world.drive(1'300);
  world.take_all();
  world.run_frames(12);
  EXPECT_EQ(wheel.target(), 1'300);
  const auto speeds = world.take_of<WheelSpeeds>();
  ASSERT_FALSE(speeds.empty());
  EXPECT_EQ(speeds.back().second.hall_rpm, 1'300);
  EXPECT_DOUBLE_EQ(speeds.back().second.reduction_rpm, 26);
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
      case 0: text[at] = static_cast<char>(*rc::gen::inRange(0, 256)); break;
      case 1: text.erase(at, *rc::gen::inRange<std::size_t>(1, 60)); break;
      case 2:
        text.insert(at, *rc::gen::element<std::string>(
                            "\n[", "=", "0x", "-", "99999999999999999999", "$NODEID", "\n",
                            "CompactSubObj=254\n", "ParameterValue=1\n", ":", ","));
        break;
      default: text.insert(at, text.substr(at, *rc::gen::inRange<std::size_t>(1, 400))); break;
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
