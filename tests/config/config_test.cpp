#include "daemon/config/config.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

namespace lss::config {
namespace {

using Lines = std::vector<std::string>;

const std::filesystem::path kExample = LSS_SOURCE_DIR "/config/zebro.toml";
const Lines kVehicles = {"zebro"};

// A vehicle that wants nothing of its own.
void read_nothing(const std::string&, Section&) {}

// A vehicle that knows exactly the keys of `table`, with the types that they have there.
void read_like(const toml::table& table, Section& section) {
  for (const auto& [key, node] : table) {
    if (const toml::table* inner = node.as_table()) {
      Section child = section.section(key.str());
      read_like(*inner, child);
    } else {
      section.skip(key.str());
    }
  }
}

// A file of its own, gone at the end.
class Scratch {
 public:
  explicit Scratch(const std::string& text) {
    std::string name = std::filesystem::temp_directory_path() / "lss-config-XXXXXX";
    close(mkstemp(name.data()));
    path_ = name;
    std::ofstream(path_) << text;
  }
  ~Scratch() { std::filesystem::remove(path_); }
  Scratch(const Scratch&) = delete;
  Scratch& operator=(const Scratch&) = delete;
  const std::filesystem::path& path() const { return path_; }

 private:
  std::filesystem::path path_;
};

// The error text with the name of the scratch file taken away: ":LINE:COLUMN: sentence" lines.
std::string errors_of(const std::string& text, const VehicleReader& reader = read_nothing) {
  const Scratch file(text);
  const auto config = load(file.path(), kVehicles, reader);
  if (config) return "";
  std::string errors = config.error();
  for (std::size_t at; (at = errors.find(file.path().string())) != std::string::npos;) {
    errors.erase(at, file.path().string().size());
  }
  return errors;
}

const std::string kPort = "[[port]]\nname = 'legs'\npath = 'sim:legs'\n";
std::string minimal(const std::string& more) { return "vehicle = 'zebro'\n" + kPort + more; }

Lines lines_of_example() {
  std::ifstream in(kExample);
  Lines lines;
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

std::string joined(const Lines& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + '\n';
  return text;
}

TEST(Config, TheExampleSaysWhatTheDefaultsAre) {
  const toml::table example = toml::parse_file(kExample.string());
  const auto full = load(kExample, kVehicles, [&](const std::string& name, Section& section) {
    read_like(*example[name].as_table(), section);
  });
  ASSERT_TRUE(full) << full.error();
  const Scratch file(minimal(""));
  const auto bare = load(file.path(), kVehicles, read_nothing);
  ASSERT_TRUE(bare) << bare.error();

  EXPECT_EQ(full->vehicle, "zebro");
  EXPECT_EQ(full->vehicle_id, bare->vehicle_id);
  EXPECT_EQ(full->period_ns, bare->period_ns);
  EXPECT_EQ(full->offset_ns, bare->offset_ns);
  EXPECT_EQ(full->max_consecutive_overruns, bare->max_consecutive_overruns);
  EXPECT_EQ(full->realtime_enforce, bare->realtime_enforce);
  EXPECT_EQ(full->domain, bare->domain);
  EXPECT_EQ(full->interfaces, bare->interfaces);
  EXPECT_EQ(full->shared_memory, bare->shared_memory);
  EXPECT_EQ(full->restart_for_shared_memory, bare->restart_for_shared_memory);
  EXPECT_EQ(full->telemetry_periodic, bare->telemetry_periodic);
  EXPECT_EQ(full->obc_timeout_ns, bare->obc_timeout_ns);
  EXPECT_EQ(full->lease_min_ms, bare->lease_min_ms);
  EXPECT_EQ(full->lease_max_ms, bare->lease_max_ms);
  EXPECT_EQ(full->log_level, bare->log_level);
  EXPECT_EQ(full->log_files, bare->log_files);
  EXPECT_EQ(full->log_use, bare->log_use);
  ASSERT_EQ(full->log_presets.size(), bare->log_presets.size());
  for (std::size_t i = 0; i < full->log_presets.size(); ++i) {
    const LogPreset& a = full->log_presets[i];
    const LogPreset& b = bare->log_presets[i];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.what, b.what) << a.name;
    EXPECT_EQ(a.every_ns, b.every_ns) << a.name;
    EXPECT_EQ(a.address, b.address) << a.name;
    EXPECT_EQ(a.file_bytes, b.file_bytes) << a.name;
    EXPECT_EQ(a.total_bytes, b.total_bytes) << a.name;
  }
  ASSERT_EQ(full->ports.size(), 1u);
  EXPECT_EQ(full->ports[0].baud, bare->ports[0].baud);
  EXPECT_EQ(full->ports[0].half_duplex, bare->ports[0].half_duplex);
  ASSERT_EQ(full->threads.size(), bare->threads.size());
  for (std::size_t i = 0; i < full->threads.size(); ++i) {
    EXPECT_EQ(full->threads[i].name, bare->threads[i].name);
    EXPECT_EQ(full->threads[i].priority, bare->threads[i].priority);
    EXPECT_EQ(full->threads[i].cpu, bare->threads[i].cpu);
  }
}

TEST(Config, EveryValueOfTheFileArrives) {
  const Scratch file(
      "vehicle = 'zebro'\nvehicle_id = 'z-7'\n"
      "[frame]\nperiod_ms = 40\noffset_ms = 12.5\nmax_consecutive_overruns = 3\n"
      "[realtime]\npolicy = 'enforce'\n"
      "[[realtime.thread]]\nname = 'bus/legs'\npriority = 66\ncpu = 1\n"
      "[[port]]\nname = 'legs'\npath = '/dev/ttyS1'\nbaud = 1000000\nduplex = 'half'\n"
      "[dds]\ndomain = 5\ninterfaces = ['lo', 'eth0']\nshared_memory = false\n"
      "restart_for_shared_memory = true\n"
      "[telemetry]\nmode = 'on_request'\n"
      "[link]\nobc_timeout_s = 2.5\nlease_min_ms = 300\nlease_max_ms = 400\n"
      "[log]\nlevel = 'debug'\n");
  const auto config = load(file.path(), kVehicles, read_nothing);
  ASSERT_TRUE(config) << config.error();
  EXPECT_EQ(config->vehicle_id, "z-7");
  EXPECT_EQ(config->period_ns, 40 * kMillisecond);
  EXPECT_EQ(config->offset_ns, 12'500 * kMicrosecond);
  EXPECT_EQ(config->max_consecutive_overruns, 3);
  EXPECT_TRUE(config->realtime_enforce);
  EXPECT_EQ(config->ports.at(0).path, "/dev/ttyS1");
  EXPECT_EQ(config->ports.at(0).baud, 1'000'000);
  EXPECT_TRUE(config->ports.at(0).half_duplex);
  const auto bus = std::find_if(config->threads.begin(), config->threads.end(),
                                [](const Thread& t) { return t.name == "bus/legs"; });
  ASSERT_NE(bus, config->threads.end());
  EXPECT_EQ(bus->priority, 66);
  EXPECT_EQ(bus->cpu, 1);
  EXPECT_EQ(config->domain, 5);
  EXPECT_EQ(config->interfaces, (Lines{"lo", "eth0"}));
  EXPECT_FALSE(config->shared_memory);
  EXPECT_TRUE(config->restart_for_shared_memory);
  EXPECT_FALSE(config->telemetry_periodic);
  EXPECT_EQ(config->obc_timeout_ns, 2'500 * kMillisecond);
  EXPECT_EQ(config->lease_min_ms, 300);
  EXPECT_EQ(config->lease_max_ms, 400);
  EXPECT_EQ(config->log_level, 1);
}

TEST(Config, PresetsOfTheLogAreChangedAddedAndChosen) {
  const Scratch file(
      minimal("[log]\nuse = 'mine'\n"
              "[[log.preset]]\nname = 'mine'\nwhat = ['timing', 'events', 'timing']\n"
              "every_ms = 250\nfile_mb = 3\ntotal_mb = 6\n"
              "[[log.preset]]\nname = 'stream'\nto = 'file'\n"
              "[[log.preset]]\nname = 'standard'\nwhat = ['all']\nto = 'socket'\n"
              "address = 'udp://127.0.0.1:9000'\n"));
  const auto config = load(file.path(), kVehicles, read_nothing);
  ASSERT_TRUE(config) << config.error();
  ASSERT_EQ(config->running_log_presets().size(), 1u);
  const LogPreset running = config->running_log_presets().front();
  const LogPreset* const mine = &running;
  EXPECT_EQ(mine->name, "mine");
  EXPECT_EQ(mine->what, bit(LogPart::events) | bit(LogPart::timing));
  EXPECT_EQ(mine->every_ns, 250 * kMillisecond);
  EXPECT_EQ(mine->address, "");
  EXPECT_EQ(mine->file_bytes, 3'000'000u);
  EXPECT_EQ(mine->total_bytes, 6'000'000u);
  const auto preset = [&](const char* name) {
    return *std::find_if(config->log_presets.begin(), config->log_presets.end(),
                         [&](const LogPreset& p) { return p.name == name; });
  };
  EXPECT_EQ(preset("stream").address, "");
  EXPECT_EQ(preset("stream").every_ns, 100 * kMillisecond);  // all else stays
  EXPECT_EQ(preset("standard").what, kAllLogParts);
  EXPECT_EQ(preset("standard").address, "udp://127.0.0.1:9000");
}

TEST(Config, NoPresetLogsNothing) {
  const Scratch file(minimal("[log]\nuse = ''\n"));
  const auto config = load(file.path(), kVehicles, read_nothing);
  ASSERT_TRUE(config) << config.error();
  EXPECT_TRUE(config->running_log_presets().empty());
}

TEST(Config, OnePresetLogsToFilesAndOthersBesideItToSockets) {
  const auto both =
      parse(minimal("[log]\nuse = 'quiet'\nalso = ['stream']\n"), "text", kVehicles, read_nothing);
  ASSERT_TRUE(both) << both.error();
  ASSERT_EQ(both->running_log_presets().size(), 2u);
  EXPECT_EQ(both->running_log_presets()[0].name, "quiet");
  EXPECT_EQ(both->running_log_presets()[1].name, "stream");

  for (const char* wrong : {"also = ['nothing']", "also = ['timing']"}) {
    const auto refused =
        parse(minimal(std::string("[log]\n") + wrong + "\n"), "text", kVehicles, read_nothing);
    ASSERT_FALSE(refused) << wrong;
    EXPECT_NE(refused.error().find("also"), std::string::npos) << refused.error();
  }
}

TEST(Config, TheFlightRecorderRecordsUnlessItIsSwitchedOff) {
  const auto plain = parse(minimal(""), "text", kVehicles, read_nothing);
  ASSERT_TRUE(plain) << plain.error();
  EXPECT_TRUE(plain->recorder.record);
  EXPECT_TRUE(plain->recorder.sync);
  EXPECT_EQ(plain->text, minimal(""));
  const auto other =
      parse(minimal("[recorder]\nrecord = false\nsync = false\nfile_mb = 2\ntotal_mb = 5\n"),
            "text", kVehicles, read_nothing);
  ASSERT_TRUE(other) << other.error();
  EXPECT_FALSE(other->recorder.record);
  EXPECT_FALSE(other->recorder.sync);
  EXPECT_EQ(other->recorder.file_bytes, 2'000'000u);
  EXPECT_EQ(other->recorder.total_bytes, 5'000'000u);
}

TEST(Config, AMissingFileIsAnErrorThatNamesIt) {
  const auto config = load("/nowhere/zebro.toml", kVehicles, read_nothing);
  ASSERT_FALSE(config);
  EXPECT_EQ(config.error(),
            "/nowhere/zebro.toml: no such file; name the configuration with --config FILE\n");
}

TEST(Config, WhatIsNotTomlIsAnErrorWithItsLine) {
  EXPECT_TRUE(errors_of("vehicle = 'zebro'\nthis is no TOML\n").starts_with(":2:"))
      << errors_of("vehicle = 'zebro'\nthis is no TOML\n");
  const std::string twice = errors_of(minimal("[frame]\nperiod_ms = 1\nperiod_ms = 2\n"));
  EXPECT_TRUE(twice.starts_with(":7:")) << twice;
  EXPECT_NE(errors_of(std::string("\0\xff\xfe", 3)), "");
  // What it quotes of the file breaks no line.
  const std::string cut = errors_of("vehicle = t\nrue\n'\x1b[2J\x1b' = 1\n");
  EXPECT_EQ(cut.find_first_of("\n\x1b\t"), cut.size() - 1) << cut;
}

TEST(Config, AnEmptyFileSaysWhatIsMissing) {
  EXPECT_EQ(errors_of(""),
            ":1:1: vehicle: is missing; it has no default\n"
            ":1:1: port: is missing; name at least one [[port]]\n");
}

TEST(Config, AVehicleThatIsNotBuiltInIsTheOnlyError) {
  EXPECT_EQ(errors_of("vehicle = 'zbro'\n" + kPort + "[zebro.bus]\nx = 1\n"),
            ":1:11: vehicle: \"zbro\" is not built into this daemon; it has: zebro\n");
}

struct Wrong {
  std::string name;
  const char* text;      // appended to a good minimal file of four lines
  const char* expected;  // part of the error
};

void PrintTo(const Wrong& wrong, std::ostream* out) { *out << wrong.name; }

class WrongConfig : public ::testing::TestWithParam<Wrong> {};

TEST_P(WrongConfig, IsAnErrorThatSaysWhereAndWhat) {
  const std::string errors = errors_of(minimal(GetParam().text));
  EXPECT_NE(errors.find(GetParam().expected), std::string::npos) << "errors: " << errors;
}

INSTANTIATE_TEST_SUITE_P(
    Each, WrongConfig,
    ::testing::Values(
        Wrong{"WrongUnit", "[frame]\nperiod_s = 0.02\n",
              ":6:1: unknown key period_s in [frame]; unit of period is ms here: period_ms"},
        Wrong{"OffsetNotWithinPeriod", "[frame]\nperiod_ms = 20\noffset_ms = 20\n",
              ":7:13: frame.offset_ms: 20 must be shorter than the period of 20 ms"},
        Wrong{"PeriodOutOfRange", "[frame]\nperiod_ms = 0\n",
              ":6:13: frame.period_ms: 0 is out of range 1 to 1000"},
        Wrong{"PeriodNotANumber", "[frame]\nperiod_ms = nan\n",
              ":6:13: frame.period_ms: is not a finite number"},
        Wrong{"WrongChoice", "[realtime]\npolicy = 'enforced'\n", "did you mean \"enforce\"?"},
        Wrong{"ThreadOfUnknownPort", "[[realtime.thread]]\nname = 'bus/lgs'\n",
              ":6:8: realtime.thread.name: \"bus/lgs\" is no thread; there are: frame, actuate, "
              "bus/legs"},
        Wrong{"ThreadTwice",
              "[[realtime.thread]]\nname = 'frame'\n[[realtime.thread]]\nname = 'frame'\n",
              ":8:8: realtime.thread.name: \"frame\" stands in the table twice"},
        Wrong{"PriorityOutOfRange", "[[realtime.thread]]\nname = 'frame'\npriority = 100\n",
              ":7:12: realtime.thread.priority: 100 is out of range 0 to 99"},
        Wrong{"ThreadWithoutName", "[[realtime.thread]]\npriority = 7\n",
              ":5:1: realtime.thread.name: is missing"},
        Wrong{"PortNameTwice", "[[port]]\nname = 'legs'\npath = 'sim:b'\n",
              ":6:8: port.name: \"legs\" names a port already"},
        Wrong{"PortPathTwice", "[[port]]\nname = 'b'\npath = 'sim:legs'\n",
              ":7:8: port.path: \"sim:legs\" is the path of port \"legs\" already"},
        Wrong{"PortNameTooLong", "[[port]]\nname = 'longer-than-a-thread'\npath = 'sim:b'\n",
              "must be 1 to 11 letters"},
        Wrong{"PathWithoutSchemeOrSlash", "[[port]]\nname = 'b'\npath = 'ttyS1'\n",
              ":7:8: port.path: \"ttyS1\" is no port"},
        Wrong{"SimulatedPathOutOfItsFolder", "[[port]]\nname = 'b'\npath = 'sim:../x'\n",
              "is no port"},
        Wrong{"DevicePathIsAFolder", "[[port]]\nname = 'b'\npath = '/dev/'\n", "is no port"},
        Wrong{"UdpWithoutPort", "[[port]]\nname = 'b'\npath = 'udp://127.0.0.1'\n", "is no port"},
        Wrong{"UdpPortOutOfRange", "[[port]]\nname = 'b'\npath = 'udp://127.0.0.1:70000'\n",
              "UDP port out of range"},
        Wrong{"UdpAddressOutOfRange", "[[port]]\nname = 'b'\npath = 'udp://127.0.0.256:7000'\n",
              "no valid IPv4 address"},
        Wrong{"UdpLocalPortOutOfRange",
              "[[port]]\nname = 'b'\npath = 'udp://127.0.0.1:7000?local=0'\n",
              "UDP port out of range"},
        Wrong{"WrongDuplex", "[[port]]\nname = 'b'\npath = 'sim:b'\nduplex = 'both'\n",
              "choose one of: full, half"},
        Wrong{"DomainOutOfRange", "[dds]\ndomain = 231\n",
              ":6:10: dds.domain: 231 is out of range 0 to 230"},
        Wrong{"NoInterfaces", "[dds]\ninterfaces = []\n", "dds.interfaces: is empty"},
        Wrong{"InterfaceIsNoName", "[dds]\ninterfaces = ['\"/>']\n",
              "is no name of a network interface"},
        Wrong{"TextForAFlag", "[dds]\nshared_memory = 'yes'\n",
              "is a text; true or false is expected"},
        Wrong{"WrongTelemetryMode", "[telemetry]\nmode = 'never'\n",
              "choose one of: periodic, on_request"},
        Wrong{"LeaseBoundsCrossed", "[link]\nlease_min_ms = 500\nlease_max_ms = 400\n",
              ":6:16: link.lease_min_ms: 500 is longer than lease_max_ms, 400"},
        Wrong{"ShortenedLevel", "[log]\nlevel = 'warn'\n", "did you mean \"warning\"?"},
        Wrong{
            "UnknownPreset", "[log]\nuse = 'all'\n",
            ":6:7: log.use: \"all\" is no preset; there are: quiet, standard, timing, everything, "
            "stream; \"\" logs nothing"},
        Wrong{"PresetWithoutName", "[[log.preset]]\nevery_ms = 5\n",
              ":5:1: log.preset.name: is missing"},
        Wrong{"PresetNameOutOfItsFolder", "[[log.preset]]\nname = '../a'\n",
              ":6:8: log.preset.name: \"../a\" must be 1 to 24 letters"},
        Wrong{"PresetTwice", "[[log.preset]]\nname = 'quiet'\n[[log.preset]]\nname = 'quiet'\n",
              ":8:8: log.preset.name: \"quiet\" stands in the list twice"},
        Wrong{"PresetOfNothing", "[[log.preset]]\nname = 'a'\nwhat = []\n",
              ":7:8: log.preset.what: is empty; choose of: inputs, command, events"},
        Wrong{"PresetOfAnUnknownPart", "[[log.preset]]\nname = 'a'\nwhat = ['event']\n",
              ":7:8: log.preset.what: \"event\" is no part of a frame; did you mean \"events\"?"},
        Wrong{"PresetOfWrongType", "[[log.preset]]\nname = 'a'\nwhat = 'events'\n",
              ":7:8: log.preset.what: must be a list of texts in quotes"},
        Wrong{"PresetPeriodOutOfRange", "[[log.preset]]\nname = 'a'\nevery_ms = -1\n",
              ":7:12: log.preset.every_ms: -1 is out of range 0 to 3600000"},
        Wrong{"PresetPeriodInSeconds", "[[log.preset]]\nname = 'a'\nevery_s = 1\n",
              ":7:1: unknown key every_s in [log.preset]; unit of every is ms here: every_ms"},
        Wrong{"PresetToDds", "[[log.preset]]\nname = 'a'\nto = 'dds'\n",
              ":7:6: log.preset.to: \"dds\" is no choice; choose one of: file, socket"},
        Wrong{"SocketWithoutAddress", "[[log.preset]]\nname = 'a'\nto = 'socket'\n",
              ":5:1: log.preset.address: \"\" is no socket; write /run/lss/NAME"},
        Wrong{"SocketOnAnotherMachine",
              "[[log.preset]]\nname = 'a'\nto = 'socket'\naddress = 'udp://192.168.7.1:9000'\n",
              ":8:11: log.preset.address: \"udp://192.168.7.1:9000\" is no socket"},
        Wrong{"SocketPortOutOfRange",
              "[[log.preset]]\nname = 'a'\nto = 'socket'\naddress = 'udp://127.0.0.1:70000'\n",
              "UDP port out of range"},
        Wrong{"AddressOfAFile", "[[log.preset]]\nname = 'a'\naddress = '/run/lss/log'\n",
              ":7:11: log.preset.address: is for to = \"socket\""},
        Wrong{"FilesOutOfRange", "[[log.preset]]\nname = 'a'\nfile_mb = 0\n",
              ":7:11: log.preset.file_mb: 0 is out of range 1 to 1000"},
        Wrong{"TotalOfLessThanTwoFiles",
              "[[log.preset]]\nname = 'a'\nfile_mb = 20\ntotal_mb = 39\n",
              ":8:12: log.preset.total_mb: 39 must be at least twice file_mb, 20"},
        Wrong{"RecordingsOfLessThanTwoFiles", "[recorder]\nfile_mb = 20\ntotal_mb = 39\n",
              ":7:12: recorder.total_mb: 39 must be at least twice file_mb, 20"},
        Wrong{"UnknownKeyOfTheVehicle", "[zebro]\nsomething = 1\n",
              ":6:1: unknown key something in [zebro]; nothing is known here"}),
    [](const auto& tested) { return tested.param.name; });

TEST(Config, GoodPortPathsAreTaken) {
  for (const char* path : {"sim:b", "/dev/ttyUSB0", "/dev/serial/by-id/usb-FTDI_1-if00", "can0",
                           "vcan12", "udp://127.0.0.1:7000", "udp://127.0.0.1:7000?local=7001"}) {
    EXPECT_EQ(errors_of(minimal("[[port]]\nname = 'b'\npath = '" + std::string(path) + "'\n")), "")
        << path;
  }
}

TEST(Config, AllErrorsComeTogetherInTheOrderOfTheFile) {
  const std::string errors =
      errors_of("vehicle_id = 'a b'\nvehicle = 'zebro'\n[log]\nlevl = 'info'\n" + kPort +
                "baud = 1\n[zebro]\nx = 1\n");
  Lines starts;
  std::istringstream in(errors);
  for (std::string line; std::getline(in, line);) starts.push_back(line.substr(0, 3));
  EXPECT_EQ(starts, (Lines{":1:", ":4:", ":8:", ":10"})) << errors;
}

// A key of the example as it stands in the text, by line.
struct Key {
  std::size_t line;  // from 0
  std::size_t begin, length;
};

std::vector<Key> keys_of(const Lines& lines) {
  std::vector<Key> keys;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string& line = lines[i];
    const std::size_t begin = line.find_first_not_of("[ ");
    if (begin == std::string::npos || line[begin] == '#') continue;
    for (std::size_t at = begin; at < line.size();) {  // the parts of a dotted header one by one
      const std::size_t end = line.find_first_of(" .]=", at);
      keys.push_back({i, at, end - at});
      if (line[end] != '.') break;
      at = end + 1;
    }
  }
  return keys;
}

TEST(Config, TheExampleHasKeysToMutate) { EXPECT_GT(keys_of(lines_of_example()).size(), 50u); }

// [Env-2]
RC_GTEST_PROP(Config, AnyMutatedKeyOfTheExampleIsAnErrorThatNamesItsLine, ()) {
  const Lines lines = lines_of_example();
  const toml::table example = toml::parse(joined(lines));
  const std::vector<Key> keys = keys_of(lines);
  const Key key = *rc::gen::elementOf(keys);
  const std::string old = lines[key.line].substr(key.begin, key.length);

  const auto letter = rc::gen::elementOf(std::string("abcdefghijklmnopqrstuvwxyzAZ_019-"));
  const auto at = *rc::gen::inRange<std::size_t>(0, old.size());
  std::string mutated = old;
  switch (*rc::gen::inRange(0, 4)) {
    case 0: mutated.insert(at, 1, *letter); break;
    case 1: mutated.erase(at, 1); break;
    case 2: mutated[at] = *letter; break;
    default: std::swap(mutated[at], mutated[(at + 1) % old.size()]);
  }
  RC_PRE(!mutated.empty() && mutated != old);
  Lines changed = lines;
  changed[key.line].replace(key.begin, key.length, mutated);

  const std::string errors =
      errors_of(joined(changed), [&](const std::string& name, Section& section) {
        read_like(*example[name].as_table(), section);
      });
  const std::string place = ":" + std::to_string(key.line + 1) + ":";
  RC_ASSERT(("\n" + errors).find("\n" + place) != std::string::npos);
}

}  // namespace
}  // namespace lss::config
