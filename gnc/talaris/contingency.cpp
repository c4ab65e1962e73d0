#include "gnc/talaris/flight.h"

namespace lss::gnc::talaris {

// The table of flight.h. Parts that the program does not use are masked out before.
Reaction react(FaultSet faults, bool flying, bool fans, bool gas) noexcept {
  const bool imu_lost = (faults & kImuLost) != 0;
  const bool gas_lost = gas && (faults & (kValvesLost | kPressureLost)) != 0;
  const bool fans_lost = fans && (faults & kFansLost) != 0;
  const bool down = (faults & (kAltimeterLost | kGasLow | kOverruns | kRunTime)) != 0;
  if (!flying) {
    if (imu_lost || gas_lost || fans_lost || (faults & (kUpset | kSpinUpFailed)) != 0) {
      return Reaction::all_stop;
    }
    if (down) return Reaction::land;
    return (faults & kImuGap) != 0 ? Reaction::hold : Reaction::none;
  }

  const bool fans_usable = fans && !fans_lost, gas_usable = gas && !gas_lost;
  if (imu_lost || gas_lost) return fans_usable ? Reaction::parachute : Reaction::all_stop;
  if (fans_lost) return gas_usable ? Reaction::escape : Reaction::all_stop;
  // not by fans alone: the allocation knows what is left
  if ((faults & kActuatorFailed) != 0) return Reaction::escape;
  if ((faults & kUpset) != 0) return fans_usable ? Reaction::parachute : Reaction::escape;
  if ((faults & kOverTime) != 0 && fans_usable) return Reaction::parachute;
  if (down) return gas_usable ? Reaction::escape : Reaction::parachute;
  if ((faults & kOffCourse) != 0) return Reaction::land;
  if ((faults & kGasShort) != 0) return Reaction::shorten;
  return (faults & (kImuGap | kOffTrack)) != 0 ? Reaction::hold : Reaction::none;
}

}  // namespace lss::gnc::talaris
