// timing trace: the frames of a flight recording as a trace for Perfetto. Of real recordings:
// tests/e2e/test_record.py.

#include <filesystem>
#include <map>

#include "daemon/record/recording.h"
#include "tests/cli/program_test.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/recording/mcap_writer.h"

namespace lss::cli::test {
namespace {

constexpr const char* kSchema =
    "in:{frame:u8;time_ns:i8;samples:<{time_ns:i8;}>;"
    "requests:<{source:[4]c1;kind:u2;arrival_ns:i8;}>;};"
    "outbox:{events:<{time_ns:i8;id:u2;subject:u2;}>;};"
    "timing:{boundary_ns:i8;woken_ns:i8;read_ns:i8;navigated_ns:i8;ready_ns:i8;released_ns:i8;"
    "margin_ns:i8;offset_ns:i8;overruns:u8;frames_skipped:u8;frames_held:u8;};";
constexpr std::int64_t kBegin_ns = 1'000'000'000'001, kPeriod_ns = 20'000'000;
constexpr std::int64_t kOffset_ns = 5'000'000;

class Trace : public ProgramTest {
 protected:
  static std::int64_t boundary_ns(std::uint64_t frame) {
    return kBegin_ns + static_cast<std::int64_t>(frame - 11) * kPeriod_ns;
  }
  // Frame 12 has a fault of module 2, 13 a command and a late predecessor.
  static std::vector<std::uint8_t> record(std::uint64_t frame) {
    std::vector<std::uint8_t> bytes;
    const auto put = [&](auto... values) {
      const auto one = [&](auto x) {
        const auto* begin = reinterpret_cast<const std::uint8_t*>(&x);
        bytes.insert(bytes.end(), begin, begin + sizeof x);
      };
      (one(values), ...);
    };
    const std::int64_t t = boundary_ns(frame);
    put(frame, t, std::uint32_t{1}, t - 700'000);
    put(std::uint32_t{frame == 13 ? 1u : 0u});
    if (frame == 13) put(std::array{'m', 'e', '\0', '\0'}, std::uint16_t{7}, t - 900'000);
    put(std::uint32_t{frame == 12 ? 1u : 0u});
    if (frame == 12) put(t, std::uint16_t{1011}, std::uint16_t{2});
    const std::int64_t released = boundary_ns(frame - 1) + kOffset_ns + 123'457;
    put(t, t + 50'000, t + 53'000, t + 60'000, t + 90'001, released, kOffset_ns - 90'001,
        kOffset_ns, std::uint64_t{frame < 13 ? 4u : 5u}, std::uint64_t{0}, std::uint64_t{0});
    return bytes;
  }
  // Frames 11 to 13, then 16.
  void write(const char* schema = kSchema) const {
    std::filesystem::remove(path_);
    lss::record::RecordingWriter writer;
    const nlohmann::ordered_json header = {{"lss", "recording"},   {"utc_ns", kBegin_ns},
                                           {"time_ns", kBegin_ns}, {"file", 1},
                                           {"start", true},        {"lost_before", 0},
                                           {"vehicle", "zebro"},   {"vehicle_id", "z-1"},
                                           {"version", "0.0"},     {"period_ns", kPeriod_ns},
                                           {"schema", schema}};
    ASSERT_EQ(writer.begin(path_, header, 0), 0);
    for (const std::uint64_t frame : {11u, 12u, 13u, 16u}) {
      if (frame == 16) writer.add_lost(2);
      writer.add_frame(record(frame), boundary_ns(frame));
    }
    ASSERT_EQ(writer.flush(), 0);
    ASSERT_EQ(writer.end(), 0);
  }
  json events(const std::vector<std::string>& more = {}) {
    std::vector<std::string> words = {"timing", "trace", path_};
    words.insert(words.end(), more.begin(), more.end());
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, 0) << ended.err;
    return json::parse(ended.out).at("traceEvents");
  }
  // Of this phase and name, on the track of a thread.
  static std::vector<json> of(const json& all, const std::string& thread, const std::string& name) {
    std::map<int, std::string> tracks;
    for (const json& e : all) {
      if (e["name"] == "thread_name") tracks[e["tid"]] = e["args"]["name"];
    }
    std::vector<json> found;
    for (const json& e : all) {
      if (e["name"] == name && e.contains("tid") && tracks[e["tid"]] == thread) found.push_back(e);
    }
    return found;
  }
  static double us(std::int64_t ns) { return static_cast<double>(ns) / 1000; }

  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "z-1.lssrec").string();
};

TEST_F(Trace, HasTheStepsOfEachFrameOnTheTrackOfItsThread) {
  write();
  const json all = events();
  const std::int64_t t = boundary_ns(12);
  const auto expect = [&](const char* name, std::int64_t from_ns, std::int64_t for_ns) {
    const auto slices = of(all, "frame", name);
    ASSERT_EQ(slices.size(), 4u) << name;
    EXPECT_EQ(slices[1]["ph"], "X");
    EXPECT_DOUBLE_EQ(slices[1]["ts"], us(t + from_ns)) << name;
    EXPECT_DOUBLE_EQ(slices[1]["dur"], us(for_ns)) << name;
  };
  expect("frame", 0, 90'001);
  expect("wake-up", 0, 50'000);
  expect("read", 50'000, 3'000);
  expect("navigate", 53'000, 7'000);
  expect("control", 60'000, 30'001);
  EXPECT_EQ(of(all, "frame", "frame")[1]["args"]["frame"], 12);
  EXPECT_DOUBLE_EQ(of(all, "frame", "frame")[1]["args"]["margin_us"], 4909.999);
  EXPECT_EQ(all[0]["args"]["name"], "z-1, lssd 0.0");
}

TEST_F(Trace, HasTheReleaseOfTheFrameBeforeOnlyWhenThatOneIsRecorded) {
  write();
  const auto releases = of(events(), "actuate", "release");
  ASSERT_EQ(releases.size(), 2u) << "of frames 11 and 12; 10 and 15 are not in it";
  EXPECT_EQ(releases[0]["args"]["frame"], 11);
  EXPECT_DOUBLE_EQ(releases[0]["ts"], us(boundary_ns(11) + kOffset_ns));
  EXPECT_DOUBLE_EQ(releases[0]["dur"], 123.457);
  EXPECT_EQ(releases[1]["args"]["frame"], 12);
}

TEST_F(Trace, HasWhatHappenedWhenItHappened) {
  write();
  const json all = events();
  const auto samples = of(all, "bus", "sample");
  ASSERT_EQ(samples.size(), 4u);
  EXPECT_DOUBLE_EQ(samples[3]["ts"], us(boundary_ns(16) - 700'000));
  const auto commands = of(all, "DDS listener", "command 7");
  ASSERT_EQ(commands.size(), 1u);
  EXPECT_DOUBLE_EQ(commands[0]["ts"], us(boundary_ns(13) - 900'000));
  EXPECT_EQ(commands[0]["args"]["source"], "me");
  const auto faults = of(all, "frame", "port_lost");
  ASSERT_EQ(faults.size(), 1u);
  EXPECT_EQ(faults[0]["args"]["subject"], 2);
  const auto late = of(all, "actuate", "command late");
  ASSERT_EQ(late.size(), 1u);
  EXPECT_DOUBLE_EQ(late[0]["ts"], us(boundary_ns(13)));
  const auto lost = of(all, "frame", "not recorded");
  ASSERT_EQ(lost.size(), 1u);
  EXPECT_EQ(lost[0]["args"]["frames"], 2);
}

TEST_F(Trace, GoesToAFileAndMayBeAPart) {
  write();
  const std::string out = (folder_ / "trace.json").string();
  const Ended ended = run({"--json", "timing", "trace", path_, "--out", out});
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_EQ(json::parse(ended.out)["frames"], 4);
  EXPECT_EQ(json::parse(testing_support::content(out)).at("traceEvents"), events());
  const json part = events({"--from", "10ms", "--to", "40ms"});
  EXPECT_EQ(of(part, "frame", "frame").size(), 2u);
}

TEST_F(Trace, SaysWhatIsWrongWithItsInput) {
  const auto fails = [&](std::vector<std::string> words, int code, const char* text) {
    words.insert(words.begin(), "timing");
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, code) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(text));
  };
  fails({"trace"}, 2, "of which recording?");
  fails({"trace", path_}, 2, "is no flight recording");
  fails({"certainly", path_}, 2, "certainly");
  write("in:{frame:u8;time_ns:i8;};");
  fails({"trace", path_}, 4, "in.samples");
  write();
  fails({"trace", path_, "--out", "/none/trace.json"}, 2, "/none/trace.json");
  fails({"trace", path_, "--from", "1min"}, 2, "no frame in this range");
}

class Certify : public Trace {
 protected:
  void fails(std::vector<std::string> words, int code, const char* text, const char* advice = "") {
    const std::vector<std::string> verb = {"timing", "certify"};
    words.insert(words.begin(), verb.begin(), verb.end());
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, code) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(text));
    EXPECT_THAT(ended.err, HasSubstr(advice));
  }
  std::string config(const std::string& vehicle, const std::string& more = "") const {
    const std::string path = (folder_ / (vehicle + ".toml")).string();
    testing_support::put_content(path, "vehicle = '" + vehicle + "'\n" + more +
                                           "[[port]]\nname = 'legs'\npath = 'sim:legs'\n");
    return path;
  }
};

TEST_F(Certify, SaysWhatIsMissing) {
  write();
  const std::string zebro = config("zebro");
  fails({path_}, 2, "for which configuration?", "--config FILE");
  fails({"--config", "/none.toml", path_}, 2, "/none.toml", "lssd would not start");
  fails({"--config", zebro}, 2, "of which frames", "name recordings");
  fails({"--config", zebro, zebro}, 2, zebro.c_str());
  fails({"--config", zebro, path_, "--lssd", "/none/lssd"}, 6, "/none/lssd cannot count",
        "--lssd FILE");
  fails({"--config", zebro, path_, "--seconds", "0"}, 2, "--seconds");
  fails({"--config", config("zebro", "[[realtime.thread]]\nname = 'frame'\npriority = 0\n"), path_},
        2, "thread frame is no real-time thread", "priority");
}

// --out before a list of recordings takes the first of them.
TEST_F(Trace, NoOutputOverwritesARecording) {
  write();
  const std::string before = testing_support::content(path_);
  const std::string topics = (folder_ / "a.mcap").string();
  recording::McapWriter::create(topics, "lss-cli test").close();
  const auto refused = [&](const std::vector<std::string>& words) {
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, 2) << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(path_ + " is a recording"));
    EXPECT_EQ(testing_support::content(path_), before);
  };
  refused({"timing", "trace", path_, "--out", path_});
  refused({"timing", "certify", "--config", "none.toml", "--out", path_, topics});
  refused({"report", topics, "--out", path_});
}

}  // namespace
}  // namespace lss::cli::test
