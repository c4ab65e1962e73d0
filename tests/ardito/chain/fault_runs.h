#pragma once

// The failures of the Ardito thesis' section 19 on the whole chain: what must be found, how soon it
// was found there (its tables 19.1 and 19.2, all rows and columns), and how soon it is here, at any
// speed on any ground. Steering systems are broken as they are steered to the other side, because
// only that is visible.

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "tools/lss-sim/ardito/terrain.h"
#include "tools/lss-sim/soil/soil.h"

namespace lss::ardito {

// States of the failure detection (telemetry, Ardito thesis 17.2.1 and 17.4) as bits; any of them
// is right.
using States = unsigned;
constexpr States state(unsigned n) { return 1u << n; }
inline constexpr States kIsolated = 1u << 16;      // clutch open and motor stopped, in any state
inline constexpr States kNothingToSee = 1u << 17;  // it changes nothing that is left in service

// A time of the thesis, s; none: it did not find it, or did not try.
using Thesis = std::optional<double>;

struct FailurePart {
  const char* fault;  // of lss-sim, # for the wheel
  States found;       // of a wheel; a steering system: any more than before
  Thesis theoretical_s, simulink_s, coppelia_s;  // 19.1 and 19.2; 19.1; 19.2
};

struct FailureRow {
  const char* name;
  std::vector<FailurePart> parts;
  bool isolates;                    // clutch open, motor stopped
  bool fatal;                       // FatalError follows
  Thesis expected_s, mitigated_s;   // mitigation of the last part, after its detection, 19.2
  bool in_short = false;            // in the short test: here the chain is no later than the thesis
  const char* angle_simulink = "";  // steering: largest error of the angle, deg, 19.1
  const char* angle_coppelia = "";  // and 19.2
};

std::span<const FailureRow> wheel_rows();
std::span<const FailureRow> steering_rows();

// Where and how fast the rover drives when it is broken.
struct DriveCase {
  sim::ardito::Ground ground = sim::ardito::Ground::flat;
  double speed_m_s = 0.5;
  unsigned seed = 1;  // odd: broken in step with the sampling, so that frame 1 sees it 0.1 s old;
                      // even: at some other moment of the frame
  std::optional<sim::soil::Soil> soil{};
};

// Times in frames of 100 ms. Frame 1 is the first one whose SYNC came after the failure.
struct FailureTimes {
  static constexpr int kNever = 1000;
  static constexpr int kNothing = -1;  // there is nothing to see
  std::vector<int> found;              // one for each part, in frames
  std::vector<double> found_s;         // from the injection to the frame that found it
  int mitigated = 0;                   // frames after it was found: isolated, or sensor left out
  int fatal = 0;                       // frames after it was found
  double angle_deg = 0;                // steering: largest |commanded - true| from the failure on
  std::vector<std::string> wrong;

  void worst_of(const FailureTimes& other);
};

FailureTimes break_wheel(const FailureRow& row, unsigned wheel, const DriveCase& drive);
// `system` 1..4, of wheels 1, 2, 5, 6.
FailureTimes break_steering(const FailureRow& row, unsigned system, const DriveCase& drive);

}  // namespace lss::ardito
