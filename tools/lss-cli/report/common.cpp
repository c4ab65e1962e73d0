#include "tools/lss-cli/report/common.h"

#include <fmt/format.h>

#include <map>

#include "idl/timing_statistics.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/session/commands.h"

namespace lss::cli::report {
namespace {

using recording::Layout;
using recording::Message;

constexpr std::size_t kMostRows = 400;  // of a table; the newest
constexpr std::size_t kMostModes = 32;  // of a chart; the others share the last row

// Access to columns of messages by name.
class Fields {
 public:
  explicit Fields(const Message& message) : message_(message) {}
  double number(const char* name) const {
    const recording::Column* column = message_.topic.layout->find(name);
    return column == nullptr ? kUnset : message_.topic.layout->number(*column, message_.data);
  }
  // Exact, also above 2^53.
  std::int64_t whole(const char* name) const {
    const recording::Column* column = message_.topic.layout->find(name);
    if (column == nullptr) return 0;
    const auto value = message_.topic.layout->json(*column, message_.data);
    return value.is_number_integer() ? value.get<std::int64_t>() : 0;
  }
  std::string text(const char* name) const {
    const recording::Column* column = message_.topic.layout->find(name);
    return column == nullptr ? "" : message_.topic.layout->text(*column, message_.data);
  }

 private:
  const Message& message_;
};

// Every message of a topic; nothing when it is not there.
template <class Take>
void each(const recording::Recording& recording, const char* topic, const Take& take) {
  for (const recording::Topic& known : recording.topics()) {
    if (known.name != topic || known.layout == nullptr) continue;
    recording.each({.topics = {topic}}, [&](const Message& message) {
      if (&message.topic == &known) take(message, Fields(message));
    });
  }
}

std::string at_text(const recording::Recording& recording, const Message& message) {
  return fmt::format("{:.2f}", recording.seconds(message.publish_ns));
}

void put_table(Page& page, const std::vector<std::string>& heads, std::vector<Cells> rows) {
  if (rows.size() > kMostRows) {
    page.note(fmt::format("The last {} of {}.", kMostRows, rows.size()));
    rows.erase(rows.begin(), rows.end() - static_cast<std::ptrdiff_t>(kMostRows));
  }
  page.table(heads, rows);
}

// As in TimingCollector.
struct Points {
  std::uint64_t frame = 0, overruns = 0, commands_repeated = 0, frames_skipped = 0, frames_held = 0;
  std::int64_t boundary_ns = 0, woken_ns = 0, read_ns = 0, navigated_ns = 0, ready_ns = 0,
               released_ns = 0, offset_ns = 0;
};

Points points_of(const Fields& fields) {
  const auto count = [&](const char* name) {
    return static_cast<std::uint64_t>(fields.whole(name));
  };
  // No two are further apart than the range of an integer.
  const auto time = [&](const char* name) {
    constexpr std::int64_t kLatest = std::int64_t{1} << 61;
    return std::clamp(fields.whole(name), -kLatest, kLatest);
  };
  return {.frame = count("frame"),
          .overruns = count("overruns"),
          .commands_repeated = count("commands_repeated"),
          .frames_skipped = count("frames_skipped"),
          .frames_held = count("frames_held"),
          .boundary_ns = time("boundary_ns"),
          .woken_ns = time("woken_ns"),
          .read_ns = time("read_ns"),
          .navigated_ns = time("navigated_ns"),
          .ready_ns = time("ready_ns"),
          .released_ns = time("released_ns"),
          .offset_ns = time("offset_ns")};
}

Histogram histogram(const TimingStep& step, const TimingSeries& series) {
  Histogram result{fmt::format("{}: {}", step.name, step.what), "µs", {}, {}};
  for (std::size_t i = 0; i <= TimingSeries::kBuckets; ++i)
    result.edges.push_back(static_cast<double>(TimingSeries::lower_ns(i)) * 1e-3);
  for (const std::uint32_t count : series.bucket)
    result.shares.push_back(static_cast<double>(count) / static_cast<double>(series.count));
  return result;
}

}  // namespace

void add_states(const recording::Recording& recording, Page& page) {
  std::vector<double> t_s;
  std::vector<double> values;
  std::vector<Look> states, modes;
  std::map<std::string, std::size_t> known;
  std::vector<double> mode;
  states = {
      {"c0", "Idle"}, {"good", "Operational"}, {"bad", "FatalError"}, {"warn", "SolveErrors"}};
  each(recording, "lss/status", [&](const Message& message, const Fields& fields) {
    t_s.push_back(std::max(0.0, recording.seconds(message.publish_ns)));
    values.push_back(fields.number("state"));
    const std::string name = fields.text("mode_name");
    const bool room = modes.size() < kMostModes || known.contains(name);
    const auto [at, added] = known.try_emplace(room ? name : "others", modes.size());
    if (added) modes.push_back({fmt::format("c{}", modes.size() % kColours), at->first});
    mode.push_back(static_cast<double>(at->second));
  });
  if (t_s.size() < 2) return;
  RowChart chart{"State and mode", "time in s", {}, {0, t_s.back()}, {}};
  chart.rows.push_back({"state", bars_of(t_s, values, states)});
  std::vector<Look> used;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (std::ranges::count(values, static_cast<double>(i)) > 0) used.push_back(states[i]);
  }
  chart.legend = used;
  for (Look& look : modes) {
    chart.rows.push_back({look.meaning, {}});
    std::vector<Look> one(modes.size());
    const auto index = static_cast<std::size_t>(&look - modes.data());
    one[index] = {"idle", look.meaning};
    chart.rows.back().bars = bars_of(t_s, mode, one);
  }
  page.add(chart);
}

