#include "gnc/talaris/ekf.h"

#include <cmath>
#include <cstring>

#include "gnc/math.h"

namespace lss::gnc::talaris {
namespace {

Matrix3 skew(const Vector3& v) noexcept {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Matrix3 rotation(const Quaternion& q) noexcept { return q.toRotationMatrix(); }

// f x, column by column.
template <class F, class X>
inline Vector3 times(const F& f, const X& x) noexcept {
  double r0 = 0, r1 = 0, r2 = 0;
#pragma GCC unroll 9
  for (Eigen::Index k = 0; k < X::RowsAtCompileTime; ++k) {
    r0 += f(0, k) * x(k);
    r1 += f(1, k) * x(k);
    r2 += f(2, k) * x(k);
  }
  return {r0, r1, r2};
}

// With four numbers in registers: Eigen's goes through memory, in pairs, and waits for its own
// stores.
struct Turn {
  double w, x, y, z;
};
inline Turn operator*(const Turn& a, const Turn& b) noexcept {
  return {
      a.w * b.w - a.x * b.x - a.y * b.y - a.z * b.z, a.w * b.x + a.x * b.w + a.y * b.z - a.z * b.y,
      a.w * b.y + a.y * b.w + a.z * b.x - a.x * b.z, a.w * b.z + a.z * b.w + a.x * b.y - a.y * b.x};
}
inline Turn turn_of(double x, double y, double z) noexcept {
  const double h2 = (x * x + y * y + z * z) / 4;
  double c, s;  // cos h, sin(h) / (2 h)
  // series with a remainder below 1e-17; no division, this is done for every sample
  if (h2 < 1e-5) {
    c = 1 - h2 * (0.5 - h2 * (1.0 / 24));
    s = 0.5 - h2 * (1.0 / 12 - h2 * (1.0 / 240));
  } else if (h2 < 0.01) {
    c = 1 - h2 * (0.5 - h2 * (1.0 / 24 - h2 * (1.0 / 720 - h2 * (1.0 / 40320 - h2 / 3628800))));
    s = 0.5 - h2 * (1.0 / 12 - h2 * (1.0 / 240 - h2 * (1.0 / 10080 - h2 / 725760)));
  } else {
    const double h = std::sqrt(h2);
    c = math::cos(h);
    s = math::sin(h) / (2 * h);
  }
  return {c, s * x, s * y, s * z};
}

// to += factor * from, two numbers at a time, each as by itself.
template <class Matrix>
inline void add(Matrix& to, double factor, const Matrix& from) noexcept {
  using Pair [[gnu::vector_size(16)]] = double;
  static_assert(sizeof(Matrix) % sizeof(Pair) == 0);
  for (Eigen::Index i = 0; i < to.size(); i += 2) {
    Pair sum, term;
    std::memcpy(&sum, to.data() + i, sizeof sum);
    std::memcpy(&term, from.data() + i, sizeof term);
    sum += factor * term;
    std::memcpy(to.data() + i, &sum, sizeof sum);
  }
}

// One Newton step: a product of unit quaternions is off by rounding only.
void normalise(Quaternion& q) noexcept { q.coeffs() *= 1.5 - 0.5 * q.squaredNorm(); }

}  // namespace

Quaternion exponential(const Vector3& angle) noexcept {
  const Turn t = turn_of(angle.x(), angle.y(), angle.z());
  return {t.w, t.x, t.y, t.z};
}

ExpectedRange expected_range(const Nominal& nominal, const Beam& beam) noexcept {
  // row of C for the axis, seen from the plane
  const Matrix3 c = rotation(nominal.q_NB);
  const Vector3 n = beam.sign * c.row(beam.axis).transpose();
  const double cosine = -n.dot(beam.direction_B);
  const double across =
      beam.sign * (nominal.position_N_m(beam.axis) - beam.plane_m) + n.dot(beam.at_B_m);
  ExpectedRange e;
  e.cosine = cosine;
  e.range_m = across / cosine;
  e.by_position = beam.sign / cosine;
  const Vector3 by_body = -(n.cross(beam.at_B_m) + e.range_m * n.cross(beam.direction_B)) / cosine;
  e.by_attitude = c * by_body;
  return e;
}

void Ekf::start(const Nominal& nominal, const Matrix15& p) noexcept {
  nominal_ = nominal;
  nominal_.q_NB.normalize();
  acceleration_.setZero();
  since_ = {};
  const Matrix3 c = rotation(nominal_.q_NB);
  p_.setZero();
  p_.topRows<15>() = p;
  p_.middleCols<3>(kAttitude) = (p_.middleCols<3>(kAttitude) * c.transpose()).eval();
  p_.middleRows<3>(kAttitude) = (c * p_.middleRows<3>(kAttitude)).eval();
  mirror();
}

// Copies the lower triangle to the upper one.
void Ekf::mirror() noexcept {
  p_.block<3, 12>(0, 3) = p_.block<12, 3>(3, 0).transpose();
  p_.block<3, 9>(3, 6) = p_.block<9, 3>(6, 3).transpose();
  p_.block<3, 6>(6, 9) = p_.block<6, 3>(9, 6).transpose();
  for (const int i : {kPosition, kVelocity, kAttitude}) {
    p_(i, i + 1) = p_(i + 1, i);
    p_(i, i + 2) = p_(i + 2, i);
    p_(i + 1, i + 2) = p_(i + 2, i + 1);
  }
}

void Ekf::propagate(double dt, const Vector3& rate, const Vector3& force) noexcept {
  Nominal& x = nominal_;
  const double half_dt = dt / 2;
  const Turn q{x.q_NB.w(), x.q_NB.x(), x.q_NB.y(), x.q_NB.z()};
  const Turn half = turn_of((rate.x() - x.gyro_bias_rad_s.x()) * half_dt,
                            (rate.y() - x.gyro_bias_rad_s.y()) * half_dt,
                            (rate.z() - x.gyro_bias_rad_s.z()) * half_dt);
  const Turn m = q * half;
  // half * half; settle() corrects rounding of the length
  const Turn end = m * half;
  x.q_NB = Quaternion(end.w, end.x, end.y, end.z);
  const double x2 = 2 * m.x, y2 = 2 * m.y, z2 = 2 * m.z;
  const double xx = x2 * m.x, yy = y2 * m.y, zz = z2 * m.z, xy = x2 * m.y, xz = x2 * m.z,
               yz = y2 * m.z, wx = x2 * m.w, wy = y2 * m.w, wz = z2 * m.w;
  const double c[3][3] = {{1 - yy - zz, xy - wz, xz + wy},
                          {xy + wz, 1 - xx - zz, yz - wx},
                          {xz - wy, yz + wx, 1 - xx - yy}};
  const double ax = force.x() - x.accelerometer_bias_m_s2.x(),
               ay = force.y() - x.accelerometer_bias_m_s2.y(),
               az = force.z() - x.accelerometer_bias_m_s2.z();
  double f[3];
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) f[i] = c[i][0] * ax + c[i][1] * ay + c[i][2] * az;
  acceleration_ = {f[0] - gravity_m_s2_, f[1], f[2]};
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    x.position_N_m[i] += dt * (x.velocity_N_m_s[i] + half_dt * acceleration_[i]);
    x.velocity_N_m_s[i] += dt * acceleration_[i];
  }

