#include "gnc/zebro/max_plus.h"

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "tests/zebro/gnc/generators.h"

namespace lss::gnc::zebro::test {
namespace {

using namespace max_plus;  // NOLINT: the tests read as algebra

constexpr Guard kPlain = Guard::own_last_group;

rc::Gen<Matrix> any_matrix() {
  const auto entry =
      rc::gen::weightedOneOf<double>({{2, rc::gen::just(kEps)}, {1, dyadic_s(-640, 640)}});
  return rc::gen::map(rc::gen::container<std::vector<double>>(kSize * kSize, entry),
                      [](const std::vector<double>& drawn) {
                        Matrix a;
                        for (std::size_t i = 0; i < kSize; ++i) {
                          for (std::size_t j = 0; j < kSize; ++j) a[i][j] = drawn[i * kSize + j];
                        }
                        return a;
                      });
}

Vector shifted(Vector x, double by) {
  for (double& value : x) value += by;
  return x;
}

RC_GTEST_PROP(MaxPlus, IsASemiring, ()) {
  const Matrix a = *any_matrix(), b = *any_matrix(), c = *any_matrix();
  RC_ASSERT(multiply(multiply(a, b), c) == multiply(a, multiply(b, c)));
  RC_ASSERT(multiply(a, add(b, c)) == add(multiply(a, b), multiply(a, c)));
  RC_ASSERT(multiply(a, identity()) == a);
  RC_ASSERT(multiply(identity(), a) == a);
  RC_ASSERT(add(a, null()) == a);
  RC_ASSERT(multiply(a, null()) == null());
}

RC_GTEST_PROP(MaxPlus, EigenvectorIsReproducedByTheSystemMatrixOneCycleLater, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *synchronising_times(gait);
  const Matrix a = *system_matrix(gait, times, kPlain);
  const Vector v = to_vector(rhythm(gait, times));
  RC_ASSERT(multiply(a, v) == shifted(v, cycle_time_s(gait, times)));
}

RC_GTEST_PROP(MaxPlus, KarpsCycleMeanIsTheCycleTimeWhetherSynchronisedOrNot, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *any_times();
  const double lambda_s = cycle_time_s(gait, times);
  RC_ASSERT(std::abs(cycle_mean(*system_matrix(gait, times, kPlain)) - lambda_s) < 1e-9);
}

RC_GTEST_PROP(MaxPlus, PowersOfTheSystemMatrixRepeatAfterTwoCycles, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *synchronising_times(gait);
  const Matrix a = *system_matrix(gait, times, kPlain);
  const Matrix a2 = multiply(a, a);
  Matrix expected = a2;
  for (Vector& row : expected) row = shifted(row, cycle_time_s(gait, times));
  RC_ASSERT(multiply(a2, a) == expected);
}

RC_GTEST_PROP(MaxPlus, SameCycleMatrixIsNilpotentOfIndexTwiceTheGroups, ()) {
  const Partition gait = *any_partition();
  const GaitTimes times = *any_times();
  RC_ASSERT(nilpotency_index(same_cycle(gait, times)) == 2 * gait.groups);
}

RC_GTEST_PROP(MaxPlus, StarSolvesTheImplicitEquation, ()) {
  const Partition gait = *any_partition();
  const Matrix a0 = same_cycle(gait, *any_times());
  const Matrix a0_star = *star(a0);
  RC_ASSERT(a0_star == add(multiply(a0, a0_star), identity()));
}

TEST(MaxPlus, MatrixWithACircuitHasNoStar) {
  Matrix ring = same_cycle(kTripod, {3, 3.3, 0.3});
  ring[kLegs + 0][1] = 0.3;  // the first group waits for the second, which waits for the first
  EXPECT_EQ(nilpotency_index(ring), 0);
  EXPECT_FALSE(star(ring).has_value());
}

TEST(MaxPlus, CycleMeanOfKnownGraphs) {
  EXPECT_EQ(cycle_mean(null()), kEps);
  EXPECT_EQ(cycle_mean(identity()), 0);
  Matrix a = null();
  a[1][0] = 3;  // 0 -> 1 -> 2 -> 0 of mean 3, and a loop at 5 of weight 2
  a[2][1] = 4;
  a[0][2] = 2;
  a[5][5] = 2;
  EXPECT_DOUBLE_EQ(cycle_mean(a), 3);
  a[5][5] = 3.5;
  EXPECT_DOUBLE_EQ(cycle_mean(a), 3.5);
}

}  // namespace
}  // namespace lss::gnc::zebro::test
