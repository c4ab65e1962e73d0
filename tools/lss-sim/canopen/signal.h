#pragma once

// One measured quantity: the true value as the sensor reports it: delayed, noisy, quantised, or
// wrong. In the unit of its object on the bus. One thread.

#include <algorithm>
#include <cmath>
#include <optional>
#include <random>

namespace lss::sim::nodes {

class Signal {
 public:
  struct Quality {
    double noise = 0;      // standard deviation; of a velocity it fades out towards standstill
    double share = 0;      // ... and this share of the value besides
    double quantum = 1;    // the smallest step
    double lag_ms = 0;     // time constant
    bool velocity = true;  // a pulse sensor: no signal at standstill
  };

  explicit Signal(const Quality& quality) : quality_(quality) {}

  // A millisecond with this true value.
  void step(double truth) {
    truth_ += (truth - truth_) / std::max(1.0, quality_.lag_ms);
    offset_ += drift_1_s_ * 1e-3;
  }

  void set(double truth) { truth_ = truth; }  // without the lag of the sensor

  double read(std::mt19937& random) {
    if (held_) return *held_;
    const double size = std::abs(truth_);
    const double fade = quality_.velocity ? size / (size + 5 * quality_.noise + 1e-9) : 1;
    const double deviation = quality_.noise * fade + quality_.share * size;
    double value = truth_ + offset_;
    if (deviation > 0) value += std::normal_distribution<double>(0, deviation)(random);
    return last_ = std::round(value / quality_.quantum) * quality_.quantum;
  }

  void hold(std::optional<double> value) { held_ = value; }
  void stick(bool stuck) { held_ = stuck ? std::optional(last_) : std::nullopt; }
  void drift(double per_second) {
    drift_1_s_ = per_second;
    if (per_second == 0) offset_ = 0;
  }
  void jump(double by) { offset_ = by; }

 private:
  Quality quality_;
  double truth_ = 0, last_ = 0, offset_ = 0, drift_1_s_ = 0;
  std::optional<double> held_;
};

}  // namespace lss::sim::nodes
