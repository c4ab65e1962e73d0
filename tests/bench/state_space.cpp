// Row viii: the state space of the locomotion controller, explored with all properties, against
// SPIN on the same system through the same step(). The counts must be the same. And supervisor,
// watch and solver together, when one thing fails.

#include <fmt/format.h>

#include <regex>
#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/programs.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::bench {
namespace {

constexpr double kDezyneStatesPerSecond = 122'195 / 61.0;  // Zebro thesis, table 6.1

// Counts as SPIN prints them, with eight digits. The way to the first state is a transition, too.
struct Spin {
  std::string states, transitions;
  double seconds = 0;
};
std::string as_spin(std::uint64_t count) {
  return fmt::format("{:.8g}", static_cast<double>(count));
}

Spin spin() {
  Folder folder;
  const TimeNs begin = now_ns();
  Process verifier({program("lss-lc-spin-zebro"), "-w24"}, folder / "spin.log");
  if (verifier.wait() != 0) throw NotHere("SPIN's verifier is not built: install the package spin");
  Spin s{.states = {}, .transitions = {}, .seconds = static_cast<double>(now_ns() - begin) * 1e-9};
  const std::string said = read_file(folder / "spin.log");
  std::smatch found;
  if (std::regex_search(said, found, std::regex("([0-9.e+]+) states, stored"))) s.states = found[1];
  if (std::regex_search(said, found, std::regex("([0-9.e+]+) transitions")))
    s.transitions = found[1];
  return s;
}

constexpr double kComposition_s = 60;

Figure composition(const lc::Verified& vehicle) {
  const lc::Composition c = vehicle.composition({.failures = 1});
  if (c.violation) throw std::runtime_error("composition: " + c.violation->property);
  Figure figure = figure_of(
      "viii", "composition with watch and solver, one failure at each step", "s", c.seconds, kNone,
      kComposition_s, fmt::format("{}: {} states, {} frames", vehicle.name, c.states, c.steps));
  figure.absolute = true;
  return figure;
}

}  // namespace

Figures state_space(const Options& options) {
  const lc::Verified& zebro = *lc::verified_vehicle("zebro");
  const lc::Model model = zebro.model(*zebro.table, options.quick ? zebro.few : zebro.modules);
  lc::Exploration e = lc::explore(model);
  Samples seconds{e.seconds};
  for (int i = 1; i < options.count(kRounds, 1); ++i) {
    e = lc::explore(model);
    seconds.push_back(e.seconds);
  }
  if (!e.complete) throw std::runtime_error("the exploration has no verdict");
  const double ours_s = median(seconds);
  const auto states = static_cast<double>(e.states);
  const std::string size = fmt::format("{} states, {} transitions, {} CPUs", e.states,
                                       e.transitions, std::thread::hardware_concurrency());
  Figure verdict = figure_of("viii", "full verdict", "s", ours_s, 1, 1, size);
  verdict.absolute = true;
  Figure memory = figure_of("viii", "memory of a state", "B", static_cast<double>(e.bytes) / states,
                            24, 24, "with how it was reached");
  memory.absolute = true;
  Figures figures{
      verdict, memory,
      figure_of("viii", "time of a state, against Dezyne's", "us", ours_s / states * 1e6,
                1e6 / kDezyneStatesPerSecond, 1e-3, "reference: the Zebro thesis' table"),
      composition(zebro)};
  if (options.quick) {
    figures.push_back(not_measured("viii", "against SPIN", "left out by --quick"));
    return figures;
  }
  const Spin s = spin();
  Figure against =
      figure_of("viii", "full verdict, against SPIN", "s", ours_s, s.seconds, 0.2,
                fmt::format("of SPIN: {} states, {} transitions", s.states, s.transitions));
  figures.push_back(against);
  Figure same = figure_of(
      "viii", "counts that differ from SPIN's", "1",
      (s.states != as_spin(e.states)) + (s.transitions != as_spin(e.transitions + 1)), 0, 0);
  same.absolute = true;
  figures.push_back(same);
  return figures;
}

}  // namespace lss::bench
