// events and timing: what happened, and how punctually.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "tools/lss-cli/status.h"
#include "tools/lss-cli/verbs.h"

namespace lss::cli {
namespace {

constexpr double kHistory_s = 5;  // for the old events, on a busy machine

// Of events without a hole the newest is the last that the daemon tells of, and the oldest the
// first that it keeps.
bool is_whole(const std::map<std::uint64_t, lss_Event>& events, std::uint64_t newest) {
  if (newest == 0) return true;
  if (events.empty() || events.rbegin()->first < newest) return false;
  const std::uint64_t last = events.rbegin()->first;
  return events.size() >= std::min<std::uint64_t>(last, dds::kEventDepth);
}

std::vector<lss_Event> history(Session& session, Output& output) {
  std::map<std::uint64_t, lss_Event> events;
  session.link().open_events();
  const std::uint64_t newest = session.status().events;
  const Clock::time_point until = Clock::now() + seconds(kHistory_s);
  while (!is_whole(events, newest)) {
    if (Clock::now() >= until) {
      output.note(
          fmt::format("{} of {} events came within {} s", events.size(), newest, kHistory_s));
      break;
    }
    session.pump(until);
    while (const std::optional<lss_Event> event = session.link().next_event())
      events.insert({event->index, *event});
  }
  std::vector<lss_Event> list;
  for (const auto& [index, event] : events) list.push_back(event);
  return list;
}

ExitCode run_events(Context& context, bool follow, std::size_t last) {
  Session& session = context.session();
  std::vector<lss_Event> list = history(session, context.output);
  nlohmann::json all = nlohmann::json::array();
  std::uint64_t newest = 0;
  const auto show = [&](const lss_Event& event) {
    if (newest != 0 && event.index > newest + 1) {
      context.output.note(fmt::format("{} events were lost", event.index - newest - 1));
    }
    newest = event.index;
    const nlohmann::json json = event_json(session.vehicle(), event);
    context.output.print(event_line(event, context.output.style()));
    context.output.record(json);
    if (!context.output.stream()) all.push_back(json);
  };
  if (last > 0 && list.size() > last)
    list.erase(list.begin(), list.end() - static_cast<std::ptrdiff_t>(last));
  std::ranges::for_each(list, show);
  try {
    while (follow) {
      session.pump(Clock::now() + seconds(1));
      while (const std::optional<lss_Event> event = session.link().next_event()) show(*event);
    }
  } catch (const Interrupted&) {
  }
  if (!context.output.stream()) context.output.document({{"events", std::move(all)}});
  return ExitCode::completed;
}

struct Series {
  const char* name;
  const char* what;
  std::vector<double> us;
};

double quantile(const std::vector<double>& sorted, double q) {
  return sorted[std::min(sorted.size() - 1,
                         static_cast<std::size_t>(q * static_cast<double>(sorted.size())))];
}

struct Statistics {
  double mean = 0, sigma = 0, p999 = 0, min = 0, max = 0;
};

Statistics statistics(std::vector<double> us) {
  std::ranges::sort(us);
  const auto n = static_cast<double>(us.size());
  Statistics s;
  s.mean = std::accumulate(us.begin(), us.end(), 0.0) / n;
  const double squares = std::accumulate(us.begin(), us.end(), 0.0, [&](double sum, double value) {
    return sum + (value - s.mean) * (value - s.mean);
  });
  s.sigma = std::sqrt(squares / n);
  s.p999 = quantile(us, 0.999);
  s.min = us.front();
  s.max = us.back();
  return s;
}

// Times of the frames, by the points of lss/timing.
class TimingTable {
 public:
  void add(const lss_Timing& t) {
    const auto us = [](std::int64_t ns) { return static_cast<double>(ns) / 1000; };
    series_[0].us.push_back(us(t.woken_ns - t.boundary_ns));
    series_[1].us.push_back(us(t.read_ns - t.woken_ns));
    series_[2].us.push_back(us(t.navigated_ns - t.read_ns));
    series_[3].us.push_back(us(t.ready_ns - t.navigated_ns));
    series_[4].us.push_back(us(t.margin_ns));
    if (before_.frame + 1 == t.frame && t.released_ns > 0) {
      series_[5].us.push_back(us(t.released_ns - before_.boundary_ns - before_.offset_ns));
    }
    if (frames_ == 0) first_ = t;
    before_ = t;
    ++frames_;
  }
  std::size_t frames() const { return frames_; }

