#include "gnc/talaris/ekf.h"

#include <cmath>

namespace lss::gnc::talaris {
namespace {

Matrix3 skew(const Vector3& v) noexcept {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// [v x] m
Matrix3 cross(const Vector3& v, const Matrix3& m) noexcept {
  Matrix3 r;
  r.row(0) = v.y() * m.row(2) - v.z() * m.row(1);
  r.row(1) = v.z() * m.row(0) - v.x() * m.row(2);
  r.row(2) = v.x() * m.row(1) - v.y() * m.row(0);
  return r;
}

// m [v x]^T
Matrix3 cross_right(const Matrix3& m, const Vector3& v) noexcept {
  Matrix3 r;
  r.col(0) = v.y() * m.col(2) - v.z() * m.col(1);
  r.col(1) = v.z() * m.col(0) - v.x() * m.col(2);
  r.col(2) = v.x() * m.col(1) - v.y() * m.col(0);
  return r;
}

// The mean of a matrix and its transpose: what should be symmetric is so to the last bit.
void make_symmetric(Matrix3& m) noexcept {
  m(0, 1) = m(1, 0) = (m(0, 1) + m(1, 0)) / 2;
  m(0, 2) = m(2, 0) = (m(0, 2) + m(2, 0)) / 2;
  m(1, 2) = m(2, 1) = (m(1, 2) + m(2, 1)) / 2;
}

Matrix3 rotation(const Quaternion& q) noexcept { return q.toRotationMatrix(); }

// One Newton step: a product of unit quaternions is off by rounding only.
void normalise(Quaternion& q) noexcept { q.coeffs() *= 1.5 - 0.5 * q.squaredNorm(); }

}  // namespace

Quaternion exponential(const Vector3& angle) noexcept {
  const double h2 = angle.squaredNorm() / 4;
  double c, s;  // cos h, sin(h) / (2 h)
  // series of which the rest is below 1e-17; no division, this is done for every sample
  if (h2 < 1e-5) {
    c = 1 - h2 * (0.5 - h2 * (1.0 / 24));
    s = 0.5 - h2 * (1.0 / 12 - h2 * (1.0 / 240));
  } else if (h2 < 0.01) {
    c = 1 - h2 * (0.5 - h2 * (1.0 / 24 - h2 * (1.0 / 720 - h2 * (1.0 / 40320 - h2 / 3628800))));
    s = 0.5 - h2 * (1.0 / 12 - h2 * (1.0 / 240 - h2 * (1.0 / 10080 - h2 / 725760)));
  } else {
    const double h = std::sqrt(h2);
    c = std::cos(h);
    s = std::sin(h) / (2 * h);
  }
  return {c, s * angle.x(), s * angle.y(), s * angle.z()};
}

ExpectedRange expected_range(const Nominal& nominal, const Beam& beam) noexcept {
  // row of C that belongs to the axis, seen from the plane
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
  pp_ = p.block<3, 3>(0, 0);
  pv_ = p.block<3, 3>(0, 3);
  pt_ = p.block<3, 3>(0, 6) * c.transpose();
  pa_ = p.block<3, 3>(0, 9);
  pg_ = p.block<3, 3>(0, 12);
  vv_ = p.block<3, 3>(3, 3);
  vt_ = p.block<3, 3>(3, 6) * c.transpose();
  va_ = p.block<3, 3>(3, 9);
  vg_ = p.block<3, 3>(3, 12);
  tt_ = c * p.block<3, 3>(6, 6) * c.transpose();
  ta_ = c * p.block<3, 3>(6, 9);
  tg_ = c * p.block<3, 3>(6, 12);
  aa_ = p.block<3, 3>(9, 9);
  ag_ = p.block<3, 3>(9, 12);
  gg_ = p.block<3, 3>(12, 12);
  make_symmetric(tt_);
}

void Ekf::propagate(double dt, const Vector3& rate, const Vector3& force) noexcept {
  Nominal& x = nominal_;
  const Quaternion half = exponential((rate - x.gyro_bias_rad_s) * (dt / 2));
  const Quaternion middle = x.q_NB * half;
  const Matrix3 c = rotation(middle);
  const Vector3 f = c * (force - x.accelerometer_bias_m_s2);
  acceleration_ = f;
  acceleration_.x() -= gravity_m_s2_;
  x.position_N_m += dt * (x.velocity_N_m_s + (dt / 2) * acceleration_);
  x.velocity_N_m_s += dt * acceleration_;
  // half * half; settle() takes off what rounding did to the length
  const double twice = 2 * half.w();
  x.q_NB = x.q_NB *
           Quaternion(twice * half.w() - 1, twice * half.x(), twice * half.y(), twice * half.z());

  Since& s = since_;
  const Vector3 df = dt * f;
  s.pg += dt * s.vg;
  for (int i = 0; i < 3; ++i) {  // += [df x] va, without a matrix in between
    const double a = s.va(0, i), b = s.va(1, i), d = s.va(2, i);
    s.vg(0, i) += df.y() * d - df.z() * b;
    s.vg(1, i) += df.z() * a - df.x() * d;
    s.vg(2, i) += df.x() * b - df.y() * a;
  }
  s.pt += dt * s.vt;
  s.vt += df;
  s.pa += dt * s.va;
  s.va += dt * c;
  s.qpp += dt * (2 * s.qpv + dt * s.qvv);
  s.qpv += dt * s.qvv;
  s.qvv += dt * noise_.force * noise_.force;
  s.time_s += dt;
}

void Ekf::blur(double position, double velocity, double attitude) noexcept {
  settle();
  pp_.diagonal().array() += position;
  vv_.diagonal().array() += velocity;
  tt_.diagonal().array() += attitude;
}

void Ekf::blur_axis(int axis, double position, double velocity) noexcept {
  settle();
  pp_(axis, axis) += position;
  vv_(axis, axis) += velocity;
}

// P <- F P F^T + Q, F made of the sums in Since.
void Ekf::settle() noexcept {
  const Since& s = since_;
  if (!(s.time_s > 0)) return;
  const double t = s.time_s;
  normalise(nominal_.q_NB);

  // dp, before anything below it changes
  Matrix3 up = pp_ + t * pv_.transpose() - cross(s.pt, pt_.transpose());
  up.noalias() -= s.pa * pa_.transpose();
  up.noalias() += s.pg * pg_.transpose();
  Matrix3 uv = pv_ + t * vv_ - cross(s.pt, vt_.transpose());
  uv.noalias() -= s.pa * va_.transpose();
  uv.noalias() += s.pg * vg_.transpose();
  Matrix3 ut = pt_ + t * vt_ - cross(s.pt, tt_);
  ut.noalias() -= s.pa * ta_.transpose();
  ut.noalias() += s.pg * tg_.transpose();
  Matrix3 ua = pa_ + t * va_ - cross(s.pt, ta_);
  ua.noalias() -= s.pa * aa_;
  ua.noalias() += s.pg * ag_.transpose();
  Matrix3 ug = pg_ + t * vg_ - cross(s.pt, tg_);
  ug.noalias() -= s.pa * ag_;
  ug.noalias() += s.pg * gg_;
  pp_ = up + t * uv - cross_right(ut, s.pt);
  pp_.noalias() -= ua * s.pa.transpose();
  pp_.noalias() += ug * s.pg.transpose();
  pv_ = uv - cross_right(ut, s.vt);
  pv_.noalias() -= ua * s.va.transpose();
  pv_.noalias() += ug * s.vg.transpose();
  pt_ = ut;
  pt_.noalias() -= ug * s.va.transpose();
  pa_ = ua;
  pg_ = ug;

  // dv
  Matrix3 wv = vv_ - cross(s.vt, vt_.transpose());
  wv.noalias() -= s.va * va_.transpose();
  wv.noalias() += s.vg * vg_.transpose();
  Matrix3 wt = vt_ - cross(s.vt, tt_);
  wt.noalias() -= s.va * ta_.transpose();
  wt.noalias() += s.vg * tg_.transpose();
  va_ -= cross(s.vt, ta_);
  va_.noalias() -= s.va * aa_;
  va_.noalias() += s.vg * ag_.transpose();
  vg_ -= cross(s.vt, tg_);
  vg_.noalias() -= s.va * ag_;
  vg_.noalias() += s.vg * gg_;
  vv_ = wv - cross_right(wt, s.vt);
  vv_.noalias() -= va_ * s.va.transpose();
  vv_.noalias() += vg_ * s.vg.transpose();
  vt_ = wt;
  vt_.noalias() -= vg_ * s.va.transpose();

  // psi
  Matrix3 tt = tt_;
  tt.noalias() -= s.va * tg_.transpose();
  ta_.noalias() -= s.va * ag_.transpose();
  tg_.noalias() -= s.va * gg_;
  tt_ = tt;
  tt_.noalias() -= tg_ * s.va.transpose();

  pp_.diagonal().array() += s.qpp;
  pv_.diagonal().array() += s.qpv;
  vv_.diagonal().array() += s.qvv;
  tt_.diagonal().array() += t * noise_.rate * noise_.rate;
  aa_.diagonal().array() += t * noise_.force_bias * noise_.force_bias;
  gg_.diagonal().array() += t * noise_.rate_bias * noise_.rate_bias;
  make_symmetric(pp_);
  make_symmetric(vv_);
  make_symmetric(tt_);
  since_ = {};
}

Ekf::Column Ekf::times_derivative(const Measurement& m) const noexcept {
  const int i = m.axis;
  const double hp = m.by_position, hv = m.by_velocity;
  const Vector3& ht = m.by_attitude;
  Column d;
  d.p = hp * pp_.col(i) + hv * pv_.col(i) + pt_ * ht;
  d.v = hp * pv_.row(i).transpose() + hv * vv_.col(i) + vt_ * ht;
  d.t = hp * pt_.row(i).transpose() + hv * vt_.row(i).transpose() + tt_ * ht;
  d.a = hp * pa_.row(i).transpose() + hv * va_.row(i).transpose() + ta_.transpose() * ht;
  d.g = hp * pg_.row(i).transpose() + hv * vg_.row(i).transpose() + tg_.transpose() * ht;
  return d;
}

double Ekf::correct(const Measurement& m, double gate) noexcept {
  settle();
  const Column d = times_derivative(m);
  const double s = m.by_position * d.p(m.axis) + m.by_velocity * d.v(m.axis) +
                   m.by_attitude.dot(d.t) + m.variance;
  if (!(s > 0) || !(m.residual * m.residual <= gate * gate * s)) return s;
  const double one_s = 1 / s;
  const Column k{one_s * d.p, one_s * d.v, one_s * d.t, one_s * d.a, one_s * d.g};
  // Joseph's form multiplied out: P - k d^T - d k^T + k s k^T, symmetric as it stands
  const auto joseph = [s](Matrix3& block, const Vector3& ki, const Vector3& di, const Vector3& kj,
                          const Vector3& dj) {
    const Vector3 left = s * kj - dj;
    for (int c = 0; c < 3; ++c) block.col(c) += left(c) * ki - kj(c) * di;
  };
  joseph(pp_, k.p, d.p, k.p, d.p);
  joseph(pv_, k.p, d.p, k.v, d.v);
  joseph(pt_, k.p, d.p, k.t, d.t);
  joseph(pa_, k.p, d.p, k.a, d.a);
  joseph(pg_, k.p, d.p, k.g, d.g);
  joseph(vv_, k.v, d.v, k.v, d.v);
  joseph(vt_, k.v, d.v, k.t, d.t);
  joseph(va_, k.v, d.v, k.a, d.a);
  joseph(vg_, k.v, d.v, k.g, d.g);
  joseph(tt_, k.t, d.t, k.t, d.t);
  joseph(ta_, k.t, d.t, k.a, d.a);
  joseph(tg_, k.t, d.t, k.g, d.g);
  joseph(aa_, k.a, d.a, k.a, d.a);
  joseph(ag_, k.a, d.a, k.g, d.g);
  joseph(gg_, k.g, d.g, k.g, d.g);
  make_symmetric(pp_);
  make_symmetric(vv_);
  make_symmetric(tt_);
  make_symmetric(aa_);
  make_symmetric(gg_);
  inject(k, m.residual);
  return s;
}

void Ekf::inject(const Column& k, double residual) noexcept {
  Nominal& x = nominal_;
  x.position_N_m += residual * k.p;
  x.velocity_N_m_s += residual * k.v;
  x.accelerometer_bias_m_s2 += residual * k.a;
  x.gyro_bias_rad_s += residual * k.g;
  const Vector3 psi = residual * k.t;
  const Quaternion turn = exponential(psi);
  x.q_NB = turn * x.q_NB;
  normalise(x.q_NB);
  // Reset: I - [dth/2 x] about B, in the new axes; about N that is R (I - [psi/2 x]).
  const Matrix3 r = rotation(turn);
  const Matrix3 g = r - r * skew(psi / 2);
  pt_ *= g.transpose();
  vt_ *= g.transpose();
  tt_ = g * tt_ * g.transpose();
  ta_ = g * ta_;
  tg_ = g * tg_;
  make_symmetric(tt_);
}

Vector3 Ekf::attitude_variance() const noexcept {
  const Matrix3 c = rotation(nominal_.q_NB);
  return (c.transpose() * tt_ * c).diagonal();
}

Matrix15 Ekf::covariance() const noexcept {
  const Matrix3 c = rotation(nominal_.q_NB);
  Matrix15 m;
  m.block<3, 3>(0, 0) = pp_;
  m.block<3, 3>(0, 3) = pv_;
  m.block<3, 3>(0, 6) = pt_ * c;
  m.block<3, 3>(0, 9) = pa_;
  m.block<3, 3>(0, 12) = pg_;
  m.block<3, 3>(3, 3) = vv_;
  m.block<3, 3>(3, 6) = vt_ * c;
  m.block<3, 3>(3, 9) = va_;
  m.block<3, 3>(3, 12) = vg_;
  m.block<3, 3>(6, 6) = c.transpose() * tt_ * c;
  m.block<3, 3>(6, 9) = c.transpose() * ta_;
  m.block<3, 3>(6, 12) = c.transpose() * tg_;
  m.block<3, 3>(9, 9) = aa_;
  m.block<3, 3>(9, 12) = ag_;
  m.block<3, 3>(12, 12) = gg_;
  for (int row = 0; row < 15; ++row) {
    for (int column = 0; column < row; ++column) m(row, column) = m(column, row);
  }
  return m;
}

}  // namespace lss::gnc::talaris
