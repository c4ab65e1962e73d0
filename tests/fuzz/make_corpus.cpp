// fuzz-corpus FOLDER: the corpora of the fuzzers of this folder, out of what the product itself
// writes: FOLDER/NAME/*, some kB each. tools/lib/fuzz.sh adds configurations, devices and IDL.

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "daemon/parameters/store.h"
#include "daemon/record/recording.h"
#include "drivers/can/cannelloni.h"
#include "drivers/zebro/leg_bus.h"
#include "tests/cli/zebro_dictionary.h"
#include "tests/fuzz/fuzz.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/obc/frame.h"
#include "tools/lss-cli/recording/mcap_writer.h"

namespace {

namespace fs = std::filesystem;
using namespace lss;
using testing_support::content;

fs::path folder;

// A growing input, in the order in which the fuzzers take it.
class Out {
 public:
  Out() = default;
  explicit Out(std::string_view begin) : bytes_(begin) {}
  template <class T>
  Out& number(T value) {
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Out& byte(unsigned value) { return number(static_cast<std::uint8_t>(value)); }
  Out& bytes(fuzz::Bytes bytes) { return text(fuzz::text_of(bytes)); }
  Out& text(std::string_view text) {
    bytes_ += text;
    return *this;
  }
  void save(const std::string& fuzzer, const std::string& name) const {
    fs::create_directories(folder / fuzzer);
    std::ofstream(folder / fuzzer / name, std::ios::binary) << bytes_;
  }

 private:
  std::string bytes_;
};

void zebro_bus() {
  using namespace lss::zebro;
  for (const Check check : {Check::lrc, Check::crc8}) {
    Out out;
    out.byte(0).byte(check == Check::lrc ? 0 : 1).byte(1);
    std::array<std::uint8_t, kMaxFrameCharacters> characters{};
    for (const Frame& frame :
         {command(kBroadcast, Code::emergency_stop), rotate(3, Code::rotate_forward, 18'000, 500),
          request(3, Page::status), Frame{3, 0x40, {5, 0, 0x50, 0x46, 1, 2, 3, 4}},
          Frame{3, 0x42, {1, 2, 0, 0, 9}}})
      out.bytes(encode(frame, check, Stop::crlf, characters));
    out.save("zebro_bus", check == Check::lrc ? "frames-lrc" : "frames-crc8");
  }
  constexpr std::array<std::uint8_t, 8> kReply = {0x07, 0, 0x10, 0x20, 1, 0, 2, 0};
  Out walk;
  walk.byte(1);
  for (int cycle = 0; cycle < 3; ++cycle) {
    walk.byte(0).byte(0).byte(1);  // released at once, no emergency
    for (int module = 0; module < kBusModules; ++module)
      walk.byte(1)
          .byte(2u + static_cast<unsigned>(module) % 2)
          .number(std::uint16_t(9'000 * cycle))
          .number(400'000'000);
    for (int module = 0; module < kBusModules; ++module)
      walk.byte(5).byte(2).byte(1).byte(0).bytes(kReply);
  }
  walk.byte(3).save("zebro_bus", "walk-and-stop");
}

void can() {
  CannelloniWriter writer;
  (void)writer.add({.id = 0x181, .size = 8, .data = {0x37, 0x06, 1, 2, 3, 4, 5, 6}});
  (void)writer.add({.id = 0x1234'5678, .extended = true, .size = 2, .data = {1, 2}});
  (void)writer.add({.id = 0x701, .size = 1, .data = {5}});
  (void)writer.add({.id = 0x80, .size = 0});
  (void)writer.add({.id = 0x182, .remote = true, .size = 8});
  Out().bytes(writer.take()).save("cannelloni", "frames");
  Out().bytes(writer.take()).save("cannelloni", "nothing");

  // Nodes boot, then orders and measurements come; of each bus.
  constexpr std::array<std::array<std::uint8_t, 4>, 3> kNodes = {
      {{0x01, 0x11, 0x20, 0x21}, {0x20, 0x21, 0x22, 0x20}, {1, 2, 3, 4}}};
  for (unsigned bus = 0; bus < kNodes.size(); ++bus) {
    Out out;
    out.byte(bus).byte(6).byte(60);
    for (const std::uint8_t node : kNodes[bus]) out.byte(1).byte(node).byte(0);  // boot-up
    for (int i = 0; i < 40; ++i) out.byte(5).number(std::uint16_t{2000}).byte(1).byte(0).byte(1);
    for (const std::uint8_t node : kNodes[bus]) out.byte(1).byte(node).byte(1);  // operational
    out.byte(0).byte(0);
    for (int i = 0; i < 40; ++i) out.byte(i % 2 == 0 ? 0 : 3);  // of any orders
    for (const std::uint8_t node : kNodes[bus])
      out.byte(2).number(std::uint16_t(0x180 + node)).text("\x37\x06\x10\x20\x30\x40\x50\x60");
    out.byte(2)
        .number(std::uint16_t(0x80 + kNodes[bus][0]))
        .text("\x10\x81\x01\x02\x03\x04\x05\x06");
    out.byte(4).byte(6).byte(255).save("canopen", fmt::format("bus-{}", bus));
  }
}

void sensors() {
  // Of docs/icd-talaris.md.
  constexpr std::array<std::uint8_t, 18> kLandmark = {0x2A, 0x07, 0x64, 0x00, 0x06, 0xFF,
                                                      0x05, 0x00, 0xE8, 0x03, 0xF4, 0xFF,
                                                      0x03, 0x00, 0xD0, 0x09, 0x42, 0x65};
  Out landmark;
  landmark.byte(0)
      .bytes(fuzz::Bytes(kLandmark).subspan(2, 15))
      .bytes(fuzz::Bytes(kLandmark).subspan(2, 15));
  for (int i = 0; i < 4; ++i)
    landmark.byte(0).byte(18).bytes(kLandmark).byte(1).byte(0).byte(1).byte(1).byte(3).byte(2);
  landmark.save("landmark", "packets");
  Out crossbow;
  crossbow.bytes(fuzz::Bytes(kLandmark).first(16));
  crossbow.byte(1).byte(1).byte(3).byte(1).byte(1).byte(2).byte(3).byte(1);
  for (int i = 0; i < 4; ++i) crossbow.byte(3).byte(5).byte(1).byte(0);
  crossbow.save("crossbow", "polls");
  Out ar1000;
  for (const char* line :
       {"12.345\r\n", "E15\r\n", "0.1 \r\n", "-3.0\r\n", "99999999999999999999999\r\n"})
    ar1000.byte(3).byte(60).byte(0).byte(static_cast<unsigned>(std::strlen(line))).text(line);
  ar1000.save("ar1000", "lines");
}

void recordings() {
  const fs::path path = folder / "made.lssrec";
  const nlohmann::ordered_json header = {
      {"lss", "recording"},
      {"utc_ns", 1'900'000'000'000'000'000},
      {"time_ns", 1'000},
      {"vehicle", "zebro"},
      {"vehicle_id", "z-1"},
      {"period_ns", 20'000'000},
      {"schema",
       "in:{frame:u8;time_ns:i8;requests:<{source:[4]c1;kind:u2;}>;};telemetry:{distance_m:f8;"
       "modules:[3]{current_A:f4;online:b1;};reading:({count:i4;}|{range_m:[2]f8;});};"}};
  record::RecordingWriter writer;
  (void)writer.begin(path, header, 0);
  for (std::int64_t frame = 1; frame <= 3; ++frame) {
    Out out;
    out.number(frame).number(frame * 20'000'000).number(std::uint32_t{1}).text("me");
    out.number(std::uint16_t{0}).number(std::uint16_t{5}).number(1.5);
    for (int i = 0; i < 3; ++i) out.number(0.5f).byte(1);
    out.byte(1).number(1.5).number(2.5).save("", "record");
    const std::string bytes = content(folder / "record");
    writer.add_frame({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()}, frame);
    (void)writer.flush();
  }
  writer.add_lost(2);
  (void)writer.end();
  Out().byte(1).text(content(path)).save("lssrec", "three-frames");
  fs::remove(path);
  fs::remove(folder / "record");

  const fs::path mcap = folder / "made.mcap";
  const std::string idl =
      "module lss { enum State { IDLE, BUSY }; struct Part { octet id; double angle_rad; };"
      "struct Heartbeat { @key char vehicle_id[16]; char source[32]; unsigned long long counter;"
      "State state; boolean on; Part parts[2]; char c; float f; }; };";
  {
    using namespace cli::recording;
    McapWriter to = McapWriter::create(mcap, "lss-cli fuzz");
    to.metadata("lss", {{"vehicle", "zebro"}, {"vehicle_id", "z-1"}});
    for (const char* topic : {"lss/heartbeat", "lss/telemetry/z"}) {
      const auto id = to.channel(topic, {"lss::Heartbeat", "omgidl", idl}, "cdr", {});
      const std::string data = std::string("\0\1\0\0", 4) + std::string(112, '\2');
      for (std::uint32_t i = 0; i < 3; ++i) to.write({id, i, 1'000 + i, 1'000, bytes_of(data)});
    }
    to.close();
  }
  Out(content(mcap)).save("mcap", "two-topics");
  fs::remove(mcap);
  Out("lss::Heartbeat\n" + idl).save("idl", "heartbeat");
}

void texts() {
  const auto parameters =
      encode({.number = 7,
              .utc_ns = 1'900'000'000'000'000'000,
              .values = {{.name = "a", .value = 3}, {.name = "gait.stance_share", .value = 0.75}}},
             "zebro", "z-1");
  Out().byte(1).bytes(parameters).save("parameters", "two-values");
  Out("vehicle = \"zebro\"\n[[port]]\nname = \"legs\"\npath = \"sim:legs\"\n"
      "[zebro]\nnumber = 1.5\nwhole = 2\nflag = true\nchoice = \"two\"\nintegers = [1, 2]\n"
      "numbers = [1, 2.5, 3]\ntexts = [\"a\"]\nbelow.name = \"b\"\n[[zebro.list]]\nnumber = 1\n")
      .save("config", "values");
  int number = 0;
  for (
      const char* message :
      {R"({"type":"hello","key":"k","session":"0123456789abcdef"})", R"({"type":"beat","n":3})",
       R"({"type":"stop","id":1,"vehicle":"z-1","land":true})",
       R"({"type":"command","id":2,"vehicle":"z-1","command":"walk","parameters":{"heading":0.5,"speed":3},"dry_run":false,"whole":true})",
       R"({"type":"command","id":3,"vehicle":"z-1","command":"set-parameter","name":"gait.speed","parameters":{"value":1e3}})",
       R"({"type":"script","id":4,"vehicle":"t-1","text":"# two\n0s valves 1,3 for 100ms\n2s fans all throttle 0.3\n6s fans 1,2 rpm 12000\n"})"})
    Out(message).save("message", fmt::format("{}", ++number));
  Out requests;
  for (const std::string& line :
       {cli::obc::frame(1, "status"), cli::obc::frame(2, "walk forward --speed high"),
        std::string("3 result 2\n"), std::string("4 estop\n")})
    requests.byte(static_cast<unsigned>(line.size() - 1)).text(line);
  requests.save("obc", "requests");

  nlohmann::json dictionary = nlohmann::json::parse(cli::test::zebro_dictionary());
  dictionary["vehicle"] = "strider";
  for (const char* name : {"events", "faults", "reasons", "parameters"}) {
    nlohmann::json& list = dictionary[name];
    while (list.size() > 3) list.erase(list.size() - 1);
  }
  Out(dictionary.dump()).save("dictionary", "zebro");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "Usage: fuzz-corpus FOLDER\n");
    return 2;
  }
  folder = argv[1];
  zebro_bus();
  can();
  sensors();
  recordings();
  texts();
}
