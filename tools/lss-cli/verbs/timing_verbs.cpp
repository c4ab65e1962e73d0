// timing: how punctual the frames are.

#include <fmt/format.h>

#include <cmath>

#include "idl/timing_statistics.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/show/timing.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/timing_files.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

constexpr double kWait_s = 3;  // for the daemon's message every second
constexpr std::size_t kRows = 16, kBarWidth = 40;

// The daemon's statistics since its start or the last reset.
TimingStatistics collected(Session& session) {
  session.link().open_timing_statistics();
  const Clock::time_point until = Clock::now() + seconds(kWait_s);
  while (Clock::now() < until) {
    if (const std::optional<lss_TimingStatistics> s = session.link().next_timing_statistics())
      return to_statistics(*s);
    session.pump(until);
  }
  throw Failure(ExitCode::timed_out, "no timing came", "does the daemon run? see: lss-cli status");
}

// The statistics of this period.
TimingStatistics listened(Session& session, double for_s) {
  session.link().open_timing();
  TimingCollector<lss_Timing> collector;
  collector.set_period(session.status().period_ns);
  const Clock::time_point end = Clock::now() + seconds(for_s);
  session.set_progress([&] { return fmt::format("{} frames", collector.statistics().frames); });
  try {
    while (Clock::now() < end) {
      session.pump(end);
      while (const std::optional<lss_Timing> timing = session.link().next_timing())
        collector.add(*timing);
    }
  } catch (const Interrupted&) {  // the data until now is shown
  }
  session.set_progress(nullptr);
  if (collector.statistics().frames == 0) {
    throw Failure(ExitCode::timed_out, "no timing came",
                  "is it on shared memory only? see: lss-cli status");
  }
  return collector.statistics();
}

// One row for each bucket, or for several when there are many. Bars are logarithmic, because rare
// values matter.
std::string histogram(const TimingSeries& series, const Style& style) {
  const std::size_t first = TimingSeries::index(series.min_ns);
  const std::size_t last = TimingSeries::index(series.max_ns);
  const std::size_t step = (last - first) / kRows + 1;
  const double longest = std::log2(1.0 + static_cast<double>(series.count));
  std::string text;
  for (std::size_t i = first; i <= last; i += step) {
    const std::size_t end = std::min(i + step, TimingSeries::kBuckets);
    std::uint64_t count = 0;
    for (std::size_t k = i; k < end; ++k) count += series.bucket[k];
    const double length = std::log2(1.0 + static_cast<double>(count)) / longest * kBarWidth;
    std::string bar;
    for (std::size_t k = 0; k < static_cast<std::size_t>(std::lround(length)); ++k) bar += "▇";
    text += fmt::format(
        "{:>9.1f} .. {:>9.1f} us {:>10}  {}\n", us(static_cast<double>(TimingSeries::lower_ns(i))),
        us(static_cast<double>(TimingSeries::lower_ns(end))), count, style.good(bar));
  }
  return text;
}

std::string table(const TimingStatistics& all, const Style& style) {
  std::string text =
      style.dim(fmt::format("{:<10} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}  us", "", "mean",
                            "sigma", "min", "p50", "p99", "p99.9", "max")) +
      "\n";
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    const TimingSeries& s = all.series[i];
    if (s.count == 0) continue;
    text += fmt::format(
        "{:<10} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f} {:>9.1f}  {}\n",
        kTimingSteps[i].name, us(s.mean_ns()), us(s.sigma_ns()), us(static_cast<double>(s.min_ns)),
        us(s.quantile_ns(0.5)), us(s.quantile_ns(0.99)), us(s.quantile_ns(0.999)),
        us(static_cast<double>(s.max_ns)), style.dim(kTimingSteps[i].what));
  }
  return text;
}

std::string summary(const TimingStatistics& all, const Style& style) {
  if (all.frames == 0) return "no frame since the reset\n";
  const TimingSeries& command = all.series[4];
  const std::string missed = fmt::format(
      "missed     {} of {} commands late, {} repeated; {} frames skipped, {} begun without the "
      "sensor\n",
      all.overruns, all.frames, all.repeated, all.skipped, all.held);
  return fmt::format(
             "margin     {:.1f} us in the mean, {:.1f} at p99.9, {:.1f} at least, of {:.1f}\n",
             us(all.margin_ns(command.mean_ns())), us(all.margin_ns(command.quantile_ns(0.999))),
             us(all.margin_ns(static_cast<double>(command.max_ns))),
             us(static_cast<double>(all.offset_ns))) +
         (all.overruns == 0 ? missed : style.warning(missed));
}

