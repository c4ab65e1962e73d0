#pragma once

// The Acuity AR1000 laser altimeter of TALARIS on its serial line (RS-232, 9600 8N1, ASCII; TALARIS
// thesis 2.3.5, 4.4.2, 4.4.3): measures on command, about ten times a second by its own clock.
// Written from docs/icd-talaris.md, not from the daemon's driver. Threads as in sensor.h.

#include <deque>
#include <optional>
#include <random>
#include <string>

#include "tools/lss-sim/talaris/sensor.h"

namespace lss::sim::talaris {

struct AltimeterOptions {
  double noise_m = 0.003;  // standard deviation
  double min_m = 0.1, max_m = 30;
  double most_rad = 0.9;    // from the target's normal; above it there is no reading
  double jitter_s = 0.008;  // of its period, either way
  double bias_m = 0;        // too far
  double latency_s = 0;     // from the measurement to the first byte, up to 0.2
};

struct AltimeterFaults {
  bool silent = false;
  bool garbage = false;        // its readings are not numbers
  bool out_of_range = false;   // no target
  std::optional<int> error{};  // sends only this: E15 and similar
  double offset_m = 0;
  bool stuck = false;  // repeats its last reading
};

class Altimeter final : public Sensor<AltimeterFaults> {
 public:
  Altimeter(const AltimeterOptions& options, unsigned seed) : options_(options), random_(seed) {}

  void step(std::optional<double> distance_m);  // a millisecond; unset: no target
  std::span<const std::uint8_t> receive(std::uint8_t character, TimeNs now) override;
  bool measuring() const;

 private:
  void obey();
  void say();

  AltimeterOptions options_;
  std::mt19937 random_;
  std::optional<double> distance_m_;
  std::deque<std::optional<double>> before_;  // as it was, a millisecond each
  std::string said_;                          // the last reading
  std::string command_;
  double period_s_ = 0;  // 0: not measuring
  double left_s_ = 0;    // until the next reading
};

}  // namespace lss::sim::talaris
