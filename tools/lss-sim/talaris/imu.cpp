#include "tools/lss-sim/talaris/imu.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

namespace lss::sim::talaris {
namespace {

constexpr double kInside_degC = 25.12;
constexpr int kMostSummed = 20;  // milliseconds in the mean of a packet

std::int16_t counts(double value, double scale) {
  return static_cast<std::int16_t>(std::clamp(std::round(value / scale), -32768.0, 32767.0));
}

std::uint8_t low(int value) { return static_cast<std::uint8_t>(value & 0xFF); }
std::uint8_t high(int value) { return static_cast<std::uint8_t>(value >> 8 & 0xFF); }

}  // namespace

Imu::Imu(const ImuOptions& options, unsigned seed) : options_(options), random_(seed) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    bias_.rate_rad_s[i] = normal(options.gyro_bias_rad_s);
    bias_.force_m_s2[i] = normal(options.accel_bias_m_s2);
  }
  const Vector3 turned(normal(options.misaligned_rad), normal(options.misaligned_rad),
                       normal(options.misaligned_rad));
  const double angle = turned.norm();
  const Eigen::Matrix3d mounted = angle > 0
                                      ? Eigen::AngleAxisd(angle, turned / angle).toRotationMatrix()
                                      : Eigen::Matrix3d(Eigen::Matrix3d::Identity());
  const auto sees = [&](double scale) -> Eigen::Matrix3d {
    Eigen::Matrix3d m = Eigen::Matrix3d::Identity();
    for (Eigen::Index row = 0; row < 3; ++row) {
      for (Eigen::Index column = 0; column < 3; ++column)
        m(row, column) += normal(row == column ? scale : options.skewed_rad);
    }
    return m * mounted;
  };
  sees_rate_ = sees(options.gyro_scale);
  sees_force_ = sees(options.accel_scale);
}

double Imu::normal(double deviation) {
  return deviation > 0 ? std::normal_distribution<double>(0, deviation)(random_) : 0;
}

void Imu::step(const Inertial& truth) {
  const std::lock_guard lock(mutex_);
  time_ns_ += kMillisecond;
  latest_ = {sees_rate_ * truth.rate_rad_s, sees_force_ * truth.force_m_s2};
  // It moves to and fro: the angle and the speed that it adds do not grow.
  const double share = truth.shaking / std::numbers::sqrt2;
  const auto shake = [&](double& value, double& before, double deviation) {
    const double now = normal(deviation);
    value += now - before;
    before = now;
  };
  for (Eigen::Index i = 0; i < 3; ++i) {
    shake(latest_.rate_rad_s[i], shaken_.rate_rad_s[i], options_.vibration_rad_s * share);
    shake(latest_.force_m_s2[i], shaken_.force_m_s2[i], options_.vibration_m_s2 * share);
  }
  if (summed_ == kMostSummed) {  // not requested
    sum_ = {};
    summed_ = 0;
  }
  sum_.rate_rad_s += latest_.rate_rad_s;
  sum_.force_m_s2 += latest_.force_m_s2;
  ++summed_;
  tick();
}

Inertial Imu::measure() {
  Inertial mean = latest_;
  const double dt_s = summed_ * kStep_s;
  if (summed_ > 0) {
    mean = {sum_.rate_rad_s / summed_, sum_.force_m_s2 / summed_};
  }
  sum_ = {};
  summed_ = 0;
  if (faults_.stuck) return last_;
  for (Eigen::Index i = 0; i < 3; ++i) {
    bias_.rate_rad_s[i] += normal(options_.gyro_walk_rad_s_rts * std::sqrt(dt_s));
    bias_.force_m_s2[i] += normal(options_.accel_walk_m_s2_rts * std::sqrt(dt_s));
    const auto axis = static_cast<std::size_t>(i);
    mean.rate_rad_s[i] += bias_.rate_rad_s[i] + faults_.bias[axis] +
                          normal(options_.gyro_noise_rad_s * faults_.noise);
    mean.force_m_s2[i] += bias_.force_m_s2[i] + faults_.bias[axis + 3] +
                          normal(options_.accel_noise_m_s2 * faults_.noise);
  }
  return last_ = mean;
}

Imu::Packet Imu::spoil(Packet packet) {
  if (strikes(faults_.checksum, random_))
    packet.back() = static_cast<std::uint8_t>(packet.back() ^ 0x5A);
  for (std::uint8_t& byte : packet) {
    if (!strikes(faults_.parity, random_)) continue;
    byte = static_cast<std::uint8_t>(byte ^ (1 << std::uniform_int_distribution(0, 7)(random_)));
  }
  return packet;
}

void Imu::say(const Packet& packet) {
  if (!faults_.silent) queue(spoil(packet));
}

Inertial Imu::bias() const {
  const std::lock_guard lock(mutex_);
  return bias_;
}

// ---- Gladiator LandMark 30

double LandMark::gyro_scale(std::uint8_t status) {
  const unsigned code = status & 0x31u;
  const double degrees = code == 0x11 ? 0.015 : code == 0x21 ? 0.05 : code == 0x31 ? 0.005 : 0.01;
  return degrees * kDegree;
}

double LandMark::accel_scale(std::uint8_t status) {
  constexpr double kScales_g[] = {1e-3, 1e-4, 1e-4, 5e-4, 5e-4, 5e-4, 1e-3, 2e-3};
  return kScales_g[status >> 1 & 7] * kGravity_m_s2;
}

Imu::Packet LandMark::encode(std::uint8_t counter, const std::array<std::int16_t, 7>& values,
                             std::uint8_t status) {
  Packet packet{0x2A, counter};
  for (std::size_t i = 0; i < values.size(); ++i) {
    packet[2 + 2 * i] = low(values[i]);
    packet[3 + 2 * i] = high(values[i]);
  }
  packet[16] = status;
  packet[17] = low(-std::accumulate(packet.begin(), packet.end(), 0));
  return packet;
}

