// The equivalence of wheels that the exploration of D.I.A.N.A. Ardito's controller uses.

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <set>
#include <vector>

#include "tools/lss-lc/vehicle.h"

namespace lss::lc {
namespace {

constexpr unsigned kWheels = 6, kSteered = 4, kModules = 11;

const Verified& vehicle() { return *verified_vehicle("ardito"); }
Model whole() { return vehicle().model(*vehicle().table, vehicle().modules); }

// Where each module goes: wheels among themselves, steering drives among themselves.
using Places = std::array<unsigned, kModules>;
Places any_places() {
  Places places;
  std::iota(places.begin(), places.end(), 0U);
  std::mt19937 random(*rc::gen::arbitrary<unsigned>());
  std::shuffle(places.begin(), places.begin() + kWheels, random);
  std::shuffle(places.begin() + kWheels, places.begin() + kWheels + kSteered, random);
  return places;
}
std::uint16_t moved(std::uint16_t set, const Places& places) {
  unsigned result = 0;
  for (unsigned i = 0; i < kModules; ++i) result |= (unsigned{set} >> i & 1U) << places[i];
  return static_cast<std::uint16_t>(result);
}
ControllerState moved(ControllerState s, const Places& places) {
  s.silent = moved(s.silent, places);
  s.unheard = moved(s.unheard, places);
  s.isolated = moved(s.isolated, places);
  return s;
}

// One that is reached by some way through the plain table, without stand-ins.
ControllerState any_state(const Model& m) {
  ControllerState s = m.begin;
  const int steps = *rc::gen::inRange(0, 120);
  for (int i = 0; i < steps; ++i) {
    // Towards Operational more often than chance would go there.
    const bool helped = *rc::gen::inRange(0, 3) != 0;
    const Happening h = helped ? m.returns.back().help(s) : *rc::gen::elementOf(m.happenings);
    s = step(*m.table, s, h.event, h.subject).next;
  }
  return s;
}

TEST(ArditoExplored, NothingDistinguishesOneWheelFromAnother) {
  const Model m = whole();
  EXPECT_TRUE(rc::check([&] {
    const ControllerState s = any_state(m);
    const Places places = any_places();
    const ControllerState other = moved(s, places);
    RC_ASSERT(stand_in(m, other) == stand_in(m, s));
    RC_ASSERT(m.states.all(*m.table, s));
    RC_ASSERT(m.states.all(*m.table, other));
    for (const Happening h : m.happenings) {
      const unsigned subject = h.subject == 0 ? 0 : places[h.subject - 1U] + 1;
      const Result of_s = step(*m.table, s, h.event, h.subject),
                   of_other = step(*m.table, other, h.event, subject);
      RC_ASSERT(of_other.next == moved(of_s.next, places));
      RC_ASSERT(of_other.actions == of_s.actions);
      RC_ASSERT(of_other.row == of_s.row);
      RC_ASSERT(of_other.verdict.reason == of_s.verdict.reason);
    }
  }));
}

TEST(ArditoExplored, AStandInIsOneOfThoseThatItStandsFor) {
  const Model m = whole();
  EXPECT_TRUE(rc::check([&] {
    const ControllerState s = any_state(m), first = stand_in(m, s);
    RC_ASSERT(stand_in(m, first) == first);
    Places places{};
    std::iota(places.begin(), places.end(), 0U);
    bool found = false;
    // wheels and steering drives move apart from each other: each group alone is tried
    for (const auto [from, to] : {std::pair{0U, kWheels}, {kWheels, kWheels + kSteered}}) {
      const auto of_group = [&](const ControllerState& state) {
        const auto in_group = static_cast<std::uint16_t>(((1U << to) - 1) & ~((1U << from) - 1));
        ControllerState part = state;
        part.silent &= in_group;
        part.unheard &= in_group;
        part.isolated &= in_group;
        return part;
      };
      Places tried = places;
      do {
        found = moved(of_group(s), tried) == of_group(first);
      } while (!found && std::next_permutation(tried.begin() + from, tried.begin() + to));
      RC_ASSERT(found);
    }
  }));
}

// With representatives the explorer finds exactly the representatives of the states of a plain
// search.
TEST(ArditoExplored, StandInsLeaveNothingOut) {
  const Model m = vehicle().model(*vehicle().table, 0x443);  // two wheels, steering, I/O
  std::set<Key> seen{pack(m.begin)}, standing{pack(stand_in(m, m.begin))};
  std::vector<ControllerState> left{m.begin};
  while (!left.empty()) {
    const ControllerState state = left.back();
    left.pop_back();
    for (const Happening h : m.happenings) {
      const ControllerState next = step(*m.table, state, h.event, h.subject).next;
      standing.insert(pack(stand_in(m, next)));
      if (seen.insert(pack(next)).second) left.push_back(next);
    }
  }
  const Exploration e = explore(m);
  EXPECT_EQ(e.states, standing.size());
  EXPECT_LT(e.states, seen.size());
}

}  // namespace
}  // namespace lss::lc
