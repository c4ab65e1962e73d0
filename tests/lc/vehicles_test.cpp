// Checks the shipping table of each vehicle against its properties.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "tools/lss-lc/mutations.h"
#include "tools/lss-lc/vehicle.h"

namespace lss::lc {
namespace {

#ifdef LSS_SANITIZED
constexpr bool kSlow = true;
#else
constexpr bool kSlow = false;
#endif

// The broken property, and the shortest way to where it breaks.
std::string told(const Verified& vehicle, const Model& model, const Exploration& e) {
  if (!e.violation) return "";
  std::string told = e.violation->property + "\n";
  ControllerState state = model.begin;
  for (const Happening h : e.violation->trace) {
    state = stand_in(model, step(*model.table, state, h.event, h.subject).next);
    told += text(vehicle, h) + " -> " + text(vehicle, state) + "\n";
  }
  return told;
}

class Vehicle : public testing::TestWithParam<const Verified*> {};

// [Des-1] [Prod-1] [Prod-3] [Func-5] [Oper-5] [Oper-6] [Oper-7] [Conf-3]
TEST_P(Vehicle, EveryPropertyHoldsInEveryReachableState) {
  const Verified& vehicle = *GetParam();
  const Model m = vehicle.model(*vehicle.table, kSlow ? vehicle.few : vehicle.modules);
  const Exploration e = explore(m);
  EXPECT_TRUE(e.complete) << told(vehicle, m, e);
  EXPECT_EQ(std::count(e.row.begin(), e.row.end(), 0U), 0) << "rows that nothing ever takes";
}

#ifndef LSS_SANITIZED  // for its time
TEST_P(Vehicle, EveryBrokenTransitionOfTheTableIsNoticed) {
  const Mutations m = mutate(*GetParam());
  EXPECT_GT(m.count, 10 * GetParam()->table->rows->rows.size());
  EXPECT_EQ(m.caught + m.equivalent, m.count);
  for (const std::string& survivor : m.survivors) ADD_FAILURE() << "not noticed: " << survivor;
}
#endif

INSTANTIATE_TEST_SUITE_P(Verified, Vehicle,
                         testing::ValuesIn(verified_vehicles().begin(), verified_vehicles().end()),
                         [](const auto& of) { return std::string(of.param->name); });

}  // namespace
}  // namespace lss::lc
