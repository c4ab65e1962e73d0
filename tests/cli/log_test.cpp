// log list and log show, on files as the daemon leaves them (the real ones:
// tests/e2e/test_stuck.py).

#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "tests/cli/program_test.h"
#include "tests/support/temp_folder.h"

namespace lss::cli::test {
namespace {

namespace fs = std::filesystem;

class Log : public ProgramTest {
 protected:
  std::string write(const std::string& name, const std::vector<json>& lines) const {
    const fs::path path = folder_ / name;
    std::ofstream file(path);
    for (const json& line : lines) file << line.dump() << "\n";
    return path.string();
  }
  static json log_header() {
    return {{"lss", "log"},
            {"vehicle", "zebro"},
            {"vehicle_id", "z-1"},
            {"preset", "standard"},
            {"utc_ns", 1'900'000'000'000'000'000}};
  }
  // Of a preset with state; nothing else is there.
  static json log_frame(int number) {
    return {{"frame", number},
            {"time_ns", number * 20'000'000},
            {"utc_ns", 1'900'000'000'000'000'000 + number * 20'000'000},
            {"state", {{"controller", {{"state", "Operational"}}}}}};
  }
  static json header() { return {{"lss", "crash"}, {"vehicle", "zebro"}, {"vehicle_id", "z-1"}}; }
  static json frame(int number, std::int64_t margin_ns, const json& events = json::array()) {
    const std::int64_t boundary = number * 20'000'000;
    return {{"in", {{"requests", {{{"source", "me"}, {"kind", 3}}}}}},
            {"outbox", {{"events", events}}},
            {"state", {{"controller", {{"state", "Idle"}}}}},
            {"timing",
             {{"frame", number},
              {"boundary_ns", boundary},
              {"woken_ns", boundary + 50'000},
              {"ready_ns", boundary + 70'000},
              {"margin_ns", margin_ns},
              {"samples", 8}}}};
  }

  testing_support::TempFolder folder_;
};

TEST_F(Log, ShowsEveryFrameWithItsTimesAndEvents) {
  const std::string file =
      write("z.crash.jsonl",
            {header(), frame(7, 4'900'000),
             frame(8, 4'800'000, {{{"id", 1011}, {"subject", 0}}, {{"id", 9}, {"subject", 4}}})});
  const Ended ended = run({"log", "show", file});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, HasSubstr("z-1 (zebro)"));
  EXPECT_THAT(ended.out, HasSubstr("-20.0      50.0      70.0    4900.0        8  Idle"));
  EXPECT_THAT(ended.out, HasSubstr("<me command 3> FAULT port_lost module_online 4"));
  const json all = json::parse(run({"--json", "log", "show", file}).out);
  EXPECT_EQ(all["frames"].size(), 2U);
  EXPECT_EQ(all["header"]["vehicle"], "zebro");
}

TEST_F(Log, ShowsOneFrameWhole) {
  const std::string file = write("z.crash.jsonl", {header(), frame(7, 1), frame(8, 1)});
  const Ended one = run({"--json", "log", "show", file, "--frame", "8"});
  EXPECT_EQ(json::parse(one.out)["timing"]["frame"], 8);
  const Ended none = run({"log", "show", file, "--frame", "9"});
  EXPECT_EQ(none.code, 4);
  EXPECT_THAT(none.err, HasSubstr("no frame 9"));
}

TEST_F(Log, ListsWhatADaemonWroteOldestFirst) {
  write("z-1-000002-20300317T174640Z-standard.log.jsonl", {log_header(), log_frame(1)});
  write("z-1-000001-20300317T174640Z-port_lost.crash.jsonl", {header()});
  write("z-1-000003-20300317T174640Z-quiet.log.jsonl", {});  // killed before its first line
  write("z-1-000003-20300317T174640Z-port_lost.crash.jsonl.part", {header()});
  write("notes.txt", {});
  const json all = json::parse(run({"--json", "log", "list", folder_.string()}).out);
  ASSERT_EQ(all["files"].size(), 3U);
  const json& crash = all["files"][0];
  EXPECT_EQ(crash["kind"], "crash");
  EXPECT_EQ(crash["what"], "port_lost");
  const json& log = all["files"][1];
  EXPECT_EQ(log["kind"], "log");
  EXPECT_EQ(log["what"], "standard");
  EXPECT_EQ(log["vehicle_id"], "z-1");
  EXPECT_EQ(log["begun_utc_ns"], 1'900'000'000'000'000'000);
  EXPECT_GT(log["written_utc_ns"], 1'700'000'000'000'000'000);
  EXPECT_EQ(log["bytes"], fs::file_size(log["path"].get<std::string>()));
  EXPECT_EQ(all["files"][2]["what"], nullptr);
  const Ended ended = run({"log", "list", folder_.string()});
  EXPECT_THAT(ended.out, HasSubstr("2030-03-17 17:46:40"));
  EXPECT_THAT(ended.out, HasSubstr("port_lost"));
  EXPECT_EQ(run({"log", "list", (folder_ / "nowhere").string()}).code, 2);
}

TEST_F(Log, ShowsTheLogThatRunsLineByLine) {
  json second = log_frame(2);
  second["lost_frames"] = 7;
  second["outbox"] = {{"events", {{{"id", 1011}, {"subject", 0}}}}};
  json third = log_frame(9);
  third.erase("state");  // events alone
  const std::string file = write("z.log.jsonl", {log_header(), log_frame(1), second, third});
  const Ended ended = run({"log", "show", file});
  EXPECT_EQ(ended.code, 0);
  EXPECT_THAT(ended.out, HasSubstr("z-1 (zebro)"));
  EXPECT_THAT(ended.out, HasSubstr("log \"standard\""));
  EXPECT_THAT(ended.out, HasSubstr("       1 2030-03-17 17:46:40.020  Operational"));
  EXPECT_THAT(ended.out, HasSubstr("FAULT port_lost lost_frames 7"));
  EXPECT_THAT(ended.out, HasSubstr("       9 2030-03-17 17:46:40.180"));
  const json all = json::parse(run({"--json", "log", "show", file}).out);
  EXPECT_EQ(all["header"]["preset"], "standard");
  ASSERT_EQ(all["frames"].size(), 3U);
  EXPECT_EQ(all["frames"][1]["lost_frames"], 7);
  const std::string lines = run({"--jsonl", "log", "show", file}).out;
  EXPECT_EQ(std::count(lines.begin(), lines.end(), '\n'), 4);
  EXPECT_EQ(json::parse(run({"--json", "log", "show", file, "--frame", "9"}).out)["frame"], 9);
  EXPECT_EQ(run({"log", "show", file, "--frame", "3"}).code, 4);
}

TEST_F(Log, AHalfLineAtTheEndOfALogIsLeftOutAndReported) {
  const std::string file = write("z.log.jsonl", {log_header(), log_frame(1), log_frame(2)});
  fs::resize_file(file, fs::file_size(file) - 10);
  const Ended ended = run({"--json", "log", "show", file});
  EXPECT_EQ(ended.code, 0);
  EXPECT_EQ(json::parse(ended.out)["frames"].size(), 1U);
  EXPECT_THAT(ended.err, HasSubstr("last line is cut off"));
  std::ofstream(file, std::ios::app) << "\n" << log_frame(3).dump() << "\n";
  const Ended damaged = run({"log", "show", file});
  EXPECT_EQ(damaged.code, 2);
  EXPECT_THAT(damaged.err, HasSubstr(file + ":3"));
}

TEST_F(Log, WhatIsNoLogIsRefusedByLine) {
  EXPECT_EQ(run({"log", "show", (folder_ / "nowhere").string()}).code, 2);
  EXPECT_EQ(run({"log", "show", write("empty", {})}).code, 2);
  EXPECT_EQ(run({"log", "show", write("other", {{{"a", 1}}})}).code, 2);
  const std::string damaged = write("damaged", {header(), frame(1, 1), json::array()});
  const Ended ended = run({"log", "show", damaged});
  EXPECT_EQ(ended.code, 2);
  EXPECT_THAT(ended.err, HasSubstr(damaged + ":3"));
  // Whole JSON, but not of a frame.
  json half = frame(1, 1);
  half["timing"].erase("margin_ns");
  const Ended hollow = run({"log", "show", write("half", {header(), half})});
  EXPECT_EQ(hollow.code, 2);
  EXPECT_THAT(hollow.err, HasSubstr("lacks what a frame has"));
}

// Lines from others: each is shown, or the file is refused; the program goes on.
TEST_F(Log, LinesThatAreTooMuchAreRefused) {
  const std::string deep = std::string(200'000, '[') + std::string(200'000, ']');
  const auto put = [&](const std::string& line) {
    const fs::path path = folder_ / "z.log.jsonl";
    std::ofstream(path) << log_header().dump() << "\n"
                        << line << "\n"
                        << log_frame(2).dump() << "\n";
    return path.string();
  };
  const std::string nested = put(R"({"frame": 1, "state": )" + deep + "}");
  EXPECT_EQ(run({"log", "show", nested}).code, 2);
  EXPECT_THAT(run({"log", "show", nested}).err, HasSubstr(nested + ":2: no log of lssd"));
  const std::string line = put(std::string(5'000'000, ' '));
  EXPECT_EQ(run({"log", "show", line}).code, 2);
  EXPECT_THAT(run({"log", "show", line}).err, HasSubstr(":2: a line is longer than 4000000 bytes"));
  const std::string times = put(R"({"frame": 1, "utc_ns": -9223372036854775808})");
  EXPECT_EQ(run({"log", "show", times}).code, 0);
  const fs::path first = folder_ / "y.log.jsonl";
  std::ofstream(first) << R"({"vehicle_id": )" << deep << "}\n";
  EXPECT_EQ(run({"log", "list", folder_.string()}).code, 0);
  const fs::path pipe = folder_ / "p";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  EXPECT_EQ(run({"log", "show", pipe.string()}).code, 2);
}

}  // namespace
}  // namespace lss::cli::test