  Since& s = since_;
  const double dx = dt * f[0], dy = dt * f[1], dz = dt * f[2];
  double* const v = s.velocity.all.data();
  add(s.position.all, dt, s.velocity.all);
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {  // += [df x] d
    const double d0 = v[3 * i], d1 = v[3 * i + 1], d2 = v[3 * i + 2];
    v[9 + 3 * i] += dy * d2 - dz * d1;
    v[9 + 3 * i + 1] += dz * d0 - dx * d2;
    v[9 + 3 * i + 2] += dx * d1 - dy * d0;
  }
#pragma GCC unroll 3
  for (int i = 0; i < 3; ++i) {
    v[3 * i] += dt * c[0][i];
    v[3 * i + 1] += dt * c[1][i];
    v[3 * i + 2] += dt * c[2][i];
  }
  v[18] += dx;
  v[19] += dy;
  v[20] += dz;
  s.qpp += dt * (2 * s.qpv + dt * s.qvv);
  s.qpv += dt * s.qvv;
  s.qvv += dt * noise_.force * noise_.force;
  s.time_s += dt;
}

void Ekf::blur(double position, double velocity, double attitude) noexcept {
  settle();
  p_.diagonal().segment<3>(kPosition).array() += position;
  p_.diagonal().segment<3>(kVelocity).array() += velocity;
  p_.diagonal().segment<3>(kAttitude).array() += attitude;
}

