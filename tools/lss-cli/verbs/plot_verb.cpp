// plot: signals of a recording over time, by gnuplot.

#include <fmt/format.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "idl/units.h"
#include "tools/lss-cli/recording/flight.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/report/series.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/show/units.h"
#include "tools/lss-cli/verbs/recording_verbs.h"

namespace lss::cli {
namespace {

constexpr int kWidth = 960, kPanelHeight = 300, kHead = 60;

struct PlotWanted {
  std::string path, out;
  std::vector<std::string> signals;
  recording::Filter filter;
};

struct Signal {
  std::string name, unit;
  std::vector<double> t_s, value;
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
      signals.push_back({column, std::string(unit_of(column)), table.t_s(), table[column]});
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
    signals.push_back({column.name, std::string(unit_of(column.name)), {}, {}});
  std::vector<nlohmann::ordered_json> values;
  flight.each(part, [&](const recording::Flight::Frame& frame) {
    layout.values(frame.record, values);
    for (std::size_t i = 0; i < signals.size(); ++i) {
      const auto& value = values[i];
      if (!value.is_number() && !value.is_boolean()) continue;
      signals[i].t_s.push_back(frame.t_s);
      signals[i].value.push_back(value.is_boolean() ? (value.get<bool>() ? 1 : 0)
                                                    : value.get<double>());
    }
  });
  std::erase_if(signals, [](const Signal& signal) { return signal.t_s.empty(); });
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
  const bool any = std::ranges::any_of(signals, [](const Signal& s) { return !s.t_s.empty(); });
  if (!any) {
    throw Failure(ExitCode::usage, "there is nothing of that in this time",
                  "see the times and topics with: lss-cli log list " + wanted.path);
  }
  return signals;
}

// As gnuplot reads it in single quotes.
std::string quoted(const std::string& text) {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? std::string("''") : std::string(1, c);
  return result + "'";
}

// Signals of one unit share a panel.
std::vector<std::vector<const Signal*>> panels_of(const std::vector<Signal>& signals) {
  std::vector<std::vector<const Signal*>> panels;
  for (const Signal& signal : signals) {
    const auto same = std::ranges::find_if(
        panels, [&](const auto& panel) { return panel.front()->unit == signal.unit; });
    if (same == panels.end()) {
      panels.push_back({&signal});
    } else {
      same->push_back(&signal);
    }
  }
  return panels;
}

std::string script(const std::vector<Signal>& signals, const PlotWanted& wanted,
                   const std::string& title) {
  const auto panels = panels_of(signals);
  const int height = kHead + kPanelHeight * static_cast<int>(panels.size());
  const bool png = wanted.out.ends_with(".png");
  std::string text = fmt::format("set terminal {} size {},{} font 'sans,{}' background '#ffffff'\n",
                                 png ? "pngcairo" : "svg dynamic", kWidth, height, png ? 11 : 13);
  text += fmt::format("set output {}\n", quoted(wanted.out));
  for (std::size_t i = 0; i < signals.size(); ++i) {
    text += fmt::format("$d{} << EOD\n", i);
    for (std::size_t k = 0; k < signals[i].t_s.size(); ++k) {
      if (std::isfinite(signals[i].value[k]))
        text += fmt::format("{:.6f} {}\n", signals[i].t_s[k], signals[i].value[k]);
    }
    text += "EOD\n";
  }
  text +=
      "set grid lc '#d8d8d4'\nset border 3 lc '#52514e'\nset tics nomirror\n"
      "set key outside right top Left reverse samplen 1.5 noenhanced\n"
      "set format y '%g'\nset lmargin 12\nset rmargin 34\n";
  const char* colours[] = {"#2a78d6", "#eb6834", "#1baf7a", "#eda100",
                           "#4a3aa7", "#e34948", "#008300", "#e87ba4"};
  for (std::size_t i = 0; i < std::size(colours); ++i)
    text += fmt::format("set linetype {} lc rgb '{}' lw 1.6\n", i + 1, colours[i]);
  text += fmt::format("set linetype cycle {}\n", std::size(colours));
  text +=
      fmt::format("set multiplot layout {},1 title {} noenhanced\n", panels.size(), quoted(title));
  for (const auto& panel : panels) {
    const std::string unit = panel.front()->unit;
    text += fmt::format("set ylabel {}\n", quoted(unit.empty() ? "(no unit)" : unit));
    text += fmt::format("set xlabel {}\n",
                        panel == panels.back() ? "'s since the recording began'" : "''");
    text += "plot ";
    for (const Signal* signal : panel) {
      text +=
          fmt::format("{}$d{} using 1:2 with lines title {}", signal == panel.front() ? "" : ", ",
                      signal - signals.data(), quoted(signal->name));
    }
    text += "\n";
  }
  return text + "unset multiplot\nunset output\n";
}

void run_gnuplot(const std::string& script) {
  std::FILE* pipe = popen("gnuplot", "w");
  if (pipe == nullptr) throw Failure(ExitCode::internal, "cannot start gnuplot");
  const bool all = std::fwrite(script.data(), 1, script.size(), pipe) == script.size();
  const int status = pclose(pipe);
  constexpr int kNotFound = 127;
  if (WIFEXITED(status) && WEXITSTATUS(status) == kNotFound) {
    throw Failure(ExitCode::failed, "gnuplot is not installed", "sudo apt-get install gnuplot-nox");
  }
  if (!all || !WIFEXITED(status) || WEXITSTATUS(status) != 0)
    throw Failure(ExitCode::failed, "gnuplot failed; it says why above");
}

ExitCode plot(Context& context, PlotWanted wanted) {
  if (wanted.out.empty()) wanted.out = std::filesystem::path(wanted.path).stem().string() + ".svg";
  if (!wanted.out.ends_with(".svg") && !wanted.out.ends_with(".png")) {
    throw Failure(ExitCode::usage, fmt::format("do not know how to draw {}", wanted.out),
                  "end its name in .svg or .png");
  }
  const std::vector<Signal> signals = read_signals(wanted);
  std::signal(SIGPIPE, SIG_IGN);  // gnuplot is not installed
  run_gnuplot(script(signals, wanted, std::filesystem::path(wanted.path).filename().string()));
  context.output.print(fmt::format("{}: {} signals\n", wanted.out, signals.size()));
  nlohmann::json names = nlohmann::json::array();
  for (const Signal& signal : signals) names.push_back(signal.name);
  context.output.document({{"out", wanted.out}, {"signals", std::move(names)}});
  return ExitCode::completed;
}

}  // namespace

void add_plot_verb(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub = grammar.verb(
      "plot", "signals of a recording over time, as SVG or PNG",
      "  lss-cli plot run.mcap --signals distance_m,speed_m_s\n"
      "  lss-cli plot run.mcap --signals 'modules[*].current_A,timing.margin_ns' --out run.png\n"
      "  lss-cli plot run.lssrec --signals 'modules[*].set_point_rad,timing.margin_ns'\n");
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
