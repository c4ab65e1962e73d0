#pragma once

// The inertial measurement units of TALARIS on their serial lines: Gladiator LandMark 30 (RS-485,
// 115200 8E2, 200 packets a second by itself; TALARIS thesis 4.4.4, table 2) and Crossbow (RS-232,
// 38400 8N1, polled; 5.3.1, 5.3.2). Written from docs/icd-talaris.md, not from the daemon's
// drivers. Body frame B as in plant.h. Threads as in sensor.h.

#include <array>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <random>

#include "idl/angles.h"
#include "tools/lss-sim/talaris/plant.h"
#include "tools/lss-sim/talaris/sensor.h"

namespace lss::sim::talaris {

enum class ImuKind : std::uint8_t { landmark, crossbow };

// Standard deviations; of noise in one packet, of biases at power-on.
struct ImuOptions {
  ImuKind kind = ImuKind::landmark;
  double gyro_noise_rad_s = 0.05 * kDegree;
  double accel_noise_m_s2 = 0.01;
  double gyro_bias_rad_s = 0.1 * kDegree;
  double accel_bias_m_s2 = 0.03;
  double gyro_walk_rad_s_rts = 0.002 * kDegree;  // of the bias, in a square root of a second
  double accel_walk_m_s2_rts = 2e-4;
  double gyro_scale = 0;  // errors of scale and of the axes' directions, standard deviations (ours)
  double accel_scale = 0;
  double misaligned_rad = 0;   // all axes together, and
  double skewed_rad = 0;       // each against the others
  double vibration_m_s2 = 0;   // of a millisecond, with all fans at 29,400 rpm
  double vibration_rad_s = 0;  // the same
};

struct ImuFaults {
  bool silent = false;
  bool stuck = false;                   // values freeze, the counter runs on
  double checksum = 0;                  // probability that a packet has a wrong one
  double parity = 0;                    // ... that a byte has a wrong bit
  double noise = 1;                     // factor
  std::optional<std::uint8_t> scale{};  // the unit changes to the scales of this status
  std::array<double, 6> bias{};         // rad/s about x, y, z; m/s2 along x, y, z
};

// Its input: mean since the last packet.
struct Inertial {
  Vector3 rate_rad_s = Vector3::Zero();
  Vector3 force_m_s2 = Vector3::Zero();
  double shaking = 0;  // by the fans, as a share of ImuOptions'
};

class Imu : public Sensor<ImuFaults> {
 public:
  Imu(const ImuOptions& options, unsigned seed);

  void step(const Inertial& truth);  // a millisecond
  virtual void jump(int) {}          // the counter jumps by this many
  Inertial bias() const;             // the present value, without faults

 protected:
  using Packet = std::array<std::uint8_t, 18>;

  virtual void tick() = 0;  // after each step, locked
  // The mean since it was called last, with all errors. Locked.
  Inertial measure();
  void say(const Packet& packet);
  Packet spoil(Packet packet);

  TimeNs time_ns_ = 0;  // its own

 private:
  double normal(double deviation);

  ImuOptions options_;
  std::mt19937 random_;
  Inertial bias_, sum_, latest_, last_, shaken_;
  Eigen::Matrix3d sees_rate_ = Eigen::Matrix3d::Identity(), sees_force_ = sees_rate_;
  int summed_ = 0;
};

class LandMark final : public Imu {
 public:
  LandMark(const ImuOptions& options, unsigned seed) : Imu(options, seed) {}
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) override;
  void jump(int packets) override;

  // Scales of a status byte: rad/s and m/s2 of one count.
  static double gyro_scale(std::uint8_t status);
  static double accel_scale(std::uint8_t status);
  // A packet from its counts, with checksum.
  static Packet encode(std::uint8_t counter, const std::array<std::int16_t, 7>& counts,
                       std::uint8_t status);

 private:
  void tick() override;
  std::uint8_t status() const;
  void obey(std::uint8_t command);

  std::uint8_t counter_ = 0;
  unsigned wraps_ = 0;
  int period_ms_ = 5, since_ms_ = 0;
  bool paused_ = false;
  int pauses_ = 0;  // consecutive characters of the request
  std::deque<std::uint8_t> command_;
};

class Crossbow final : public Imu {
 public:
  Crossbow(const ImuOptions& options, unsigned seed) : Imu(options, seed) {}
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) override;

  static Packet encode(const std::array<std::int16_t, 6>& counts, std::uint16_t temperature,
                       std::uint16_t time);

 private:
  void tick() override;
  Packet packet();

  bool continuous_ = false;
  int since_ms_ = 0;
  Packet reply_{};
};

std::unique_ptr<Imu> make_imu(const ImuOptions& options, unsigned seed);

}  // namespace lss::sim::talaris