void Ekf::blur_axis(int axis, double position, double velocity) noexcept {
  settle();
  p_(kPosition + axis, kPosition + axis) += position;
  p_(kVelocity + axis, kVelocity + axis) += velocity;
}

Ekf::Tail Ekf::tail_of(const Sums& sums) noexcept {
  const auto& s = sums.all;
  Tail f;
  f << 0, s(2, 6), -s(1, 6), -s(0, 0), -s(0, 1), -s(0, 2), s(0, 3), s(0, 4), s(0, 5),  //
      -s(2, 6), 0, s(0, 6), -s(1, 0), -s(1, 1), -s(1, 2), s(1, 3), s(1, 4), s(1, 5),   //
      s(1, 6), -s(0, 6), 0, -s(2, 0), -s(2, 1), -s(2, 2), s(2, 3), s(2, 4), s(2, 5);
  return f;
}

// P <- F P F^T + Q. F is the identity but for rows of the position, velocity and attitude:
// p: t of v, `fp` of psi, b_a and b_g;   v: `fv` of these;   psi: `ft` of b_g.
// In place, from the top: each row needs only the unchanged rows below it. The lower triangle
// counts; the upper one is copied from it at the end.
void Ekf::settle() noexcept {
  Since& s = since_;
  if (!(s.time_s > 0)) return;
  const double t = s.time_s;
  normalise(nominal_.q_NB);
  const Tail fp = tail_of(s.position), fv = tail_of(s.velocity);
  const auto ft = fv.middleCols<3>(3);  // psi by b_g is v by b_a

  // P F^T; unused rows are omitted, two at a time
  for (int i = 0; i < 3; ++i) {
    Column p = p_.col(kPosition + i) + t * p_.col(kVelocity + i);
    for (int k = 0; k < 9; ++k) p += fp(i, k) * p_.col(kAttitude + k);
    p_.col(kPosition + i) = p;
  }
  for (int i = 0; i < 3; ++i) {
    Eigen::Matrix<double, 14, 1> v = p_.col(kVelocity + i).tail<14>();
    for (int k = 0; k < 9; ++k) v += fv(i, k) * p_.col(kAttitude + k).tail<14>();
    p_.col(kVelocity + i).tail<14>() = v;
  }
  for (int i = 0; i < 3; ++i) {
    p_.col(kAttitude + i).tail<10>() += ft(i, 0) * p_.col(kRateBias).tail<10>() +
                                        ft(i, 1) * p_.col(kRateBias + 1).tail<10>() +
                                        ft(i, 2) * p_.col(kRateBias + 2).tail<10>();
  }
  // F of that
  for (int i = 0; i < 3; ++i) {
    p_.col(i).segment<3>(kPosition) +=
        t * p_.col(i).segment<3>(kVelocity) + times(fp, p_.col(i).segment<9>(kAttitude));
  }
  for (int i = 0; i < 6; ++i)
    p_.col(i).segment<3>(kVelocity) += times(fv, p_.col(i).segment<9>(kAttitude));
  for (int i = 0; i < 9; ++i)
    p_.col(i).segment<3>(kAttitude) += times(ft, p_.col(i).segment<3>(kRateBias));

  p_.diagonal().segment<3>(kPosition).array() += s.qpp;
  p_.block<3, 3>(kVelocity, kPosition).diagonal().array() += s.qpv;
  p_.diagonal().segment<3>(kVelocity).array() += s.qvv;
  p_.diagonal().segment<3>(kAttitude).array() += t * noise_.rate * noise_.rate;
  p_.diagonal().segment<3>(kForceBias).array() += t * noise_.force_bias * noise_.force_bias;
  p_.diagonal().segment<3>(kRateBias).array() += t * noise_.rate_bias * noise_.rate_bias;
  mirror();
  since_ = {};
}

