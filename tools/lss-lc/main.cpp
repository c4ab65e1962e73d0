// lss-lc: the locomotion controller held against its requirements, state by state.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "daemon/vehicles/zebro_modes.h"
#include "tools/lss-lc/diagram.h"
#include "tools/lss-lc/explorer.h"
#include "tools/lss-lc/mutations.h"
#include "tools/lss-lc/spin.h"
#include "tools/lss-lc/zebro.h"

namespace {

using namespace lss;

constexpr std::uint16_t kTwoModules = 0x41;  // a leg and the panel, for mutations

std::string box(const lc::ControllerState& s) {
  return s.mode != 0 ? zebro::kModeNames[s.mode] : kStateNames[static_cast<std::size_t>(s.state)];
}

void print_trace(const lc::Violation& violation) {
  fmt::print("broken: {}\n", violation.property);
  const lc::Model model = zebro::model_of(zebro::kTable);
  lc::ControllerState state = model.begin;
  fmt::print("   0  {:<28} {}\n", "at boot", zebro::text(state));
  int number = 0;
  for (const lc::Happening h : violation.trace) {
    state = lc::step(zebro::kTable, state, h.event, h.subject).next;
    fmt::print("{:>4}  {:<28} {}\n", ++number, zebro::text(zebro::kTable, h), zebro::text(state));
  }
}

int explore(bool as_json, unsigned threads) {
  const lc::Model model = zebro::model_of(zebro::kTable);
  const lc::Exploration e = lc::explore(model, {.threads = threads});
  std::size_t unused = 0;
  for (const std::uint64_t count : e.row) unused += count == 0 ? 1 : 0;
  const double per_state = static_cast<double>(e.octets) / static_cast<double>(e.states);
  if (as_json) {
    const nlohmann::json document{{"states", e.states},
                                  {"transitions", e.transitions},
                                  {"taken", e.taken},
                                  {"depth", e.depth},
                                  {"octets_per_state", per_state},
                                  {"seconds", e.seconds},
                                  {"rows", e.row.size()},
                                  {"rows_never_taken", unused},
                                  {"complete", e.complete},
                                  {"broken", e.violation ? e.violation->property : ""}};
    fmt::print("{}\n", document.dump(2));
  } else {
    fmt::print("states           {}\n", e.states);
    fmt::print("transitions      {} ({} events in every state), {} taken by a row\n", e.transitions,
               model.happenings.size(), e.taken);
    fmt::print("furthest state   {} events from boot\n", e.depth);
    fmt::print("rows             {}, {} never taken\n", e.row.size(), unused);
    fmt::print("properties       {} of states, {} of steps, {} of events, {} of the way back\n",
               model.states.each.size(), model.steps.each.size(), model.contracts.size(),
               model.returns.size());
    fmt::print("time, memory     {:.2f} s, {:.1f} octets a state\n", e.seconds, per_state);
    if (e.violation) print_trace(*e.violation);
    fmt::print("{}\n", e.complete && unused == 0 ? "all hold" : "NOT all hold");
  }
  return e.complete && unused == 0 ? 0 : 1;
}

int mutate() {
  const lc::Mutations m = lc::mutate(
      zebro::kTable, [](const lc::Table& table) { return zebro::model_of(table, kTwoModules); },
      static_cast<std::uint8_t>(std::size(zebro::kModeNames)), 8);
  for (const std::string& survivor : m.survivors) fmt::print("not noticed: {}\n", survivor);
  fmt::print("{} changes of the table: {} noticed, {} that change no reachable step, {:.1f} s\n",
             m.count, m.caught, m.equivalent, m.seconds);
  return m.survivors.empty() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli("lss-lc: the locomotion controller of Lunar Zebro, explored state by state");
  bool as_json = false;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  auto* exploring = cli.add_subcommand(
      "explore", "visit every reachable state, hold all properties against every step");
  exploring->add_flag("--json", as_json, "for a program");
  exploring->add_option("--threads", threads, "how many share the work; the result is the same")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  auto* mutating = cli.add_subcommand(
      "mutate", "break the table, one transition at a time: do the properties notice?");
  auto* spin =
      cli.add_subcommand("promela", "the model for SPIN (build target lss-lc-spin runs it)");
  auto* drawing = cli.add_subcommand("diagram", "states and modes for Graphviz");
  cli.require_subcommand(1);
  cli.footer("Examples:\n  lss-lc explore\n  lss-lc diagram | dot -Tsvg > lc.svg");
  CLI11_PARSE(cli, argc, argv);
  if (exploring->parsed()) return explore(as_json, threads);
  if (mutating->parsed()) return mutate();
  const auto name = [](const lc::Table& table, lc::Happening h) { return zebro::text(table, h); };
  if (spin->parsed()) fmt::print("{}", lc::promela(zebro::model_of(zebro::kTable), name));
  if (drawing->parsed())
    fmt::print("{}", lc::diagram(zebro::model_of(zebro::kTable, kTwoModules), box, name));
  return 0;
}
