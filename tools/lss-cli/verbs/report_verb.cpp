// report: a recording as one HTML page.

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/report/common.h"
#include "tools/lss-cli/session/described_vehicle.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/recording_verbs.h"

namespace lss::cli {
namespace {

std::string page_of(const recording::Recording& recording) {
  const recording::Span& span = recording.span();
  const RecordedVehicle recorded(recording.about("dictionary"), recording.about("vehicle"));
  const Vehicle* vehicle = recorded.vehicle();
  report::Page page(
      fmt::format("{} ({})", recording.about("vehicle_id"), recording.about("vehicle")),
      fmt::format("Recorded from {:%F %T} UTC for {}, {} messages; lssd {}. Times are in seconds "
                  "since then.",
                  fmt::gmtime(static_cast<std::time_t>(span.first_ns / 1'000'000'000)),
                  format_duration(recording::ns_between(span.first_ns, span.last_ns) * 1e-9),
                  span.messages, recording.about("version")));
  if (!recording.complaint().empty())
    page.note("The recording is not whole: " + recording.complaint() + ".");
  if (vehicle != nullptr && vehicle->overlay != nullptr)
    vehicle->overlay->add_report(recording, page);
  page.section("States");
  report::add_states(recording, page);
  report::add_events(recording, page);
  report::add_commands(recording, vehicle, page);
  report::add_timing(recording, page);
  report::add_topics(recording, page);
  return page.html();
}

struct ReportWanted {
  std::string path, out;
};

ExitCode run_report(Context& context, const ReportWanted& wanted) {
  if (recording::is_flight(wanted.path)) {
    throw Failure(ExitCode::usage,
                  wanted.path + " is a flight recording; reports are made of topics",
                  "record them with: lss-cli record --out FILE.mcap; of this one there is "
                  "lss-cli log and lss-cli plot");
  }
  const std::string out = wanted.out.empty()
                              ? std::filesystem::path(wanted.path).stem().string() + ".html"
                              : wanted.out;
  recording::refuse_recording(out);
  const auto recording = recording::open(wanted.path);
  const std::string html = page_of(*recording);
  write_file(html, out);
  context.output.print(fmt::format("{}: {} kB\n", out, html.size() / 1000));
  context.output.document({{"out", out}, {"bytes", html.size()}});
  return ExitCode::completed;
}

}  // namespace

void write_file(const std::string& content, const std::string& out) {
  std::ofstream file(out, std::ios::binary);
  file << content;
  file.close();
  if (!file) {
    throw Failure(ExitCode::failed,
                  fmt::format("{} cannot be written: {}", out, std::strerror(errno)),
                  "name a file in a folder that you may write to: --out FILE");
  }
}

void add_report_verb(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub =
      grammar.verb("report", "a recording as one HTML page, with the vehicle's own diagrams",
                   "  lss-cli report run.mcap\n  lss-cli report run.mcap --out run.html\n");
  auto wanted = std::make_shared<ReportWanted>();
  sub.add_option("file", wanted->path, "a recording")->required();
  sub.add_option("-o,--out", wanted->out, "FILE.html; without it the name of the recording, here");
  grammar.on(sub, [wanted](Context& context) { return run_report(context, *wanted); });
}

}  // namespace lss::cli