double Ekf::correct(const Measurement& m, double gate) noexcept {
  settle();
  // P H^T
  const Column d = m.by_position * p_.col(kPosition + m.axis) +
                   m.by_velocity * p_.col(kVelocity + m.axis) +
                   m.by_rate_bias * p_.col(kRateBias + m.axis) +
                   p_.middleCols<3>(kAttitude).lazyProduct(m.by_attitude) +
                   p_.middleCols<3>(kForceBias).lazyProduct(m.by_force_bias);
  const double s = m.by_position * d(kPosition + m.axis) + m.by_velocity * d(kVelocity + m.axis) +
                   m.by_rate_bias * d(kRateBias + m.axis) +
                   m.by_attitude.dot(d.segment<3>(kAttitude)) +
                   m.by_force_bias.dot(d.segment<3>(kForceBias)) + m.variance;
  if (!(s > 0) || !(m.residual * m.residual <= gate * gate * s)) return s;
  // With this gain, d / s, Joseph's form is P - d d^T / s: written so that it stays symmetric to
  // the last bit.
  const double one_root = 1 / std::sqrt(s);
  const Column e = one_root * d;
  for (int i = 0; i < 15; ++i) p_.col(i) -= e(i) * e;
  inject(m.residual * one_root * e);
  return s;
}

void Ekf::inject(const Column& correction) noexcept {
  Nominal& x = nominal_;
  x.position_N_m += correction.segment<3>(kPosition);
  x.velocity_N_m_s += correction.segment<3>(kVelocity);
  x.accelerometer_bias_m_s2 += correction.segment<3>(kForceBias);
  x.gyro_bias_rad_s += correction.segment<3>(kRateBias);
  const Vector3 psi = correction.segment<3>(kAttitude);
  const Quaternion turn = exponential(psi);
  x.q_NB = turn * x.q_NB;
  normalise(x.q_NB);
  // Reset: I - [dth/2 x] about B, in the new axes; about N that is R (I - [psi/2 x]).
  const Matrix3 r = rotation(turn);
  const Matrix3 g = r - r * skew(psi / 2);
  auto columns = p_.middleCols<3>(kAttitude);
  columns = columns.lazyProduct(g.transpose()).eval();
  auto square = p_.block<3, 3>(kAttitude, kAttitude);
  square = g.lazyProduct(square).eval();
  square(0, 1) = square(1, 0);
  square(0, 2) = square(2, 0);
  square(1, 2) = square(2, 1);
  p_.block<3, 6>(kAttitude, kPosition) = p_.block<6, 3>(kPosition, kAttitude).transpose();
  p_.block<3, 6>(kAttitude, kForceBias) = p_.block<6, 3>(kForceBias, kAttitude).transpose();
}

Vector3 Ekf::attitude_variance() const noexcept {
  const Matrix3 c = rotation(nominal_.q_NB);
  return (c.transpose() * p_.block<3, 3>(kAttitude, kAttitude) * c).diagonal();
}

Matrix15 Ekf::covariance() const noexcept {
  const Matrix3 c = rotation(nominal_.q_NB);
  Matrix15 m = p_.topRows<15>();
  m.middleCols<3>(kAttitude) = (m.middleCols<3>(kAttitude) * c).eval();
  m.middleRows<3>(kAttitude) = (c.transpose() * m.middleRows<3>(kAttitude)).eval();
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < row; ++column) m(row, column) = m(column, row);
  }
  return m;
}

}  // namespace lss::gnc::talaris
