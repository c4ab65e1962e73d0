#include "tests/campaign/report.h"

#include <fmt/format.h>

#include <algorithm>

namespace lss::campaign {

void Tally::add(const Tally& other) {
  simulated_s += other.simulated_s;
  frames += other.frames;
  faults += other.faults;
  commands += other.commands;
  rejected += other.rejected;
  stops += other.stops;
  slowest_rest_s = std::max(slowest_rest_s, other.slowest_rest_s);
  slowest_cut_rest_s = std::max(slowest_cut_rest_s, other.slowest_cut_rest_s);
  slowest_idle_s = std::max(slowest_idle_s, other.slowest_idle_s);
}

void Summary::add(const Run& run) {
  Tally::add(run);
  ++runs;
  broken += run.broken.empty() ? 0u : 1u;
  if (!run.outcome.empty()) ++outcomes[run.outcome];
  for (const std::string& what : run.broken)
    complaints.push_back(fmt::format("{}: {}", run.number, what));
}

void Summary::add(const Summary& other) {
  Tally::add(other);
  runs += other.runs;
  broken += other.broken;
  cpu_s += other.cpu_s;
  for (const auto& [outcome, count] : other.outcomes) outcomes[outcome] += count;
  complaints.insert(complaints.end(), other.complaints.begin(), other.complaints.end());
}

std::string Summary::line() const {
  return fmt::format(
      "{}: all satisfied in {} of {} scenarios; {} faults, {} commands ({} rejected), {} stops, {} "
      "frames "
      "in {:.0f} s of CPU, {:.0f} times real time",
      subject.vehicle, runs - broken, runs, faults, commands, rejected, stops, frames, cpu_s,
      times_real_time());
}

std::string document(const std::vector<Summary>& summaries, const std::string& command,
                     const std::string& stamp) {
  std::string text = fmt::format(
      R"(# Fault campaigns

For reviewers of safety: random faults and commands on each vehicle.
Made by `{}`, {}; do not edit.
The number of a scenario draws one to three faults of `lss-sim faults NAME` between 8 and 25 s (half of them end again), up to
six commands with any parameters, and sometimes the loss of the operator. Then all faults are cleared, and the vehicle is
commanded to Idle and to start again. The daemon's cycle, drivers and bus masters run in virtual time (`tests/campaign/`).

Conditions of every frame:

- outside Operational no order moves the vehicle;
- soon after it left Operational the vehicle is at standstill, and stays so;
- orders are numbers in their ranges;
- every command ends exactly once: rejected, completed, failed or superseded;
- no exception, and frame numbers continue;
- in the end the vehicle returns to Idle and, unless it lies on its side, starts again.

| vehicle | operation during the faults | scenarios | all satisfied | faults | commands | of them rejected | stops to FatalError | frames | simulated | times real time, by one CPU |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|
)",
      command, stamp);
  for (const Summary& s : summaries) {
    text += fmt::format("| {} | {} | {} | **{}** | {} | {} | {} | {} | {} | {:.1f} h | {:.0f} |\n",
                        s.subject.vehicle, s.subject.begin, s.runs, s.runs - s.broken, s.faults,
                        s.commands, s.rejected, s.stops, s.frames, s.simulated_s / 3600,
                        s.times_real_time());
  }
  text +=
      "\n| vehicle | standstill is | must be within | slowest | with the bus cut or noisy | "
      "slowest | slowest return to Idle | how it ended |\n|---|---|---:|---:|---:|---:|---:|---|\n";
  for (const Summary& s : summaries) {
    std::string ended;
    for (const auto& [outcome, count] : s.outcomes)
      ended += fmt::format("{}{}: {}", ended.empty() ? "" : "; ", outcome, count);
    text += fmt::format("| {} | {} | {:g} s | {:.2f} s | {:g} s | {:.2f} s | {:.0f} s | {} |\n",
                        s.subject.vehicle, s.subject.at_rest, s.subject.rest_s, s.slowest_rest_s,
                        s.subject.cut_rest_s, s.slowest_cut_rest_s, s.slowest_idle_s,
                        ended.empty() ? "always as it should" : ended);
  }
  text += R"(
## On several computers

Each computer, or processor, runs a shard; `merge` adds up the results:

    seq 8 | xargs -P 8 -I{} lss-campaign --runs 9000 --shard {}/8 --out {}.json
    lss-campaign merge *.json --markdown campaign.md

A shard that is missing, comes twice, or is of another campaign or commit is refused. Searched scenarios:
[fuzzing.md](fuzzing.md#scenarios-that-are-searched).
)";
  for (const Summary& s : summaries) {
    if (s.complaints.empty()) continue;
    text += fmt::format("\n## Violations: {}\n", s.subject.vehicle);
    for (const std::string& what : s.complaints) text += "- scenario " + what + "\n";
  }
  return text;
}

}  // namespace lss::campaign
