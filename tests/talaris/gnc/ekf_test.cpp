// The Kalman filter against the same one written densely, its derivatives against finite
// differences, and the covariance as a covariance.

#include "gnc/talaris/ekf.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <functional>
#include <random>

#include "tests/talaris/gnc/dense_ekf.h"

namespace lss::gnc::talaris::test {
namespace {

using Vector15 = DenseEkf::Vector;

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  std::mt19937_64 engine;
  double normal(double sigma = 1) { return std::normal_distribution<double>(0, sigma)(engine); }
  double uniform(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(engine);
  }
  Vector3 vector(double sigma) { return {normal(sigma), normal(sigma), normal(sigma)}; }
};

constexpr NoiseDensity kNoise{0.02, 1.7e-4, 2e-4, 6e-6};
constexpr double kRangeVariance = 1e-4;

Matrix15 some_covariance(Random& random) {
  const double sigma[] = {0.1, 0.05, 0.004, 0.02, 2e-4};
  DenseEkf::Matrix root;
  for (int i = 0; i < 15; ++i) {
    for (int j = 0; j < 15; ++j) root(i, j) = random.normal(sigma[i / 3] / 4);
  }
  return root * root.transpose();
}

struct Pair {
  Ekf sparse{kNoise, kGravity_m_s2};
  DenseEkf dense;

  Pair(Random& random, DenseEkf::Form form) {
    Nominal x;
    x.position_N_m = Vector3(3, 0, 0) + random.vector(0.5);
    x.velocity_N_m_s = random.vector(0.5);
    x.q_NB = exponential(random.vector(0.1));
    x.accelerometer_bias_m_s2 = random.vector(0.02);
    x.gyro_bias_rad_s = random.vector(1e-3);
    const Matrix15 p = some_covariance(random);
    sparse.start(x, p);
    dense.form = form;
    dense.force_noise = kNoise.force;
    dense.rate_noise = kNoise.rate;
    dense.force_bias_walk = kNoise.force_bias;
    dense.rate_bias_walk = kNoise.rate_bias;
    dense.start(x, p);
  }

  void propagate(double dt, const Vector3& rate, const Vector3& force) {
    sparse.propagate(dt, rate, force);
    dense.propagate(dt, rate, force);
  }

  // Sparse state minus dense state.
  Vector15 apart() const {
    DenseEkf x = dense;
    x.start(sparse.nominal(), dense.P);
    return x.minus(dense);
  }
};

// Height over ground or distance from a wall by plain geometry: where does the beam meet the plane?
double dense_range(const DenseEkf& x, const Beam& beam) {
  const Eigen::Vector3d from = x.p + x.q * beam.at_B_m;
  const Eigen::Vector3d along = x.q * beam.direction_B;
  return (beam.plane_m - from(beam.axis)) / along(beam.axis);
}

Vector15 difference_quotient(const DenseEkf& x, const Beam& beam) {
  Vector15 h;
  for (int i = 0; i < 15; ++i) {
    constexpr double kStep = 1e-3;
    const auto apart = [&](double step) {
      DenseEkf up = x, down = x;
      up.add(Vector15::Unit(i) * step);
      down.add(Vector15::Unit(i) * -step);
      return dense_range(up, beam) - dense_range(down, beam);
    };
    h(i) = (8 * apart(kStep) - apart(2 * kStep)) / (12 * kStep);  // error of fourth order
  }
  return h;
}

// The same, differentiated by hand.
Vector15 derivative(const DenseEkf& x, const Beam& beam) {
  const Eigen::RowVector3d row = x.q.toRotationMatrix().row(beam.axis);
  const double along = row.dot(beam.direction_B);
  Vector15 h = Vector15::Zero();
  h(beam.axis) = -1 / along;
  h.segment<3>(6) = (row * DenseEkf::skew(beam.at_B_m) +
                     dense_range(x, beam) * row * DenseEkf::skew(beam.direction_B)) /
                    along;
  return h;
}

Beam beam_of(bool down, const Vector3& at) {
  Beam beam;
  beam.at_B_m = at;
  if (down) return beam;
  beam.axis = 2;
  beam.sign = -1;
  beam.plane_m = 12;
  beam.direction_B = Vector3::UnitZ();
  return beam;
}

// A vehicle that swings and accelerates, never far from upright.
struct Ride {
  explicit Ride(Random& random) {
    for (double& f : phase) f = random.uniform(0, 6.28);
    size = random.uniform(0.3, 1);
  }
  double phase[6];
  double size;
  Vector3 rate(double t) const {
    return size * Vector3(std::cos(1.1 * t + phase[0]), 0.3 * std::cos(1.7 * t + phase[1]),
                          0.3 * std::cos(2.3 * t + phase[2]));
  }
  Vector3 force(double t) const {
    return Vector3(kGravity_m_s2, 0, 0) + size * Vector3(std::cos(1.3 * t + phase[3]),
                                                         std::cos(0.9 * t + phase[4]),
                                                         std::cos(1.9 * t + phase[5]));
  }
};

// Ranges of what the filter expects plus noise: both filters see the same ones.
void fly(Pair& pair, const Beam& beam, Random& random, double seconds,
         const std::function<void()>& look) {
  const Ride ride(random);
  double t = 0, next_range = 0.05;
  while (t < seconds) {
    const double dt = random.uniform(0.004, 0.006);
    t += dt;
    pair.propagate(dt, ride.rate(t) + random.vector(2e-3), ride.force(t) + random.vector(0.2));
    if (t < next_range) continue;
    next_range += random.uniform(0.08, 0.12);
    const double z = dense_range(pair.dense, beam) + random.normal(0.01);
    const ExpectedRange e = expected_range(pair.sparse.nominal(), beam);
    pair.sparse.correct({.axis = beam.axis,
                         .by_position = e.by_position,
                         .by_attitude = e.by_attitude,
                         .residual = z - e.range_m,
                         .variance = kRangeVariance},
                        5);
    pair.dense.correct(derivative(pair.dense, beam), z - dense_range(pair.dense, beam),
                       kRangeVariance, 5);
    look();
  }
}

class EkfPointing : public testing::TestWithParam<bool> {
 protected:
  // `look` after each range.
  static void fly_seed(unsigned seed, DenseEkf::Form form, double seconds,
                       const std::function<void(const Pair&)>& look) {
    Random random(seed);
    Pair pair(random, form);
    fly(pair, beam_of(GetParam(), random.vector(0.2)), random, seconds, [&] { look(pair); });
  }
};
INSTANTIATE_TEST_SUITE_P(DownAndSideways, EkfPointing, testing::Bool());

TEST_P(EkfPointing, IsTheDenseFilter) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    double worst_state = 0, worst_covariance = 0;
    fly_seed(seed, DenseEkf::Form::middle_of_step, 30, [&](const Pair& pair) {
      worst_state = std::max(worst_state, pair.apart().cwiseAbs().maxCoeff());
      const Matrix15 p = pair.sparse.covariance();
      worst_covariance = std::max(worst_covariance, (p - pair.dense.P).cwiseAbs().maxCoeff());
    });
    EXPECT_LT(worst_state, 1e-9) << seed;
    EXPECT_LT(worst_covariance, 1e-9) << seed;
    RecordProperty("state", std::to_string(worst_state));
  }
}

