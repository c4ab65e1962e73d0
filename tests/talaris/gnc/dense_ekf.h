#pragma once

// The same filter written down as its equations stand in gnc/talaris/ekf.h: errors about the
// axes of B, one dense 15 x 15 transition for each sample, dense corrections in Joseph's form. The
// reference of gnc/talaris/ekf.h for its numbers and for its speed.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>

namespace lss::gnc::talaris::test {

class DenseEkf {
 public:
  using Vector = Eigen::Matrix<double, 15, 1>;
  using Matrix = Eigen::Matrix<double, 15, 15>;
  using V3 = Eigen::Vector3d;
  using M3 = Eigen::Matrix3d;

  // begin_of_step: blocks as if nothing turned within a sample, noise with every sample.
  // middle_of_step: the derivative taken where the force is, noise with every correction.
  enum class Form { begin_of_step, middle_of_step };

  Form form = Form::middle_of_step;
  double force_noise = 0, rate_noise = 0, force_bias_walk = 0, rate_bias_walk = 0;
  double gravity = 9.80665;
  V3 p = V3::Zero(), v = V3::Zero(), ba = V3::Zero(), bg = V3::Zero();
  Eigen::Quaterniond q = Eigen::Quaterniond::Identity();
  Matrix P = Matrix::Zero();

  // From the state of gnc/talaris/ekf.h.
  template <class Nominal>
  void start(const Nominal& x, const Matrix& covariance) {
    p = x.position_N_m;
    v = x.velocity_N_m_s;
    q = x.q_NB;
    ba = x.accelerometer_bias_m_s2;
    bg = x.gyro_bias_rad_s;
    P = covariance;
  }

  static M3 skew(const V3& a) {
    return (M3() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
  }
  static Eigen::Quaterniond exponential(const V3& a) {
    const double angle = a.norm();
    if (angle < 1e-300) return Eigen::Quaterniond::Identity();
    return Eigen::Quaterniond(Eigen::AngleAxisd(angle, a / angle));
  }

  // dth_new = turn dth - ..., with `turn` over the whole sample and `half` over half of it.
  Matrix transition(double dt, const V3& rate, const V3& force) const {
    const V3 w = rate - bg, a = force - ba;
    const M3 c = (q * exponential(w * dt / 2)).toRotationMatrix();
    const M3 half = exponential(w * dt / 2).toRotationMatrix().transpose();
    const bool middle = form == Form::middle_of_step;
    Matrix f = Matrix::Identity();
    f.block<3, 3>(0, 3) = M3::Identity() * dt;
    f.block<3, 3>(3, 6) = -c * skew(a) * dt;
    if (middle) f.block<3, 3>(3, 6) = f.block<3, 3>(3, 6).eval() * half;
    f.block<3, 3>(3, 9) = -c * dt;
    f.block<3, 3>(6, 6) = exponential(w * dt).toRotationMatrix().transpose();
    f.block<3, 3>(6, 12) = -M3::Identity() * dt;
    if (middle) f.block<3, 3>(6, 12) = -half * dt;
    return f;
  }

  void propagate(double dt, const V3& rate, const V3& force) {
    const Matrix f = transition(dt, rate, force);
    const V3 w = rate - bg, a = force - ba;
    const V3 acc = (q * exponential(w * dt / 2)) * a - V3(gravity, 0, 0);
    p += v * dt + acc * dt * dt / 2;
    v += acc * dt;
    q = (q * exponential(w * dt)).normalized();
    Matrix step = Matrix::Zero();
    step.diagonal().segment<3>(3).setConstant(force_noise * force_noise * dt);
    Matrix rest = Matrix::Zero();
    rest.diagonal().segment<3>(6).setConstant(rate_noise * rate_noise * dt);
    rest.diagonal().segment<3>(9).setConstant(force_bias_walk * force_bias_walk * dt);
    rest.diagonal().segment<3>(12).setConstant(rate_bias_walk * rate_bias_walk * dt);
    P = f * P * f.transpose();
    if (form == Form::begin_of_step) {
      P += step + rest;
      return;
    }
    Matrix way = Matrix::Identity();  // of the velocity's noise into the position
    way.block<3, 3>(0, 3) = M3::Identity() * dt;
    noise_ = way * noise_ * way.transpose() + step;
    noise_ += rest;
  }

  void settle() {
    P += noise_;
    noise_.setZero();
  }

  // One range: h(x) and its derivative are the caller's. Returns the variance of the residual.
  double correct(const Vector& h, double residual, double variance, double gate = 1e300) {
    settle();
    const double s = h.dot(P * h) + variance;
    if (residual * residual > gate * gate * s) return s;
    const Vector k = P * h / s;
    const Matrix i_kh = Matrix::Identity() - k * h.transpose();
    P = (i_kh * P * i_kh.transpose()).eval() + k * variance * k.transpose();
    const Vector dx = k * residual;
    add(dx);
    Matrix g = Matrix::Identity();
    g.block<3, 3>(6, 6) -= skew(V3(dx.segment<3>(6)) / 2);
    P = (g * P * g.transpose()).eval();
    return s;
  }

  void add(const Vector& dx) {
    p += dx.segment<3>(0);
    v += dx.segment<3>(3);
    q = (q * exponential(dx.segment<3>(6))).normalized();
    ba += dx.segment<3>(9);
    bg += dx.segment<3>(12);
  }

  // The difference from this state to `other`.
  Vector minus(const DenseEkf& other) const {
    Vector d;
    d.segment<3>(0) = p - other.p;
    d.segment<3>(3) = v - other.v;
    Eigen::Quaterniond e = other.q.conjugate() * q;
    if (e.w() < 0) e.coeffs() *= -1;
    const double n = e.vec().norm();
    d.segment<3>(6) = n < 1e-12 ? V3(2 * e.vec()) : V3(e.vec() / n * 2 * std::atan2(n, e.w()));
    d.segment<3>(9) = ba - other.ba;
    d.segment<3>(12) = bg - other.bg;
    return d;
  }

 private:
  Matrix noise_ = Matrix::Zero();  // since the last correction
};

}  // namespace lss::gnc::talaris::test
