#pragma once

// Acuity AR1000 laser altimeter: lines of ASCII about ten times a second, RS-232 8N1 9600
// (docs/icd-talaris.md section 4; TALARIS thesis 4.4.2, 4.4.3). The measuring command is sent at
// opening, and again when it is silent.

#include <cstdint>

#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

struct Ar1000Parameters {
  int baud = 9'600;
  std::array<char, 8> start_command = {'D', 'W'};  // NUL: end; CR is added
  TimeNs silent_after_ns = kSecond;
  TimeNs stop_ns = 100 * kMillisecond;  // from ESC to the command
  TimeNs latency_ns = 0;                // from measuring to first byte: subtracted
  double nearest_m = 0.1;
  double farthest_m = 30;
};

class Ar1000 final : public SensorLine {
 public:
  explicit Ar1000(const Ar1000Parameters& parameters) noexcept;

  void restart(TimeNs now) noexcept override;
  void receive(std::span<const LineByte> bytes, TimeNs now) noexcept override;
  std::span<const std::uint8_t> transmit(TimeNs now) noexcept override;
  TimeNs next_wake() const noexcept override;

 private:
  enum class Step : std::uint8_t { stop, start, listen };

  void end_line() noexcept;

  Ar1000Parameters parameters_;
  Step step_ = Step::stop;
  TimeNs step_ns_ = 0;   // when it is due
  TimeNs alive_ns_ = 0;  // last line, or the command
  std::array<std::uint8_t, 10> out_{};
  std::array<char, 24> line_{};
  std::size_t size_ = 0;
  bool spoilt_ = false;  // too long
  bool marked_ = false;  // a byte of it
  bool whole_ = false;   // its first byte was received
  TimeNs first_ns_ = 0;
};

}  // namespace lss::talaris
