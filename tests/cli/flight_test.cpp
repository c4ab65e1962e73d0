// log list, show and export, and plot, of flight recordings: files of small records that are made
// here. Of real ones: tests/e2e/test_record.py, tests/campaign/replay_test.cpp.

#include "tools/lss-cli/recording/flight.h"

#include <sys/wait.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "tests/cli/program_test.h"
#include "tests/cli/strider.h"
#include "tests/support/temp_folder.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli::test {
namespace {

namespace fs = std::filesystem;
using recording::Flight;
using recording::RecordLayout;

constexpr const char* kSchema =
    "in:{frame:u8;time_ns:i8;requests:<{source:[4]c1;kind:u2;}>;};"
    "outbox:{events:<{time_ns:i8;id:u2;subject:u2;}>;};"
    "state:{controller:{state:u1;};};"
    "telemetry:{distance_m:f8;modules:[3]{current_A:f4;online:b1;};"
    "reading:({count:i4;}|{range_m:[2]f8;});};"
    "timing:{frame:u8;boundary_ns:i8;woken_ns:i8;ready_ns:i8;margin_ns:i8;};";
constexpr std::int64_t kUtc_ns = 1'900'000'000'000'000'000, kBegin_ns = 1'000'000'000'000;
constexpr std::int64_t kPeriod_ns = 20'000'000;

class RecordBytes {
 public:
  template <class T>
  RecordBytes& put(T x) {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(&x);
    bytes.insert(bytes.end(), begin, begin + sizeof x);
    return *this;
  }
  std::vector<std::uint8_t> bytes;
};

// Frame 103 has a fault, 104 two requests; readings take turns; one number is none.
std::vector<std::uint8_t> record(std::uint64_t frame, std::uint16_t event) {
  const auto at = kBegin_ns + static_cast<std::int64_t>(frame - 101) * kPeriod_ns;
  RecordBytes out;
  out.put(frame).put(at);
  const std::uint32_t requests = frame == 104 ? 2 : 0;
  out.put(requests);
  for (std::uint16_t i = 0; i < requests; ++i) out.put(std::array{'m', 'e', '\0', '\0'}).put(i);
  out.put(std::uint32_t{frame == 103 ? 1u : 0u});
  if (frame == 103) out.put(at).put(event).put(std::uint16_t{2});
  out.put(std::uint8_t{1});
  out.put(static_cast<double>(frame) / 8);
  for (int i = 0; i < 3; ++i)
    out.put(frame == 102 && i == 1 ? std::nanf("") : 0.5f * static_cast<float>(i))
        .put(std::uint8_t{1});
  if (frame % 2 == 0) {
    out.put(std::uint8_t{0}).put(std::int32_t{-7});
  } else {
    out.put(std::uint8_t{1}).put(1.5).put(2.5);
  }
  return out.put(frame)
      .put(at)
      .put(at + 50'000)
      .put(at + 90'000)
      .put(std::int64_t{4'910'000})
      .bytes;
}

class FlightLog : public ProgramTest {
 protected:
  // Ten frames, two in a chunk; three are missing before frame 106.
  void write(bool ended = true, const char* schema = kSchema) const {
    fs::remove(path_);
    lss::record::RecordingWriter writer;
    nlohmann::ordered_json header = {{"lss", "recording"},   {"utc_ns", kUtc_ns},
                                     {"time_ns", kBegin_ns}, {"file", 1},
                                     {"start", true},        {"lost_before", 0},
                                     {"vehicle", "zebro"},   {"vehicle_id", "z-1"},
                                     {"version", "0.0"},     {"period_ns", kPeriod_ns},
                                     {"schema", schema}};
    header.update(more_);
    ASSERT_EQ(writer.begin(path_, header, 0), 0);
    for (std::uint64_t i = 0; i < 10; ++i) {
      const std::uint64_t frame = 101 + i + (i >= 5 ? 3 : 0);
      if (i == 5) writer.add_lost(3);
      writer.add_frame(record(frame, event_),
                       kBegin_ns + static_cast<std::int64_t>(frame - 101) * kPeriod_ns);
      if (i % 2 == 1) {
        ASSERT_EQ(writer.flush(), 0);
      }
    }
    if (ended) {
      ASSERT_EQ(writer.end(), 0);
    }
  }
  std::string content() const { return testing_support::content(path_); }
  void put_content(const std::string& text) const { testing_support::put_content(path_, text); }
  std::vector<std::uint64_t> numbers(const recording::Part& part = {}) const {
    std::vector<std::uint64_t> list;
    Flight(path_).each(part, [&](const Flight::Frame& frame) { list.push_back(frame.number); });
    return list;
  }
  static std::vector<std::string> lines(const std::string& text) {
    std::vector<std::string> list;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) list.push_back(line);
    return list;
  }

  std::uint16_t event_ = 1011;
  nlohmann::ordered_json more_ = nlohmann::ordered_json::object();  // of the header
  testing_support::TempFolder folder_;
  std::string path_ = (folder_ / "z-1-000001-20300317T174640Z-zebro.lssrec").string();
};

TEST_F(FlightLog, IsListedWithItsKindTimesAndFrames) {
  write();
  const json said = json::parse(run({"--json", "log", "list", path_}).out);
  EXPECT_EQ(said["kind"], "lssrec");
  EXPECT_EQ(said["vehicle_id"], "z-1");
  EXPECT_EQ(said["begun_utc_ns"], kUtc_ns);
  EXPECT_EQ(said["frames"], 10);
  EXPECT_EQ(said["first_frame"], 101);
  EXPECT_EQ(said["last_frame"], 113);
  EXPECT_DOUBLE_EQ(said["duration_s"], 0.26);
  EXPECT_EQ(said["lost"], 3);
  EXPECT_EQ(said["end"], "ended");
  EXPECT_EQ(said["whole"], true);
  const Ended people = run({"log", "list", path_});
  EXPECT_EQ(people.code, 0);
  EXPECT_THAT(people.out, HasSubstr("z-1 (zebro), lssd 0.0"));
  EXPECT_THAT(people.out, HasSubstr("10 frames in"));
  EXPECT_THAT(people.out, HasSubstr("with the start of lssd"));
  const json all = json::parse(run({"--json", "log", "list", folder_.string()}).out);
  EXPECT_EQ(all["files"][0]["kind"], "lssrec");
  EXPECT_EQ(all["files"][0]["what"], "10 frames");
  // With any name.
  const std::string other = (folder_ / "renamed.bin").string();
  fs::rename(path_, other);
  EXPECT_EQ(json::parse(run({"--json", "log", "list", other}).out)["frames"], 10);
}

TEST_F(FlightLog, ListsTheFieldsThatThereAre) {
  write();
  const json said =
      json::parse(run({"--json", "log", "list", path_, "--columns", "modules,in.requests"}).out);
  std::vector<std::string> names;
  for (const json& field : said["fields"]) names.push_back(field["name"]);
  EXPECT_THAT(names, ElementsAre("in.requests[0].source", "in.requests[0].kind",
                                 "telemetry.modules[0].current_A", "telemetry.modules[0].online",
                                 "telemetry.modules[1].current_A", "telemetry.modules[1].online",
                                 "telemetry.modules[2].current_A", "telemetry.modules[2].online"));
  EXPECT_EQ(said["fields"][0]["type"], "text");
  EXPECT_EQ(said["fields"][2]["type"], "f4");
}

TEST_F(FlightLog, ShowsALineForEachFrameWithWhatHappened) {
  write();
  const Ended ended = run({"log", "show", path_});
  EXPECT_EQ(ended.code, 0) << ended.err;
  const auto all = lines(ended.out);
  ASSERT_EQ(all.size(), 2u + 10u);
  EXPECT_THAT(all[2], HasSubstr("101      0.000      50.0      90.0    4910.0  Operational"));
  EXPECT_THAT(all[4], HasSubstr("FAULT port_lost 2"));
  EXPECT_THAT(all[5], HasSubstr("<me heartbeat> <me command 1>"));
  EXPECT_THAT(all[7], HasSubstr("109      0.160"));
  EXPECT_THAT(all[7], HasSubstr("lost_frames 3"));
}

TEST_F(FlightLog, ShowsFramesAsJsonByFieldsTimeAndNumber) {
  write();
  const json all = json::parse(run({"--json", "log", "show", path_}).out);
  ASSERT_EQ(all["frames"].size(), 10u);
  EXPECT_EQ(all["header"]["vehicle"], "zebro");
  EXPECT_FALSE(all["header"].contains("schema"));
  const json& third = all["frames"][2];
  EXPECT_EQ(third["state"]["controller"]["state"], "Operational");
  EXPECT_EQ(third["outbox"]["events"][0]["name"], "port_lost");
  EXPECT_EQ(third["telemetry"]["reading"], json({{"range_m", {1.5, 2.5}}}));
  EXPECT_EQ(all["frames"][1]["telemetry"]["reading"], json({{"count", -7}}));
  EXPECT_EQ(all["frames"][1]["telemetry"]["modules"][1]["current_A"], nullptr) << "NaN";
  EXPECT_EQ(all["frames"][3]["in"]["requests"][1]["source"], "me");
  EXPECT_EQ(all["frames"][5]["lost_frames"], 3);

  const auto some = lines(
      run({"--jsonl", "log", "show", path_, "--columns",
           "distance_m,modules[*].current_A,modules[2].online", "--from", "20ms", "--to", "0.06"})
          .out);
  ASSERT_EQ(some.size(), 3u);
  const json one = json::parse(some[1]);
  EXPECT_EQ(one["frame"], 103);
  EXPECT_EQ(one["utc_ns"], kUtc_ns + 2 * kPeriod_ns);
  EXPECT_EQ(one["telemetry"], json::parse(R"({"distance_m": 12.875, "modules":
              [{"current_A": 0.0}, {"current_A": 0.5}, {"current_A": 1.0, "online": true}]})"));
  EXPECT_FALSE(one.contains("in"));
  // The place in an array stays.
  const auto last = lines(
      run({"log", "show", path_, "--columns", "modules[2].online", "--frame", "104..110"}).out);
  ASSERT_EQ(last.size(), 4u);
  EXPECT_EQ(json::parse(last[0])["telemetry"],
            json::parse(R"({"modules": [null, null, {"online": true}]})"));
  EXPECT_EQ(json::parse(last[3])["frame"], 110);
  const json single = json::parse(run({"--json", "log", "show", path_, "--frame", "104"}).out);
  EXPECT_EQ(single["timing"]["frame"], 104);
}

TEST_F(FlightLog, ExportsRowsOfTheFieldsThatWereChosen) {
  write();
  const auto rows = lines(run({"log", "export", path_, "--columns",
                               "reading,modules[1].current_A,in.requests[*].source,state"})
                              .out);
  ASSERT_EQ(rows.size(), 11u);
  EXPECT_EQ(rows[0],
            "t_s,frame,time_ns,utc_ns,in.requests[0].source,in.requests[1].source,"
            "state.controller.state,telemetry.modules[1].current_A,telemetry.reading.count,"
            "telemetry.reading.range_m[0],telemetry.reading.range_m[1]");
  EXPECT_EQ(rows[1], "0.000000,101,1000000000000,1900000000000000000,,,1,0.5,,1.5,2.5");
  EXPECT_EQ(rows[2], "0.020000,102,1000020000000,1900000000020000000,,,1,,-7,,");
  EXPECT_EQ(rows[4], "0.060000,104,1000060000000,1900000000060000000,me,me,1,0.5,-7,,");

  const std::string out = (folder_ / "all.csv").string();
  const json done =
      json::parse(run({"--json", "log", "export", path_, "--out", out, "--frame", "..105"}).out);
  EXPECT_EQ(done["frames"], 5);
  std::ifstream file(out);
  std::string head;
  std::getline(file, head);
  EXPECT_THAT(head, HasSubstr(",telemetry.modules[2].online,"));
  EXPECT_THAT(head, testing::Not(HasSubstr("events["))) << "lists are named, or left out";
}

TEST_F(FlightLog, AnExportThatFailsLeavesTheFileOfBefore) {
  write();
  const std::string out = (folder_ / "old.csv").string();
  testing_support::put_content(out, "of before");
  fs::permissions(out, fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(run({"log", "export", path_, "--out", out, "--columns", "curent_A"}).code, 4);
  EXPECT_EQ(testing_support::content(out), "of before");
  EXPECT_EQ(run({"log", "export", path_, "--out", out}).code, 0);
  EXPECT_THAT(testing_support::content(out), StartsWith("t_s,frame,"));
  EXPECT_EQ(fs::status(out).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_EQ(folder_.files().size(), 2u) << "the recording and the rows";
  const fs::path link = folder_ / "nothing.csv";
  fs::create_symlink("/dev/null", link);
  EXPECT_EQ(run({"log", "export", path_, "--out", link.string()}).code, 0);
  EXPECT_TRUE(fs::is_symlink(link));
}

TEST_F(FlightLog, RowsThatAFullDiskDoesNotTakeAreAnError) {
  write();
  const std::string words = " log export --columns distance_m " + path_;
  const int status = std::system(("'" LSS_CLI "'" + words + " > /dev/full 2> /dev/null").c_str());
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 6);
}

TEST_F(FlightLog, SignalsAreDrawnAndAReportIsOfTopics) {
  write();
  const std::string out = (folder_ / "a.svg").string();
  const Ended drawn = run({"--json", "plot", path_, "--signals",
                           "modules[*].current_A,reading.count,timing.margin_ns", "--out", out});
  ASSERT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_EQ(json::parse(drawn.out)["signals"].size(), 5u);
  std::ifstream file(out);
  const std::string picture{std::istreambuf_iterator<char>(file), {}};
  EXPECT_THAT(picture, HasSubstr("telemetry.modules[2].current_A"));
  EXPECT_THAT(picture, testing::Not(HasSubstr("var("))) << "other programs know no variables";
  EXPECT_EQ(run({"plot", path_, "--signals", "distanse_m"}).code, 4);
  const Ended report = run({"report", path_});
  EXPECT_EQ(report.code, 2);
  EXPECT_THAT(report.err, HasSubstr("lss-cli record --out FILE.mcap"));
}

TEST_F(FlightLog, AnImpossibleRequestIsRefusedWithAdvice) {
  write();
  const auto refused = [&](std::vector<std::string> words, int code, const std::string& text) {
    words.insert(words.begin(), "log");
    words.insert(words.begin() + 2, path_);
    const Ended ended = run(words);
    EXPECT_EQ(ended.code, code) << ended.out << ended.err;
    EXPECT_THAT(ended.err, HasSubstr(text));
    EXPECT_THAT(ended.err, HasSubstr("-> ")) << "advice";
  };
  refused({"show", "--columns", "modules[1].curent_A"}, 4, "did you mean modules[1].current_A?");
  refused({"show", "--columns", "modules[3].current_A"}, 4, "there is no field");
  refused({"show", "--columns", "*.walrus"}, 4, "log list FILE --columns");
  refused({"show", "--from", "5"}, 2, "it has frames 101 to 113, from 0 to 0.240 s");
  refused({"export", "--from", "2", "--to", "1"}, 2, "--from 2 s is after --to 1 s");
  refused({"show", "--frame", "107"}, 4, "there is no frame 107 in it");
  refused({"show", "--frame", "105..108", "--from", "0.1"}, 2, "there is no frame in this range");
  refused({"show", "--frame", "x..3"}, 2, "as 154, 100..200, 100.. or ..200");
  refused({"show", "--frame", "9..3"}, 2, "begins after its end");
  refused({"show", "--topic", "event"}, 2, "has frames and no topics");
  refused({"export", "--out", "a.mcap"}, 2, "lss-cli record --out FILE.mcap");
  refused({"export", "--out", "a.xls"}, 2, "end its name in .csv");
  EXPECT_EQ(run({"log", "show", path_, "--columns", "in.requests[7].kind"}).code, 0)
      << "a list may become as long";

  put_content("{\"lss\": \"log\"}\n");
  refused({"show"}, 2, "is no recording");
  write(true, "in:{frame:u8;time_ns:i8;};nonsense");
  refused({"show"}, 6, "cannot be read from");
  write(true, "in:{frame:u8;time_ns:i8;};all:[3]u1;");
  refused({"show"}, 6, "lack what the line of a frame is made of");
  refused({"export"}, 6, "not as its header describes them");
  write(true, "in:{frame:u8;time_ns:i4;};");
  refused({"show"}, 6, "no in.frame and in.time_ns");
}

TEST_F(FlightLog, OneThatWasCutIsReadAsFarAsItIsWhole) {
  write();
  const std::string whole = content();
  std::size_t most = 0;
  for (std::size_t size = 16; size < whole.size(); size += 7) {
    put_content(whole.substr(0, size));
    try {
      const Flight flight(path_);
      EXPECT_NE(flight.complaint(), "") << size;
      EXPECT_EQ(flight.frames() % 2, 0u) << "whole chunks";
      EXPECT_GE(flight.frames(), most);
      most = flight.frames();
    } catch (const Failure& e) {  // not even the header is whole
      EXPECT_EQ(most, 0u);
      EXPECT_NE(e.advice(), "");
    }
  }
  EXPECT_EQ(most, 10u);
  put_content(whole.substr(0, whole.size() / 5 * 4));
  const Ended ended = run({"log", "list", path_});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, HasSubstr("torn: cut off at byte"));
  write(false);
  EXPECT_THAT(run({"log", "show", path_}).err, HasSubstr("not ended"));
  EXPECT_EQ(json::parse(run({"--json", "log", "list", path_}).out)["end"], "open");
}

// Only who asks for it gets what is behind the damage.
TEST_F(FlightLog, OneFlippedBitAnywhereIsReportedAndUndamagedFramesAreShown) {
  write();
  const std::string good = content();
  for (std::size_t bit = 0; bit < good.size() * 8; bit += 3) {
    std::string bad = good;
    bad[bit / 8] = static_cast<char>(bad[bit / 8] ^ (1 << bit % 8));
    put_content(bad);
    ASSERT_THROW(numbers(), Failure) << "bit " << bit;
  }
  std::string bad = good;
  bad[good.size() - 400] ^= 4;  // of frames 110 and 111
  put_content(bad);
  const auto before = numbers({.frames = recording::parse_frames("..103")});
  EXPECT_THAT(before, ElementsAre(101, 102, 103));
  EXPECT_THAT(numbers({.damaged = true}), ElementsAre(101, 102, 103, 104, 105, 109, 112, 113));
  const Ended shown = run({"--json", "log", "show", path_});
  EXPECT_EQ(shown.code, 6);
  EXPECT_EQ(json::parse(shown.out)["frames"].size(), 8u);
  EXPECT_THAT(shown.err, HasSubstr("damaged in the chunk that begins at byte"));
  EXPECT_THAT(shown.err, HasSubstr("chunks that are missing: 1; what is whole is read"));
  const Ended lost = run({"log", "show", path_, "--frame", "110"});
  EXPECT_EQ(lost.code, 6);
  EXPECT_THAT(lost.err, AllOf(HasSubstr("damaged in the chunk that begins at byte"),
                              HasSubstr("no frame of this range is in what is whole")));
  const Ended listed = run({"--json", "log", "list", path_});
  EXPECT_EQ(listed.code, 6);
  EXPECT_EQ(json::parse(listed.out)["end"], "damaged");
  EXPECT_EQ(json::parse(listed.out)["lost"], 5);
  const std::string csv = (folder_ / "a.csv").string();
  EXPECT_EQ(run({"log", "export", path_, "--out", csv}).code, 6);
  EXPECT_EQ(lines(testing_support::content(csv)).size(), 9u);
  try {
    numbers();
    FAIL();
  } catch (const Failure& e) {
    EXPECT_THAT(e.advice(), HasSubstr("or what is before it by: --frame ..109"));
  }
}

// Chunks: 0 the header, 1 to 5 two frames each, 6 the end.
TEST_F(FlightLog, LostFramesAtItsBeginningAndEndAreCountedOrReportedAsALowerBound) {
  const auto damaged = [&](bool ended, int chunk) {
    write(ended);
    std::string bytes = content();
    std::size_t at = 0;
    for (int i = 0; i <= chunk; ++i) at = bytes.find("LSSc", at + 1);
    bytes.at(at + 24) = static_cast<char>(bytes.at(at + 24) ^ 1);
    put_content(bytes);
    const json listed = json::parse(run({"--json", "log", "list", path_}).out);
    EXPECT_EQ(listed["end"], "damaged") << chunk;
    return std::pair(listed["lost"].get<int>(), listed["lost_known"].get<bool>());
  };
  for (const int chunk : {1, 3, 5}) EXPECT_EQ(damaged(true, chunk), std::pair(5, true)) << chunk;
  EXPECT_EQ(damaged(true, 6), std::pair(3, false)) << "how much it held is not known";
  EXPECT_EQ(damaged(false, 1), std::pair(3, false));
  EXPECT_EQ(damaged(false, 5), std::pair(3, false));
  EXPECT_THAT(run({"log", "list", path_}).out, HasSubstr("lost    at least 3 frames in it"));
  write();
  EXPECT_THAT(run({"log", "list", path_}).out, HasSubstr("lost    3 frames in it"));
}

TEST_F(FlightLog, OfAnUnknownVehicleHasTheNamesOfTheDictionaryInIt) {
  event_ = lss::kFaultEventBase + 900;
  json dictionary = json::parse(strider().dictionary);
  dictionary["faults"].push_back({{"number", 900},
                                  {"name", "mast_jammed"},
                                  {"severity", "error"},
                                  {"text", "the mast does not turn"},
                                  {"advice", "free it"}});
  const auto name = [&] {
    write();
    const json shown = json::parse(run({"--json", "log", "show", path_}).out);
    EXPECT_FALSE(shown["header"].contains("dictionary")) << "it is long";
    return shown["frames"][2]["outbox"]["events"][0]["name"];
  };
  more_ = {{"vehicle", "strider"}, {"dictionary", dictionary.dump()}};
  EXPECT_EQ(name(), "mast_jammed");
  more_["dictionary"] = "of another version";
  EXPECT_NE(name(), "mast_jammed");
}

}  // namespace
}  // namespace lss::cli::test
