#include "tests/ardito/chain/drives.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "idl/ardito/codes.h"
#include "tests/ardito/chain/chain.h"

namespace lss::ardito {
namespace {

using sim::soil::kEarth_m_s2;

constexpr double kSpeed_m_s = 0.5;
constexpr double kHeading_rad = 3 * std::numbers::pi / 180;
constexpr double kStep_m = 0.060;

Chain::Options options(sim::ardito::RoverOptions rover, unsigned seed) {
  return {.rover = rover, .seed = seed, .adjust = [g = rover.gravity_m_s2](Parameters& p) {
            p.beacon_ns = 1500 * kMillisecond;  // the lamp is no part of this and costs time
            p.mobility.top_speed_m_s = 1;
            // Of the Earth: motors push with the weight.
            p.mobility.slip_load *= g / kEarth_m_s2;
          }};
}

Chain::Options corrected(Chain::Options with, int sign) {
  with.adjust = [adjust = with.adjust, sign](Parameters& p) {
    adjust(p);
    if (sign != 0) p.mobility.correction_sign = sign;
  };
  return with;
}

// Clockwise, as the daemon counts.
double true_yaw_rad(const Chain& chain) {
  const Eigen::Matrix3d turn = chain.world().rover().body().attitude.toRotationMatrix();
  return -std::atan2(turn(1, 0), turn(0, 0));
}

// Its wheels turn, and truly it moves at less than half of their speed.
bool loses_half(const Chain& chain) {
  double turning_m_s = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double rad_s = chain.world().rover().wheels()[i].velocity_rad_s;
    turning_m_s += std::abs(rad_s) * sim::ardito::dimensions::kWheelRadius_m / kWheels;
  }
  return chain.world().rover().body().velocity_m_s.norm() < turning_m_s / 2;
}

// The deviations; empty: none. Steering systems as 11, 12, 15, 16.
std::string alarm(const Chain& chain, Healthy& seen) {
  const gnc::ardito::Command& c = chain.mobility();
  std::string text;
  char line[80];
  for (std::size_t i = 0; i < kWheels; ++i) {
    if (c.wheel_failure[i] == gnc::ardito::WheelFailure::none) continue;
    std::snprintf(line, sizeof line, "wheel %zu: %u; ", i + 1,
                  static_cast<unsigned>(c.wheel_failure[i]));
    text += line;
  }
  for (std::size_t i = 0; i < kSteered; ++i) {
    if (c.steering_failure[i] == gnc::ardito::SteeringFailure::none) continue;
    std::snprintf(line, sizeof line, "steering %zu: %u; ", i + 1,
                  static_cast<unsigned>(c.steering_failure[i]));
    text += line;
  }
  const bool was_stuck = seen.is_stuck;
  seen.is_stuck = false;
  for (const FaultRecord& fault : chain.supervisor().faults) {
    if (fault.id == FaultId::none) continue;
    if (fault.id == faults::rover_stuck && (was_stuck || loses_half(chain))) {
      seen.is_stuck = true;
      if (!was_stuck) ++seen.stuck;
      continue;
    }
    std::snprintf(line, sizeof line, "%s of %u; ", info(fault.id)->name, fault.subject);
    text += line;
  }
  if (chain.state() == State::fatal_error) text += "FatalError; ";
  return text;
}

void look(const Chain& chain, Healthy& seen) {
  const gnc::ardito::Command& c = chain.mobility();
  const auto any = [](const auto& failures) {
    return std::ranges::any_of(failures, [](auto f) { return static_cast<unsigned>(f) != 0; });
  };
  ++seen.frames;
  if (any(c.wheel_suspect) || any(c.steering_suspect)) ++seen.suspect_frames;
  if (c.probing != 0) ++seen.probe_frames;
  if ((c.faults & gnc::ardito::kSlip) != 0) ++seen.slip_frames;
  const sim::ardito::RoverPlant& rover = chain.world().rover();
  double lost_m_s = 0, treads_m_s = 0;
  for (std::size_t i = 0; i < kWheels; ++i) {
    const double m_s = rover.wheels()[i].velocity_rad_s * sim::ardito::dimensions::kWheelRadius_m;
    treads_m_s += std::abs(m_s);
    lost_m_s += m_s > 0 ? rover.slip_m_s(i) : -rover.slip_m_s(i);
  }
  constexpr double kGain = 0.1;  // a frame
  seen.lost_m_s += (lost_m_s - seen.lost_m_s) * kGain;
  seen.treads_m_s += (treads_m_s - seen.treads_m_s) * kGain;
  if ((c.faults & gnc::ardito::kSlipSlows) == 0) return;
  ++seen.slowed_frames;
  if (seen.lost_m_s < 0.25 * seen.treads_m_s) ++seen.slowed_wrong;
}

// Its commands, one after the other.
void order(Chain& chain, unsigned step) {
  constexpr std::array headings_rad = {0.0, kHeading_rad, -kHeading_rad, 0.0};
  if (step % 6 == 4) {
    chain.send(CommandKind::halt);
  } else if (step % 6 == 5) {
    chain.send(CommandKind::park, {step % 12 == 5 ? 0.4 : -0.4});
  } else {
    const double speed = step % 18 < 12 ? kSpeed_m_s : -0.3;
    chain.send(CommandKind::drive, {speed, headings_rad[step % 6], 1.0, 0.0});
  }
}

// Sums of squares over a drive.
class Meter {
 public:
  explicit Meter(const Chain& chain) : chain_(chain) {}