// What is left out by one transition for several samples: derivatives at the beginning of a sample
// and noise with every one of them give the same estimate to a small share of its own uncertainty.
TEST_P(EkfPointing, IsNearTheFilterWithNoiseInEverySample) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    double worst_state = 0, worst_sigma = 0;
    fly_seed(seed, DenseEkf::Form::begin_of_step, 20, [&](const Pair& pair) {
      const Vector15 sigma = pair.dense.P.diagonal().cwiseSqrt();
      const Vector15 ours = pair.sparse.covariance().diagonal().cwiseSqrt();
      worst_state = std::max(worst_state, pair.apart().cwiseQuotient(sigma).cwiseAbs().maxCoeff());
      worst_sigma =
          std::max(worst_sigma, (ours - sigma).cwiseQuotient(sigma).cwiseAbs().maxCoeff());
    });
    EXPECT_LT(worst_state, 0.02) << seed;
    EXPECT_LT(worst_sigma, 0.01) << seed;
  }
}

TEST_P(EkfPointing, DerivativesOfTheRangeAreThoseOfFiniteDifferences) {
  Random random(1);
  for (int n = 0; n < 200; ++n) {
    DenseEkf x;
    x.p = Vector3(random.uniform(0.2, 10), random.normal(2), random.normal(2));
    x.q = DenseEkf::exponential(random.vector(0.2));
    const Beam beam = beam_of(GetParam(), random.vector(0.3));
    Nominal nominal;
    nominal.position_N_m = x.p;
    nominal.q_NB = x.q;
    const ExpectedRange e = expected_range(nominal, beam);
    const Vector15 h = difference_quotient(x, beam);
    const Vector3 by_body = nominal.q_NB.conjugate() * e.by_attitude;
    EXPECT_NEAR(e.range_m, dense_range(x, beam), 1e-12);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(h(i), i == beam.axis ? e.by_position : 0, 1e-8);
      EXPECT_NEAR(h(6 + i), by_body(i), 1e-8);
    }
    EXPECT_LT(h.segment<3>(3).norm() + h.segment<6>(9).norm(), 1e-12);
  }
}

