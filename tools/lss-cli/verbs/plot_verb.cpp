// plot: signals of a recording over time, as a picture.

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "idl/units.h"
#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/page.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/recording_verbs.h"

namespace lss::cli {
namespace {

struct PlotWanted {
  std::string path, out;
  std::vector<std::string> signals;
  recording::Filter filter;
};

struct Signal {
  std::string unit;
  report::Line line;
};

// The topic of a signal and the pattern of its column: "timing.margin_ns", "modules[*].current_A"
// of the telemetry.
struct Place {
  std::string topic, pattern;
};

bool has(const recording::Topic& topic, std::string_view pattern) {
  return topic.layout != nullptr &&
         std::ranges::any_of(topic.layout->columns(), [&](const recording::Column& column) {
           return column.text_size == 0 && recording::matches(pattern, column.name);
         });
}

Place place(const recording::Recording& recording, const std::string& signal) {
  for (const recording::Topic& topic : recording.topics()) {
    if (recording::names("telemetry", topic.name) && has(topic, signal))
      return {topic.name, signal};
  }
  std::vector<std::string> known;
  for (const recording::Topic& topic : recording.topics()) {
    if (topic.layout == nullptr) continue;
    const bool telemetry = recording::names("telemetry", topic.name);
    for (const recording::Column& column : topic.layout->columns())
      known.push_back((telemetry ? "" : topic.name.substr(topic.name.find('/') + 1) + ".") +
                      column.name);
    const std::size_t dot = signal.find('.');
    if (dot != std::string::npos && recording::names(signal.substr(0, dot), topic.name) &&
        has(topic, signal.substr(dot + 1))) {
      return {topic.name, signal.substr(dot + 1)};
    }
  }
  const std::string guess = did_you_mean(signal, known);
  throw Failure(ExitCode::unknown_name, fmt::format("there is no signal '{}' in it", signal),
                guess.empty() ? "name numbers of the telemetry, as distance_m or "
                                "'modules[*].current_A', or of another topic, as timing.margin_ns"
                              : guess);
}

std::vector<Signal> read_signals(const recording::Recording& recording, const PlotWanted& wanted) {
  std::vector<Signal> signals;
  for (const std::string& name : wanted.signals) {
    const Place at = place(recording, name);
    const report::Table table(recording, at.topic, {at.pattern}, wanted.filter);
    for (const std::string& column : table.names())
      signals.push_back({std::string(unit_of(column)), report::line_of(table, column, column, 0)});
  }
  return signals;
}

// Of a flight recording: fields of its records.
std::vector<Signal> read_signals(recording::Flight& flight, const PlotWanted& wanted) {
  recording::RecordLayout& layout = flight.layout();
  layout.choose(wanted.signals);
  const recording::Part part{.from_s = wanted.filter.from_s, .until_s = wanted.filter.until_s};
  flight.each(part, [&](const recording::Flight::Frame& frame) { layout.look(frame.record); });
  const auto columns = layout.columns();
  std::vector<Signal> signals;
  for (const auto& column : columns)
    signals.push_back({std::string(unit_of(column.name)), {column.name, {}, {}}});
  std::vector<nlohmann::ordered_json> values;
  flight.each(part, [&](const recording::Flight::Frame& frame) {
    layout.values(frame.record, values);
    for (std::size_t i = 0; i < signals.size(); ++i) {
      const auto& value = values[i];
      if (!value.is_number() && !value.is_boolean()) continue;
      signals[i].line.x.push_back(frame.t_s);
      signals[i].line.y.push_back(value.is_boolean() ? (value.get<bool>() ? 1 : 0)
                                                     : value.get<double>());
    }
  });
  std::erase_if(signals, [](const Signal& signal) { return signal.line.x.empty(); });
  return signals;
}

std::vector<Signal> read_signals(const PlotWanted& wanted) {
  std::vector<Signal> signals;
  if (recording::is_flight(wanted.path)) {
    recording::Flight flight(wanted.path);
    signals = read_signals(flight, wanted);
  } else {
    signals = read_signals(*recording::open(wanted.path), wanted);
  }
  constexpr std::size_t kMost = 60;
  if (signals.size() > kMost) {
    throw Failure(ExitCode::usage,
                  fmt::format("{} signals are too many for one picture", signals.size()),
                  fmt::format("name at most {}", kMost));
  }
  const bool any = std::ranges::any_of(signals, [](const Signal& s) { return !s.line.x.empty(); });
  if (!any) {
    throw Failure(ExitCode::usage, "there is nothing of that in this time",
                  "see the times and topics with: lss-cli log list " + wanted.path);
  }
  return signals;
}

// Signals of one unit share a chart.
std::vector<report::LineChart> charts_of(std::vector<Signal> signals) {
  std::vector<report::LineChart> charts;
  for (auto& [unit, line] : signals) {
    const std::string label = unit.empty() ? "(no unit)" : unit;
    auto chart = std::ranges::find(charts, label, &report::LineChart::y_label);
    if (chart == charts.end()) chart = charts.insert(chart, report::over_time("", label));
    line.colour = static_cast<int>(chart->lines.size());
    chart->lines.push_back(std::move(line));
  }
  return charts;
}

void write_png(const std::string& svg, const std::string& out) {
  std::string quoted;  // within single quotes of the shell
  for (const char c : out) quoted += c == '\'' ? "'\\''" : std::string(1, c);
  std::signal(SIGPIPE, SIG_IGN);  // rsvg-convert is not installed
  std::FILE* pipe = popen(("rsvg-convert -o '" + quoted + "'").c_str(), "w");
  if (pipe == nullptr) throw Failure(ExitCode::internal, "cannot start rsvg-convert");
  const bool all = std::fwrite(svg.data(), 1, svg.size(), pipe) == svg.size();
  const int status = pclose(pipe);
  constexpr int kNotFound = 127;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound) {
    throw Failure(ExitCode::failed, "rsvg-convert, which makes a PNG, is not installed",
                  "sudo apt-get install librsvg2-bin, or draw an SVG: --out FILE.svg");
  }
  if (!all || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Failure(ExitCode::failed, "rsvg-convert failed; it says why above");
}

ExitCode plot(Context& context, PlotWanted wanted) {
  if (wanted.out.empty()) wanted.out = std::filesystem::path(wanted.path).stem().string() + ".svg";
  if (!wanted.out.ends_with(".svg") && !wanted.out.ends_with(".png")) {
    throw Failure(ExitCode::usage, fmt::format("do not know how to draw {}", wanted.out),
                  "end its name in .svg or .png");
  }
  std::vector<Signal> signals = read_signals(wanted);
  nlohmann::json names = nlohmann::json::array();
  for (const Signal& signal : signals) names.push_back(signal.line.name);
  const std::string svg = report::picture(std::filesystem::path(wanted.path).filename().string(),
                                          charts_of(std::move(signals)));
  if (wanted.out.ends_with(".png")) {
    write_png(svg, wanted.out);
  } else {
    write_file(svg, wanted.out);
  }
  context.output.print(fmt::format("{}: {} signals\n", wanted.out, names.size()));
  context.output.document({{"out", wanted.out}, {"signals", std::move(names)}});
  return ExitCode::completed;
}

}  // namespace

void add_plot_verb(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub = grammar.verb("plot", "signals of a recording over time, as SVG or PNG", R"(
  lss-cli plot run.mcap --signals distance_m,speed_m_s
  lss-cli plot run.mcap --signals 'modules[*].current_A,timing.margin_ns' --out run.png
  lss-cli plot run.lssrec --signals 'modules[*].set_point_rad,timing.margin_ns'
)");
  auto wanted = std::make_shared<PlotWanted>();
  sub.add_option("file", wanted->path, "a recording")->required();
  sub.add_option("--signals", wanted->signals,
                 "divided by commas: columns of the telemetry, or TOPIC.COLUMN, of a flight "
                 "recording any fields; * is anything")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->required();
  sub.add_option("-o,--out", wanted->out,
                 "FILE.svg or FILE.png; without it the name of the recording, here");
  add_span(sub, wanted->filter, "since the first message or frame");
  grammar.on(sub, [wanted](Context& context) { return plot(context, *wanted); });
}

}  // namespace lss::cli