  void look() {
    const sim::ardito::RoverPlant& rover = chain_.world().rover();
    const sim::ardito::BodyState body = rover.body();
    if (count_ > 0) way_m_ += (body.position_m - last_m_).norm();
    last_m_ = body.position_m;
    ++count_;
    for (std::size_t i = 0; i < kWheels; ++i) {
      if (rover.loads_N()[i] <= 0) continue;
      const double slip = rover.slip_m_s(i);
      square_[i] += slip * slip;
      ++looks_[i];
    }
  }
  void into(Slip& slip) const {
    double sum = 0, worst = 0, looks = 0;
    for (std::size_t i = 0; i < kWheels; ++i) {
      const double n = std::max(1.0, static_cast<double>(looks_[i]));
      sum += square_[i], looks += static_cast<double>(looks_[i]);
      worst = std::max(worst, square_[i] / n);
    }
    slip.tread_rms_m_s = std::sqrt(sum / std::max(1.0, looks));
    slip.worst_rms_m_s = std::sqrt(worst);
    slip.way_m = way_m_;
  }

 private:
  const Chain& chain_;
  std::array<double, kWheels> square_{};
  std::array<unsigned long, kWheels> looks_{};
  unsigned long count_ = 0;
  double way_m_ = 0;
  Eigen::Vector3d last_m_ = Eigen::Vector3d::Zero();
};

void run(Chain& chain, double seconds, Meter& meter) {
  constexpr double kEvery_s = 0.005;
  for (double t = 0; t < seconds; t += kEvery_s) {
    chain.run(kEvery_s);
    meter.look();
  }
}

}  // namespace

void Healthy::add(const Healthy& other) {
  const auto sum = [&](auto... members) { ((this->*members += other.*members), ...); };
  sum(&Healthy::minutes, &Healthy::metres, &Healthy::frames, &Healthy::suspect_frames,
      &Healthy::probe_frames, &Healthy::slip_frames, &Healthy::slowed_frames,
      &Healthy::slowed_wrong, &Healthy::stuck);
  alarms.insert(alarms.end(), other.alarms.begin(), other.alarms.end());
}