// The step itself, pushed a little in each direction: the transition that is used is its derivative
// to second order, the one with the blocks of a sample's beginning only to first.
TEST(Ekf, TransitionIsTheDerivativeOfTheStep) {
  Random random(2);
  constexpr double kDt = 0.005;
  double ours = 0, begin = 0;
  for (int n = 0; n < 50; ++n) {
    DenseEkf x;
    x.q = DenseEkf::exponential(random.vector(0.5));
    const Vector3 rate = random.vector(1), force = Vector3(9.8, 0, 0) + random.vector(2);
    DenseEkf::Matrix quotient;
    for (int i = 0; i < 15; ++i) {
      constexpr double kStep = 1e-4;
      DenseEkf up = x, down = x;
      up.add(Vector15::Unit(i) * kStep);
      down.add(Vector15::Unit(i) * -kStep);
      up.propagate(kDt, rate, force);
      down.propagate(kDt, rate, force);
      quotient.col(i) = up.minus(down) / (2 * kStep);
    }
    // dp by what acts on the acceleration is dt / 2 of dv by it: left out, as in the document
    quotient.block<3, 9>(0, 6).setZero();
    // dv by b_g: half a sample of turning, left out too
    quotient.block<3, 3>(3, 12).setZero();
    x.form = DenseEkf::Form::middle_of_step;
    ours = std::max(ours, (x.transition(kDt, rate, force) - quotient).cwiseAbs().maxCoeff());
    x.form = DenseEkf::Form::begin_of_step;
    begin = std::max(begin, (x.transition(kDt, rate, force) - quotient).cwiseAbs().maxCoeff());
  }
  EXPECT_LT(ours, 2e-7);
  EXPECT_GT(begin, 100 * ours);
  RecordProperty("ours", std::to_string(ours * 1e9) + "e-9");
  RecordProperty("begin", std::to_string(begin * 1e9) + "e-9");
}

TEST(Ekf, CovarianceStaysSymmetricAndPositive) {
  Random random(3);
  Pair pair(random, DenseEkf::Form::middle_of_step);
  fly(pair, beam_of(true, Vector3::Zero()), random, 300, [&] {
    const DenseEkf::Matrix p = pair.sparse.covariance();
    ASSERT_EQ(p, p.transpose());
    // scaled, so that small variances count as much as large ones
    const Vector15 scale = p.diagonal().cwiseSqrt().cwiseInverse();
    const DenseEkf::Matrix unit = scale.asDiagonal() * p * scale.asDiagonal();
    ASSERT_EQ(Eigen::LLT<DenseEkf::Matrix>(unit).info(), Eigen::Success);  // positive definite
  });
}

TEST(Ekf, AStepWithoutNoiseIsFreeFlight) {
  Ekf ekf(NoiseDensity{}, kGravity_m_s2);
  Nominal x;
  x.position_N_m = {10, 0, 0};
  x.velocity_N_m_s = {1, 2, 3};
  ekf.start(x, Matrix15::Zero());
  for (int i = 0; i < 200; ++i) ekf.propagate(0.005, Vector3(0, 0, 1), Vector3::Zero());
  EXPECT_NEAR(ekf.nominal().position_N_m.x(), 10 + 1 - kGravity_m_s2 / 2, 1e-12);
  EXPECT_NEAR(ekf.nominal().position_N_m.z(), 3, 1e-12);
  EXPECT_NEAR(ekf.nominal().velocity_N_m_s.x(), 1 - kGravity_m_s2, 1e-12);
  const Quaternion turned(std::cos(0.5), 0, 0, std::sin(0.5));
  EXPECT_LT(ekf.nominal().q_NB.angularDistance(turned), 1e-12);
  ekf.settle();
  EXPECT_EQ(ekf.position_variance().norm(), 0);
}

TEST(Ekf, ExponentialIsTheTurnForSmallAndLargeAngles) {
  Random random(4);
  for (int n = 0; n < 2000; ++n) {
    const Vector3 angle = random.vector(std::pow(10.0, random.uniform(-9, 0.4)));
    const Eigen::Quaterniond right = DenseEkf::exponential(angle);
    EXPECT_LT((exponential(angle).coeffs() - right.coeffs()).norm(), 1e-15);
  }
}

// A gated measurement changes nothing at all.
TEST(Ekf, WhatIsBeyondTheGateIsNotUsed) {
  Random random(5);
  Pair pair(random, DenseEkf::Form::middle_of_step);
  pair.sparse.settle();
  const Matrix15 p = pair.sparse.covariance();
  const Nominal x = pair.sparse.nominal();
  Ekf::Measurement m{.by_position = 1, .variance = kRangeVariance};
  const double sigma = std::sqrt(p(0, 0) + kRangeVariance);
  m.residual = 5.001 * sigma;
  EXPECT_NEAR(pair.sparse.correct(m, 5), sigma * sigma, 1e-12);
  EXPECT_EQ(pair.sparse.covariance(), p);
  EXPECT_EQ(pair.sparse.nominal().position_N_m, x.position_N_m);
  m.residual = 4.999 * sigma;
  pair.sparse.correct(m, 5);
  EXPECT_GT((pair.sparse.nominal().position_N_m - x.position_N_m).norm(), sigma);
  EXPECT_LT(pair.sparse.position_variance().x(), p(0, 0));
}

}  // namespace
}  // namespace lss::gnc::talaris::test