void add_timing(const recording::Recording& recording, Page& page) {
  page.section("Timing", "For every recorded frame: from its boundary to the named step.");
  TimingCollector<Points> collector;
  each(recording, "lss/timing",
       [&](const Message&, const Fields& fields) { collector.add(points_of(fields)); });
  const TimingStatistics& statistics = collector.statistics();
  if (statistics.frames == 0) return page.note("Nothing was recorded of lss/timing.");
  std::vector<Cells> rows;
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    const TimingSeries& s = statistics.series[i];
    if (s.count == 0) continue;
    const auto us = [](double ns) { return fmt::format("{:.1f}", ns * 1e-3); };
    rows.push_back(
        {{kTimingSteps[i].name, us(s.mean_ns()), us(s.sigma_ns()),
          us(static_cast<double>(s.min_ns)), us(s.quantile_ns(0.5)), us(s.quantile_ns(0.99)),
          us(s.quantile_ns(0.999)), us(static_cast<double>(s.max_ns))},
         ""});
  }
  page.table({"µs", "mean", "sigma", "min", "p50", "p99", "p99.9", "max"}, rows);
  page.note(fmt::format("{} frames, {} commands late, {} repeated, {} frames skipped.",
                        statistics.frames, statistics.overruns, statistics.repeated,
                        statistics.skipped));
  constexpr std::size_t kWakeUp = 0, kCommand = 4, kRelease = 5;
  for (const std::size_t i : {kWakeUp, kCommand, kRelease}) {
    if (statistics.series[i].count > 0) page.add(histogram(kTimingSteps[i], statistics.series[i]));
  }
}

void add_events(const recording::Recording& recording, Page& page) {
  page.section("Events");
  std::vector<Cells> rows;
  each(recording, "lss/event", [&](const Message& message, const Fields& fields) {
    constexpr const char* kLooks[] = {"", "warn", "bad", "bad"};
    const auto severity = static_cast<std::size_t>(fields.whole("severity"));
    rows.push_back({{at_text(recording, message), fields.text("text")},
                    severity < std::size(kLooks) ? kLooks[severity] : ""});
  });
  if (rows.empty()) return page.note("None was recorded.");
  put_table(page, {"s", "event"}, std::move(rows));
}

void add_commands(const recording::Recording& recording, const Vehicle* vehicle, Page& page) {
  page.section("Commands");
  // The last answer to each.
  std::map<std::pair<std::string, std::int64_t>, std::string> outcomes;
  each(recording, "lss/command_ack", [&](const Message&, const Fields& fields) {
    std::string phase = fields.text("phase");
    if (const std::size_t cut = phase.find('_'); cut != std::string::npos)
      phase = phase.substr(cut + 1);
    for (char& c : phase) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    const std::string text = fields.text("text");
    outcomes[{fields.text("source"), fields.whole("seq")}] = text.empty() ? phase : text;
  });
  std::vector<Cells> rows;
  each(recording, "lss/command", [&](const Message& message, const Fields& fields) {
    const auto kind = static_cast<std::uint16_t>(fields.whole("kind"));
    Invocation invocation;
    if (vehicle != nullptr) {
      for (const CommandInfo* info : commands_of(*vehicle)) {
        if (info->kind == kind) invocation.info = info;
      }
    }
    for (std::size_t i = 0; i < kMaxParameters; ++i)
      invocation.parameter[i] = fields.number(fmt::format("parameter[{}]", i).c_str());
    const bool dry = (static_cast<unsigned>(fields.whole("flags")) & kFlagDryRun) != 0;
    if (dry && kind == static_cast<std::uint16_t>(CommandKind::request_data))
      return;  // a request without effect, which tests the connection
    const std::string name =
        invocation.info != nullptr ? describe(invocation) : fmt::format("number {}", kind);
    const auto outcome = outcomes.find({fields.text("source"), fields.whole("seq")});
    const std::string came = outcome == outcomes.end() ? "no answer was recorded" : outcome->second;
    const bool bad = came.starts_with("rejected") || came.starts_with("failed");
    rows.push_back({{at_text(recording, message), name + (dry ? " (dry run)" : ""),
                     fields.text("source"), came},
                    bad ? "bad" : ""});
  });
  if (rows.empty()) return page.note("None was recorded.");
  put_table(page, {"s", "command", "source", "outcome"}, std::move(rows));
}

void add_topics(const recording::Recording& recording, Page& page) {
  page.section("Recorded",
               "Missing: by the counter in the messages; frames that the daemon itself "
               "skipped are among them.");
  std::vector<Cells> rows;
  for (const recording::Topic& topic : recording.topics()) {
    rows.push_back({{topic.name, topic.type_name, fmt::format("{}", topic.span.messages),
                     fmt::format("{}", topic.gaps)},
                    topic.gaps > 0 ? "warn" : ""});
  }
  page.table({"topic", "type", "messages", "missing"}, rows);
}

}  // namespace lss::cli::report