Healthy drive_healthy(const sim::ardito::RoverOptions& rover, double minutes, unsigned seed) {
  constexpr double kStep_s = 10;
  Healthy seen;
  for (; seen.minutes < minutes; seed += 100) {
    Chain chain(options(rover, seed));
    if (!chain.start()) {
      seen.alarms.push_back("does not start");
      return seen;
    }
    std::string amiss;
    Eigen::Vector3d last_m = chain.world().rover().body().position_m;
    for (unsigned step = 0; seen.minutes < minutes && amiss.empty(); ++step) {
      order(chain, step);
      const double from_s = chain.seconds();
      chain.run_until(
          [&] {
            look(chain, seen);
            const Eigen::Vector3d at_m = chain.world().rover().body().position_m;
            seen.metres += (at_m - last_m).norm();
            last_m = at_m;
            amiss = alarm(chain, seen);
            return !amiss.empty();
          },
          kStep_s);
      seen.minutes += (chain.seconds() - from_s) / 60;
    }
    if (amiss.empty()) break;
    char text[64];
    std::snprintf(text, sizeof text, "seed %u, %.1f s: ", seed, chain.seconds());
    seen.alarms.push_back(text + amiss.substr(0, amiss.size() - 2));  // without the last "; "
  }
  return seen;
}

Slip climb(int sign, unsigned seed) {
  Chain chain(corrected(
      options({.step_height_m = kStep_m, .step_side = sim::ardito::StepSide::left}, seed), sign));
  Slip slip;
  if (!chain.start() || !chain.drive(kSpeed_m_s, 0, sign != 0)) return slip;
  // Steps of 60 mm at 1.5 m: the last wheel is over it when the rover has gone 2.5 m.
  Meter meter(chain);
  const double from_m = chain.telemetry().distance_m;
  while (chain.world().rover().body().position_m.x() < 2.5 && chain.seconds() < 60)
    run(chain, 0.1, meter);
  meter.into(slip);
  slip.reckoned_m = chain.telemetry().distance_m - from_m;
  slip.arrived = chain.supervisor().fault_count == 0 && chain.seconds() < 60;
  return slip;
}

Slip cross(sim::ardito::Ground ground, double speed_m_s, int sign, unsigned seed) {
  Chain chain(corrected(options({.ground = ground}, seed), sign));
  Slip slip;
  if (!chain.start(SpeedLimit::urc) || !chain.drive(speed_m_s, 0, sign != 0)) return slip;
  Meter meter(chain);
  run(chain, 30, meter);
  meter.into(slip);
  slip.arrived = chain.supervisor().fault_count == 0;
  return slip;
}

Slip drive_s(unsigned seed) {
  Chain chain(options({}, seed));
  Slip slip;
  if (!chain.start() || !chain.drive(kSpeed_m_s, 0)) return slip;
  chain.run(3);
  const double from_m = chain.telemetry().distance_m, from_rad = chain.telemetry().yaw_rad,
               true_from_rad = true_yaw_rad(chain);
  Meter meter(chain);
  for (const double heading_rad : {kHeading_rad, -kHeading_rad}) {
    chain.send(CommandKind::drive, {kSpeed_m_s, heading_rad, 1.0, 0.0});
    run(chain, 4, meter);
  }
  meter.into(slip);
  slip.reckoned_m = chain.telemetry().distance_m - from_m;
  slip.reckoned_yaw_rad =
      std::remainder(chain.telemetry().yaw_rad - from_rad, 2 * std::numbers::pi);
  slip.yaw_rad = std::remainder(true_yaw_rad(chain) - true_from_rad, 2 * std::numbers::pi);
  slip.arrived = chain.supervisor().fault_count == 0;
  return slip;
}

Slip turn_on_the_spot(unsigned seed) {
  Chain chain(options({}, seed));
  Slip slip;
  if (!chain.start()) return slip;
  const double from_rad = chain.telemetry().yaw_rad, true_from_rad = true_yaw_rad(chain);
  chain.send(CommandKind::park, {kSpeed_m_s});
  if (!chain.run_until(Mode::parking, 10)) return slip;
  Meter meter(chain);
  run(chain, 10, meter);
  meter.into(slip);
  slip.reckoned_yaw_rad =
      std::remainder(chain.telemetry().yaw_rad - from_rad, 2 * std::numbers::pi);
  slip.yaw_rad = std::remainder(true_yaw_rad(chain) - true_from_rad, 2 * std::numbers::pi);
  slip.arrived = chain.supervisor().fault_count == 0;
  return slip;
}

}  // namespace lss::ardito
