#pragma once

// The failures of the Ardito thesis' section 19 on the whole chain: what must be found, how soon it
// was found there, and how soon it is here. The rover drives at 0.5 m/s on flat ground; steering
// systems are broken at standstill and then steered, because only that is visible.

#include <optional>
#include <span>
#include <string>
#include <vector>

namespace lss::ardito {

// States of the failure detection (telemetry, Ardito thesis 17.2.1 and 17.4) as bits; any of them
// is right.
using States = unsigned;
constexpr States state(unsigned n) { return 1u << n; }
inline constexpr States kIsolated = 1u << 16;  // clutch open and motor stopped, in any state

struct FailurePart {
  const char* fault;               // of lss-sim, # for the wheel
  States found;                    // of a wheel; a steering system: any more than before
  std::optional<double> thesis_s;  // its real detection time; none: not detected
};

struct FailureRow {
  const char* name;
  std::vector<FailurePart> parts;
  const char* table;                   // of the thesis
  bool isolates;                       // clutch open, motor stopped
  bool fatal;                          // FatalError follows
  std::optional<double> mitigation_s;  // of the last part, after its detection, the thesis' figure
  bool in_short = false;  // in the short test: here the chain is no later than the thesis
};

std::span<const FailureRow> wheel_rows();
std::span<const FailureRow> steering_rows();

// Times in frames of 100 ms. Frame 1 is the first one whose SYNC came after the failure.
struct FailureTimes {
  static constexpr int kNever = 1000;
  std::vector<int> found;       // one for each part, in frames
  std::vector<double> found_s;  // from the injection to the frame that found it
  int mitigated = 0;            // frames after it was found: isolated, or the sensor left out
  int fatal = 0;                // frames after it was found
  std::vector<std::string> wrong;

  void worst_of(const FailureTimes& other);
};

// Odd seeds: broken in step with the sampling, so that frame 1 sees it 0.1 s old; even ones: at
// some other moment of the frame.
FailureTimes break_wheel(const FailureRow& row, unsigned wheel, unsigned seed);
// `system` 1..4, of wheels 1, 2, 5, 6.
FailureTimes break_steering(const FailureRow& row, unsigned system, unsigned seed);

}  // namespace lss::ardito