void LandMark::tick() {
  if (++since_ms_ < period_ms_) return;
  since_ms_ = 0;
  if (paused_) return;
  const std::uint8_t scales = faults_.scale.value_or(0);
  const double gyro = gyro_scale(scales), accel = accel_scale(scales);
  const Inertial felt = measure();
  const Vector3& w = felt.rate_rad_s;
  const Vector3& f = felt.force_m_s2;
  say(encode(counter_,
             {counts(w.x(), gyro), counts(w.y(), gyro), counts(w.z(), gyro), counts(f.x(), accel),
              counts(f.y(), accel), counts(f.z(), accel), counts(kInside_degC, 0.01)},
             status()));
  if (++counter_ == 0) ++wraps_;
}

// The status byte at this count: identity, then flags and scales in turn.
std::uint8_t LandMark::status() const {
  constexpr std::uint8_t kFirmware[] = {2, 6}, kProduct[] = {0x80 | 30, 0x80 | 1};
  constexpr std::uint8_t kBoard[] = {0x47, 0x4C, 0x33, 0x30}, kSerial[] = {0x00, 0x01, 0x02, 0x11};
  constexpr std::uint8_t kFilter = 4;
  const unsigned n = counter_;
  if (n < 2) return wraps_ % 2 == 0 ? kFirmware[n] : kProduct[n];
  if (n == 247) return kFilter;
  if (n >= 252) return kSerial[n - 252];
  if (n >= 248) return kBoard[n - 248];
  return n % 2 == 0 ? 0 : static_cast<std::uint8_t>(0x40 | faults_.scale.value_or(0));
}

void LandMark::jump(int packets) {
  const std::lock_guard lock(mutex_);
  const int to = counter_ + packets;
  wraps_ += static_cast<unsigned>(to >> 8);
  counter_ = low(to);
}

// Half duplex: it must be paused before it can receive a message of eight bytes.
std::span<const std::uint8_t> LandMark::receive(std::uint8_t character, TimeNs) {
  const std::lock_guard lock(mutex_);
  constexpr std::uint8_t kPause = 0xD4, kMessage = 0x2B;
  constexpr int kPauses = 10;
  pauses_ = character == kPause ? pauses_ + 1 : 0;
  if (pauses_ >= kPauses) paused_ = true;
  if (command_.empty() && character != kMessage) return {};
  command_.push_back(character);
  if (command_.size() < 8) return {};
  if (low(std::accumulate(command_.begin(), command_.end(), 0)) == 0) obey(command_[1]);
  command_.clear();
  return {};
}

void LandMark::obey(std::uint8_t command) {
  if (command == 0x0D) paused_ = false;
  if (command == 0x02) period_ms_ = 5;
  if (command == 0x0A) period_ms_ = 10;
}

// ---- Crossbow

namespace {

constexpr double kRateRange = 100 * 1.5 / 32768 * kDegree;  // of a count
constexpr double kForceRange = 2 * 1.5 / 32768 * kGravity_m_s2;
constexpr double kTick_s = 0.79e-6;
constexpr int kContinuous_ms = 10;

}  // namespace

Imu::Packet Crossbow::encode(const std::array<std::int16_t, 6>& values, std::uint16_t temperature,
                             std::uint16_t time) {
  Packet packet{0xFF};
  for (std::size_t i = 0; i < values.size(); ++i) {
    packet[1 + 2 * i] = high(values[i]);
    packet[2 + 2 * i] = low(values[i]);
  }
  packet[13] = high(temperature);
  packet[14] = low(temperature);
  packet[15] = high(time);
  packet[16] = low(time);
  packet[17] = low(std::accumulate(packet.begin() + 1, packet.begin() + 17, 0));
  return packet;
}

Imu::Packet Crossbow::packet() {
  const Inertial felt = measure();
  const Vector3& w = felt.rate_rad_s;
  const Vector3& f = felt.force_m_s2;
  const double volts = kInside_degC / 44.44 + 1.375;
  const auto ticks = std::llround(static_cast<double>(time_ns_) * 1e-9 / kTick_s);
  return encode(
      {counts(w.x(), kRateRange), counts(w.y(), kRateRange), counts(w.z(), kRateRange),
       counts(f.x(), kForceRange), counts(f.y(), kForceRange), counts(f.z(), kForceRange)},
      static_cast<std::uint16_t>(std::lround(volts * 4096 / 5)),
      static_cast<std::uint16_t>(-ticks & 0xFFFF));
}

void Crossbow::tick() {
  if (!continuous_ || ++since_ms_ < kContinuous_ms) return;
  since_ms_ = 0;
  say(packet());
}

std::span<const std::uint8_t> Crossbow::receive(std::uint8_t character, TimeNs) {
  const std::lock_guard lock(mutex_);
  if (faults_.silent) return {};
  const auto answer = [&](char letter) {
    reply_[0] = static_cast<std::uint8_t>(letter);
    return std::span<const std::uint8_t>(reply_).first(1);
  };
  switch (character) {
    case 'R': continuous_ = false; return answer('H');
    case 'c': return answer('C');
    case 'P': continuous_ = false; return {};
    case 'C': continuous_ = true; return {};
    case 'G': reply_ = spoil(packet()); return reply_;
    default: return {};
  }
}

std::unique_ptr<Imu> make_imu(const ImuOptions& options, unsigned seed) {
  if (options.kind == ImuKind::crossbow) return std::make_unique<Crossbow>(options, seed);
  return std::make_unique<LandMark>(options, seed);
}

}  // namespace lss::sim::talaris
