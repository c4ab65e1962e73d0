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
// What survives of the rows that accept or do more is argued in docs/verification.md.
TEST_P(Vehicle, ChangesOfTheTableAreNoticedAlsoByTheRequirementsAlone) {
  const Mutations m = mutate(*GetParam());
  const Mutations::Count sum = m.sum();
  EXPECT_GT(sum.all, 10 * GetParam()->table->rows->rows.size());
  for (const Change change :
       {Change::dropped, Change::redirected, Change::loosened, Change::idle}) {
    const Mutations::Count& count = m.of[static_cast<std::size_t>(change)];
    EXPECT_EQ(count.caught + count.equivalent, count.all)
        << kChangeNames[static_cast<std::size_t>(change)];
  }
  const double share =
      static_cast<double>(sum.demanded) / static_cast<double>(sum.all - sum.equivalent);
  EXPECT_GE(share, 0.95);
}
#endif

INSTANTIATE_TEST_SUITE_P(Verified, Vehicle,
                         testing::ValuesIn(verified_vehicles().begin(), verified_vehicles().end()),
                         [](const auto& of) { return std::string(of.param->name); });

}  // namespace
}  // namespace lss::lc