  std::string text(const Style& style) const {
    std::string text = style.dim(fmt::format("{:<10} {:>9} {:>9} {:>9} {:>9} {:>9}  us", "", "mean",
                                             "sigma", "p99.9", "min", "max")) +
                       "\n";
    for (const Series& series : series_) {
      if (series.us.empty()) continue;
      const Statistics s = statistics(series.us);
      text += fmt::format("{:<10} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f}  {}\n", series.name,
                          s.mean, s.sigma, s.p999, s.min, s.max, style.dim(series.what));
    }
    return text +
           fmt::format("{} frames, {} overruns, {} skipped, {} commands repeated meanwhile\n",
                       frames_, before_.overruns - first_.overruns,
                       before_.frames_skipped - first_.frames_skipped,
                       before_.commands_repeated - first_.commands_repeated);
  }

  nlohmann::json json() const {
    nlohmann::json points = nlohmann::json::object();
    for (const Series& series : series_) {
      if (series.us.empty()) continue;
      const Statistics s = statistics(series.us);
      points[series.name] = {{"mean_us", s.mean},
                             {"sigma_us", s.sigma},
                             {"p999_us", s.p999},
                             {"min_us", s.min},
                             {"max_us", s.max}};
    }
    return {{"frames", frames_},
            {"overruns", before_.overruns - first_.overruns},
            {"frames_skipped", before_.frames_skipped - first_.frames_skipped},
            {"commands_repeated", before_.commands_repeated - first_.commands_repeated},
            {"points", std::move(points)}};
  }

 private:
  std::array<Series, 6> series_{{{"wake-up", "frame boundary to the thread running", {}},
                                 {"read", "samples and requests taken", {}},
                                 {"navigate", "supervised and navigated", {}},
                                 {"control", "command computed and put down", {}},
                                 {"margin", "command ready before its release", {}},
                                 {"release", "command given out after its time", {}}}};
  lss_Timing first_{}, before_{};
  std::size_t frames_ = 0;
};

ExitCode run_timing(Context& context, double for_s) {
  Session& session = context.session();
  session.link().open_timing();
  TimingTable table;
  const Clock::time_point end = Clock::now() + seconds(for_s);
  session.set_progress([&] { return fmt::format("{} frames", table.frames()); });
  try {
    while (Clock::now() < end) {
      session.pump(end);
      while (const std::optional<lss_Timing> timing = session.link().next_timing())
        table.add(*timing);
    }
  } catch (const Interrupted&) {  // what came until now is shown
  }
  session.set_progress(nullptr);
  if (table.frames() == 0) {
    throw Failure(ExitCode::timed_out, "no timing came",
                  "is it on shared memory only? see: lss-cli status");
  }
  context.output.document(table.json());
  context.output.print(table.text(context.output.style()));
  return ExitCode::completed;
}

}  // namespace

void add_report_verbs(Grammar& grammar) {
  CLI::App& events =
      grammar.verb("events", "what happened: the last 256 events",
                   "  lss-cli events --last 20\n  lss-cli --jsonl events --follow\n");
  auto follow = std::make_shared<bool>(false);
  auto last = std::make_shared<std::size_t>(0);
  events.add_flag("-f,--follow", *follow, "go on until Ctrl-C");
  events.add_option("--last", *last, "only so many of the old ones");
  grammar.on(events,
             [follow, last](Context& context) { return run_events(context, *follow, *last); });

  CLI::App& timing = grammar.verb("timing", "how punctual the frames are",
                                  "  lss-cli timing\n  lss-cli --json timing --for 1min\n");
  const auto for_s = add_duration(timing, "--for", "how long to listen (default 2s)");
  grammar.on(timing, [for_s](Context& context) { return run_timing(context, for_s->value_or(2)); });
}

}  // namespace lss::cli
