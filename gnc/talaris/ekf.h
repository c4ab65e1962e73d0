#pragma once

// Error-state Kalman filter of 15 states: position, velocity, attitude, biases of accelerometers
// and gyroscopes. The nominal state follows every IMU sample; the covariance follows once for all
// samples between two corrections, by their common transition matrix, of which only a few 3 x 3
// blocks are not known beforehand. Corrections are scalars, one after another.
//
// A sample (w_m, a_m) covers the time dt since the previous one. With w = w_m - b_g, a = a_m - b_a
// and C = C(q exp(w dt/2)), q from B to N:
//
//   acc = C a + g      p += v dt + acc dt^2/2      v += acc dt      q <- q exp(w dt)
//
// Errors are (dp, dv, dth, db_a, db_g), true q = q exp(dth). With h = C(exp(w dt/2))^T:
//
//   dp' = dp + dv dt
//   dv' = dv - C [a x] h dth dt - C db_a dt
//   dth' = h h dth - h db_g dt                                       P <- F P F^T + Q
//
// A range runs along the beam b from r_a in B to a plane across the axis e of N (from plane to
// vehicle; ground: x, wall: -z). With n = C^T e, c = -n.b:
//
//   range = (e.(p - plane) + n.r_a)/c      d/dp = e/c      d/dth = -(n x r_a + range n x b)^T/c
//
// Corrections have Joseph's form and the reset G = I - [dth/2 x]. The factor h, and noise of
// gyroscopes and biases added once between corrections, differ from the usual filter, by less than
// 1 % of each sigma (ekf_test).
//
// Attitude errors are kept about the axes of N (true q = exp(psi) q), because there the transition
// needs sums only; covariance() gives them about the axes of B (psi = C dth). Both are the same
// filter.

#include "gnc/talaris/types.h"

namespace lss::gnc::talaris {

using Matrix3 = Eigen::Matrix3d;
using Matrix15 = Eigen::Matrix<double, 15, 15, Eigen::DontAlign>;

// The state that the filter corrects.
struct Nominal {
  Vector3 position_N_m = Vector3::Zero();
  Vector3 velocity_N_m_s = Vector3::Zero();
  Quaternion q_NB = Quaternion::Identity();
  Vector3 accelerometer_bias_m_s2 = Vector3::Zero();
  Vector3 gyro_bias_rad_s = Vector3::Zero();
};

// White noise and random walks as densities (1/sqrt(Hz), 1/sqrt(s)), 1 sigma.
struct NoiseDensity {
  double force = 0;       // m/s2/sqrt(Hz)
  double rate = 0;        // rad/s/sqrt(Hz)
  double force_bias = 0;  // m/s2/sqrt(s)
  double rate_bias = 0;   // rad/s/sqrt(s)
};

// A beam of the altimeter at a plane: the range is the distance along the beam.
struct Beam {
  int axis = 0;                             // of N, across the plane
  double sign = 1;                          // 1: the plane lies below, -1: ahead along the axis
  double plane_m = 0;                       // where the plane cuts the axis
  Vector3 direction_B = -Vector3::UnitX();  // unit vector
  Vector3 at_B_m = Vector3::Zero();         // where the beam begins
};

// The range expected from the state, and its derivatives.
struct ExpectedRange {
  double range_m = 0;
  double cosine = 0;                      // between beam and the plane's normal
  double by_position = 0;                 // by position along Beam::axis
  Vector3 by_attitude = Vector3::Zero();  // by psi, about N
};
ExpectedRange expected_range(const Nominal& nominal, const Beam& beam) noexcept;

// Attitude after turning by `angle_rad` (rotation vector).
Quaternion exponential(const Vector3& angle_rad) noexcept;

class Ekf {
 public:
  Ekf() = default;
  Ekf(const NoiseDensity& noise, double gravity_m_s2) noexcept
      : noise_(noise), gravity_m_s2_(gravity_m_s2) {}

