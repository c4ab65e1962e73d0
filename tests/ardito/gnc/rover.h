#pragma once

// A rover for closed loops without a simulator: wheels that follow their drives, a chassis that
// goes as its driven wheels do, wheels with an open clutch that roll along, currents, sensors with
// noise and quantisation, and every failure of the Ardito thesis' section 19. One step is a frame.

#include <functional>
#include <random>

#include "gnc/ardito/redundant.h"

namespace lss::gnc::ardito::test {

enum class Broken : std::uint8_t { no, zero, stuck };

struct WheelFaults {
  Broken motor_encoder = Broken::no;      // E-TM
  Broken hall = Broken::no;               // H-TM
  Broken reduction_encoder = Broken::no;  // E-TRG
  bool motor_blocked = false;             // TM
  bool motor_dead = false;                // TM without torque: the wheel drags it along
  bool reduction = false;                 // TRG: the wheel cannot turn
  bool clutch = false;                    // TC: transmits nothing
};

struct SteeringFaults {
  Broken motor_encoder = Broken::no;      // E-SM
  Broken reduction_encoder = Broken::no;  // E-SRG
  bool motor = false;                     // SM, SRG: stands
};

struct Noise {
  double motor_rpm = 0.1;  // of the wheel
  double reduction_rpm = 0.15;
  double steering_rad = 5e-4;
  double rocker_rad = 2e-4;
  double imu_m_s = 0.008;
  double current = 0.005;
  double load = 0.06;       // how much the ground changes
  double ground_rad = 0.1;  // of rockers and bogies, about
};

class Rover {
 public:
  explicit Rover(unsigned seed = 1, const Parameters& parameters = {});

  Request request;
  Noise noise;
  PerWheel<WheelFaults> wheel_faults;
  PerSteered<SteeringFaults> steering_faults;
  double drive_load = 0.25;  // mean current above no load

  // The last decision of the controller, and its input.
  Command command;
  Measured measured;
  // Put between sensors and controller.
  void (*tamper)(Measured&) = nullptr;

  void step();
  void run(double seconds);
  // Until it stands or drives as asked, at most so long.
  bool settle(double seconds = 20);
  const Command& control() const { return command; }
  double true_speed_m_s() const { return v_m_s_; }
  double true_yaw_rate_rad_s() const;
  const PerSteered<double>& true_steering_rad() const { return steering_rad_; }
  Redundant& redundant() { return redundant_; }

 private:
  double gauss(double sigma);
  void steer(std::size_t i, double goal_rad);
  void move();
  void measure();

  Parameters parameters_;
  Redundant redundant_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  PerWheel<double> motor_rad_s_{};  // at the wheel
  PerWheel<double> wheel_rad_s_{};
  PerWheel<double> load_{};
  PerWheel<double> current_{};
  PerSteered<double> steering_rad_{}, steering_rad_s_{};
  double v_m_s_ = 0;
  Direction direction_;
  std::array<double, 3> rocker_rad_{}, rocker_rate_rad_s_{};
  WheelPoses poses_;
  PerWheel<double> vx_m_s_{}, vz_m_s_{};
  std::uint32_t frame_ = 0;
};

// A rover that drives at this speed and heading for two seconds.
Rover driving_rover(unsigned seed, double speed, double sigma_deg = 0, double then_s = 2);
// With seed 5, one second after it has settled.
inline Rover driving(double speed = 0.6) { return driving_rover(5, speed, 0, 1); }
// Frames until `condition`, at most `most`.
int frames_until(Rover& rover, int most, const std::function<bool(const Command&)>& condition);

}  // namespace lss::gnc::ardito::test