struct TimingWanted {
  std::string what;  // trace, certify, or nothing
  std::vector<std::string> paths;
  LogWanted trace;
  CertifyWanted certify;
  std::optional<double> for_s;
  std::string histogram = "command";
  bool reset = false;
};

ExitCode run_timing(Context& context, const TimingWanted& wanted) {
  Session& session = context.session();
  if (wanted.reset) {
    session.complete({&common_command(CommandKind::reset_timing), {}});
    return ExitCode::completed;
  }
  const TimingStatistics all = wanted.for_s ? listened(session, *wanted.for_s) : collected(session);
  context.output.document(timing_json(all));
  const Style& style = context.output.style();
  std::size_t step = 0;
  while (kTimingSteps[step].name != wanted.histogram) ++step;
  context.output.print(fmt::format(
      "{} frames of {:.1f} ms in {}, {}\n", all.frames, static_cast<double>(all.period_ns) * 1e-6,
      format_duration(static_cast<double>(all.until_ns - all.since_ns) * 1e-9),
      wanted.for_s ? "as listened to" : "since the start or the last --reset"));
  context.output.print(table(all, style) + summary(all, style));
  if (all.series[step].count != 0) {
    context.output.print(
        fmt::format("\n{}: {}\n", style.bold(wanted.histogram), kTimingSteps[step].what) +
        histogram(all.series[step], style));
  }
  return ExitCode::completed;
}

void check(const TimingWanted& wanted) {
  if (wanted.what == "trace" && wanted.paths.size() != 1)
    throw Failure(ExitCode::usage, "timing trace: of which recording?",
                  "timing trace FILE.lssrec, one");
}

ExitCode run(Context& context, TimingWanted& wanted) {
  if (wanted.what == "trace") {
    wanted.trace.path = wanted.paths.front();
    return timing_trace(context, wanted.trace);
  }
  if (wanted.what == "certify") {
    wanted.certify.recordings = wanted.paths;
    wanted.certify.out = wanted.trace.out;
    return timing_certify(context, wanted.certify);
  }
  return run_timing(context, wanted);
}

}  // namespace

void add_timing_verbs(Grammar& grammar) {
  CLI::App& timing = grammar.verb("timing", "how punctual the frames are; trace FILE; certify", R"(
  lss-cli timing
  lss-cli timing --histogram wake-up
  lss-cli timing --reset
  lss-cli --json timing --for 1min
  lss-cli timing trace run.lssrec --out trace.json    for ui.perfetto.dev
  lss-cli timing certify --config /etc/lss/zebro.toml /var/lib/lss/*.lssrec
)");
  auto wanted = std::make_shared<TimingWanted>();
  std::vector<std::string> names;
  for (const TimingStep& step : kTimingSteps) names.emplace_back(step.name);
  timing
      .add_option("what", wanted->what,
                  "trace: frames and threads of a flight recording, as JSON for Perfetto; "
                  "certify: a bound on the lateness of orders on this machine")
      ->check(CLI::IsMember({"trace", "certify"}));
  timing.add_option("path", wanted->paths,
                    "trace: the flight recording, *.lssrec; certify: those whose longest frame "
                    "is counted");
  const auto for_s =
      add_duration(timing, "--for", "listen so long, instead of what the daemon collected");
  timing.add_option("--histogram", wanted->histogram, "of which step")
      ->check(CLI::IsMember(names))
      ->capture_default_str();
  timing.add_flag("--reset", wanted->reset, "resets the daemon's statistics; shows nothing")
      ->excludes("--for", "--histogram");
  add_span(timing, wanted->trace.filter, "trace: since the first frame");
  timing.add_option("-o,--out", wanted->trace.out,
                    "trace: the file, else stdout; certify: the certificate, else the file that "
                    "the configuration names");
  CertifyWanted& certify = wanted->certify;
  timing.add_option("--config", certify.config, "certify: the configuration of lssd");
  timing.add_option("--seconds", certify.seconds, "certify: how long the kernel is measured")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  timing
      .add_option("--latency-us", certify.latency_us,
                  "certify: the kernel's scheduling latency, when it is known, instead of "
                  "measuring")
      ->check(CLI::Range(0.1, 1e6));
  timing
      .add_option("--frames", certify.frames,
                  "certify: so many of the longest frames of each recording are counted")
      ->check(CLI::Range(1, 1'000'000))
      ->capture_default_str();
  timing.add_option("--lssd", certify.lssd, "certify: the daemon, when it is not beside lss-cli");
  grammar.values(timing, "", {"trace", "certify"});
  grammar.on(
      timing,
      [wanted, for_s](Context& context) {
        wanted->for_s = *for_s;
        return run(context, *wanted);
      },
      [wanted] { check(*wanted); });
}

}  // namespace lss::cli