  // Blocks in the order p, v, dth (about B), b_a, b_g.
  void start(const Nominal& nominal, const Matrix15& covariance) noexcept;

  // One sample, with bias, that applies for dt_s.
  void propagate(double dt_s, const Vector3& rate_B_rad_s, const Vector3& force_B_m_s2) noexcept;
  // Adds variance on each axis: nothing was measured for a while.
  void blur(double position_m2, double velocity_m2_s2, double attitude_rad2) noexcept;
  void blur_axis(int axis, double position_m2, double velocity_m2_s2) noexcept;

  // Linear scalar measurement: residual = by_position dp_axis + by_velocity dv_axis + by_attitude
  // psi + by_force_bias db_a + by_rate_bias db_g_axis + noise.
  struct Measurement {
    int axis = 0;
    double by_position = 0;
    double by_velocity = 0;
    double by_rate_bias = 0;
    Vector3 by_attitude = Vector3::Zero();
    Vector3 by_force_bias = Vector3::Zero();
    double residual = 0;
    double variance = 0;
  };
  // Brings the covariance to the time of the state; corrects unless the residual exceeds `gate`
  // times its standard deviation. Returns the variance of the residual.
  double correct(const Measurement& m,
                 double gate = std::numeric_limits<double>::infinity()) noexcept;

  const Nominal& nominal() const noexcept { return nominal_; }
  // Mean acceleration of the last propagate(), in N, without gravity.
  const Vector3& acceleration_N_m_s2() const noexcept { return acceleration_; }
  void settle() noexcept;  // brings the covariance to the time of the state

  // As of the last settle() or correct().
  Vector3 position_variance() const noexcept { return p_.diagonal().segment<3>(kPosition); }
  Vector3 velocity_variance() const noexcept { return p_.diagonal().segment<3>(kVelocity); }
  Vector3 attitude_variance() const noexcept;  // about the axes of B
  Matrix15 covariance() const noexcept;        // about B, as for start()

 private:
  static constexpr int kPosition = 0, kVelocity = 3, kAttitude = 6, kForceBias = 9, kRateBias = 12;
  // One more row, of zeros: whole columns are pairs for SIMD.
  using Column = Eigen::Matrix<double, 16, 1>;
  using Covariance = Eigen::Matrix<double, 16, 15>;

  void mirror() noexcept;
  void inject(const Column& correction) noexcept;

  // Sums over the samples since the covariance was brought up to date, which make up the transition
  // matrix: derivatives by b_a (with the sign turned; of psi by b_g, too), by b_g, and by psi (as
  // vectors: -[v x]). With f = C a, psi = C dth; ': before this sample:
  //   dv/dpsi = -[S_f x]  S_f += f dt       dp/dpsi = -[S_s x]  S_s += S_f' dt
  //   dv/db_a = -D        D += C dt         dp/db_a = -E        E += D' dt
  //   dv/db_g = X         X += [f x] D' dt  dp/db_g = Y         Y += X' dt      dpsi/db_g = -D
  struct Sums {
    Eigen::Matrix<double, 3, 8> all = Eigen::Matrix<double, 3, 8>::Zero();  // the last is unused
    auto by_attitude() noexcept { return all.col(6); }
  };
  struct Since {
    double time_s = 0;
    Sums velocity, position;
    double qvv = 0, qpv = 0, qpp = 0;  // variance by the noise of the accelerometers
  };

  // Of position or velocity by psi, b_a and b_g.
  using Tail = Eigen::Matrix<double, 3, 9>;
  static Tail tail_of(const Sums& sums) noexcept;

  NoiseDensity noise_;
  double gravity_m_s2_ = kGravity_m_s2;
  Nominal nominal_;
  Vector3 acceleration_ = Vector3::Zero();
  Since since_;
  Covariance p_ = Covariance::Zero();  // of p, v, psi, b_a, b_g
};

}  // namespace lss::gnc::talaris
