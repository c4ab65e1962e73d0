// lss-lc: checks the locomotion controllers against their requirements, state by state.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <nlohmann/json.hpp>
#include <thread>

#include "tools/lss-lc/diagram.h"
#include "tools/lss-lc/mutations.h"
#include "tools/lss-lc/spin.h"
#include "tools/lss-lc/vehicle.h"

namespace {

using namespace lss;

void print_trace(const lc::Verified& vehicle, const lc::Model& model,
                 const lc::Violation& violation) {
  fmt::print("broken: {}\n", violation.property);
  lc::ControllerState state = model.begin;
  fmt::print("   0  {:<28} {}\n", "at boot", lc::text(vehicle, state));
  int number = 0;
  for (const lc::Happening h : violation.trace) {
    state = lc::stand_in(model, lc::step(*model.table, state, h.event, h.subject).next);
    fmt::print("{:>4}  {:<28} {}\n", ++number, lc::text(vehicle, h), lc::text(vehicle, state));
  }
}

double bytes_per_state(const lc::Exploration& e) {
  return static_cast<double>(e.bytes) / static_cast<double>(e.states);
}

nlohmann::json json(const lc::Verified& vehicle, const lc::Exploration& e, std::size_t unused) {
  return {{"vehicle", vehicle.name},
          {"states", e.states},
          {"transitions", e.transitions},
          {"taken", e.taken},
          {"depth", e.depth},
          {"bytes_per_state", bytes_per_state(e)},
          {"seconds", e.seconds},
          {"rows", e.row.size()},
          {"rows_never_taken", unused},
          {"complete", e.complete},
          {"broken", e.violation ? e.violation->property : ""}};
}

void print(const lc::Verified& vehicle, const lc::Model& model, const lc::Exploration& e,
           std::size_t unused) {
  fmt::print("{}\n", vehicle.title);
  fmt::print("states           {}{}\n", e.states,
             model.stands_for != nullptr ? ", each for all that differ in like modules" : "");
  fmt::print("transitions      {} ({} events in every state), {} taken by a row\n", e.transitions,
             model.happenings.size(), e.taken);
  fmt::print("furthest state   {} events from boot\n", e.depth);
  fmt::print("rows             {}, {} never taken\n", e.row.size(), unused);
  fmt::print("properties       {} of states, {} of steps, {} of events, {} of the way back\n",
             model.states.each.size(), model.steps.each.size(), model.contracts.size(),
             model.returns.size());
  fmt::print("time, memory     {:.2f} s, {:.1f} bytes a state\n", e.seconds, bytes_per_state(e));
  if (e.violation) print_trace(vehicle, model, *e.violation);
  fmt::print("{}\n", e.complete && unused == 0 ? "all satisfied" : "NOT all satisfied");
}

int explore(const std::vector<const lc::Verified*>& vehicles, bool as_json, unsigned threads) {
  bool hold = true;
  nlohmann::json documents = nlohmann::json::array();
  for (const lc::Verified* vehicle : vehicles) {
    const lc::Model model = vehicle->model(*vehicle->table, vehicle->modules);
    const lc::Exploration e = lc::explore(model, {.threads = threads});
    const auto unused = static_cast<std::size_t>(std::count(e.row.begin(), e.row.end(), 0U));
    hold = hold && e.complete && unused == 0;
    if (as_json) {
      documents.push_back(json(*vehicle, e, unused));
    } else {
      fmt::print("{}", vehicle == vehicles.front() ? "" : "\n");
      print(*vehicle, model, e, unused);
    }
  }
  if (as_json) fmt::print("{}\n", documents.dump(2));
  return hold ? 0 : 1;
}

int mutate(const std::vector<const lc::Verified*>& vehicles) {
  bool noticed = true;
  for (const lc::Verified* vehicle : vehicles) {
    const lc::Mutations m = lc::mutate(*vehicle);
    for (const std::string& survivor : m.survivors) fmt::print("not noticed: {}\n", survivor);
    for (const std::string& silent : m.undemanded) fmt::print("no requirement: {}\n", silent);
    fmt::print("{}\n{:<20} {:>6} {:>10} {:>8} {:>20}\n", vehicle->title, "change of the table",
               "all", "equivalent", "noticed", "by requirements alone");
    const auto line = [](const char* name, const lc::Mutations::Count& c) {
      const std::size_t others = c.all - c.equivalent;
      fmt::print("{:<20} {:>6} {:>10} {:>8} {:>12} {:>6.1f} %\n", name, c.all, c.equivalent,
                 c.caught, c.demanded,
                 others == 0
                     ? 100.0
                     : 100.0 * static_cast<double>(c.demanded) / static_cast<double>(others));
    };
    for (std::size_t i = 0; i < lc::kChanges; ++i) line(lc::kChangeNames[i], m.of[i]);
    line("sum", m.sum());
    fmt::print("{:.1f} s\n", m.seconds);
    noticed = noticed && m.survivors.empty();
  }
  return noticed ? 0 : 1;
}

int compose(const std::vector<const lc::Verified*>& vehicles, const lc::Depth& depth) {
  bool hold = true;
  for (const lc::Verified* vehicle : vehicles) {
    if (vehicle->composition == nullptr) continue;
    const lc::Composition c = vehicle->composition(depth);
    fmt::print("{}: supervisor, watch and solver over abstract modules\n", vehicle->title);
    fmt::print("failures         {}, the second {}\n", depth.failures,
               depth.every ? "at every step" : "where something changes");
    fmt::print("states           {}\nframes           {}\nchoices          {}\n", c.states, c.steps,
               c.choices);
    fmt::print("time             {:.1f} s\n", c.seconds);
    if (c.violation) {
      fmt::print("broken: {}\n", c.violation->property);
      for (const std::string& line : c.violation->trace) fmt::print("{}\n", line);
    }
    fmt::print("{}\n", c.violation ? "NOT all satisfied" : "all satisfied");
    hold = hold && !c.violation;
  }
  return hold ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App cli("lss-lc: the locomotion controllers, explored state by state");
  bool as_json = false;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::vector<std::string> names, wanted;
  for (const lc::Verified* vehicle : lc::verified_vehicles()) names.emplace_back(vehicle->name);
  const auto takes_vehicles = [&](CLI::App* command, bool one) {
    auto* option = command->add_option(
        "vehicle", wanted, fmt::format("{}{}", fmt::join(names, ", "), one ? "" : "; none: all"));
    option->check(CLI::IsMember(names));
    if (one) option->required()->expected(1);
  };
  auto* exploring = cli.add_subcommand(
      "explore", "visit every reachable state, check all properties at every step");
  takes_vehicles(exploring, false);
  exploring->add_flag("--json", as_json, "for a program: a list, an entry for each vehicle");
  exploring->add_option("--threads", threads, "how many share the work; the result is the same")
      ->check(CLI::Range(1, 64))
      ->capture_default_str();
  auto* mutating = cli.add_subcommand(
      "mutate", "break the table, one transition at a time: do the properties notice?");
  takes_vehicles(mutating, false);
  lc::Depth depth{.every = false};
  auto* composing = cli.add_subcommand(
      "composition", "supervisor, watch and solver together, when one or two things fail");
  takes_vehicles(composing, false);
  composing->add_option("--failures", depth.failures, "how many, one after the other")
      ->check(CLI::Range(1, 2))
      ->capture_default_str();
  composing->add_flag("--every", depth.every, "the second one at every step, not only at changes");
  composing->add_option("--only", depth.only, "first failures of this name only");
  composing->add_option("--modules", depth.modules, "that may fail, as bits; 1: the first");
  composing->add_option("--threads", depth.threads,
                        "how many share the work; 0: one for each processor");
  auto* spin = cli.add_subcommand("promela",
                                  "the model for SPIN (build target lss-lc-spin-VEHICLE runs it)");
  takes_vehicles(spin, true);
  auto* drawing = cli.add_subcommand("diagram", "states and modes for Graphviz");
  takes_vehicles(drawing, true);
  cli.require_subcommand(1);
  cli.footer("Examples:\n  lss-lc explore\n  lss-lc diagram zebro | dot -Tsvg > lc.svg");
  try {
    cli.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return cli.exit(error) == 0 ? 0 : 2;
  }
  std::vector<const lc::Verified*> vehicles;
  for (const std::string& name : wanted.empty() ? names : wanted)
    vehicles.push_back(lc::verified_vehicle(name));
  if (exploring->parsed()) return explore(vehicles, as_json, threads);
  if (mutating->parsed()) return mutate(vehicles);
  if (composing->parsed()) return compose(vehicles, depth);
  if (spin->parsed()) fmt::print("{}", lc::promela(*vehicles.front()));
  if (drawing->parsed()) fmt::print("{}", lc::diagram(*vehicles.front()));
  return 0;
}
