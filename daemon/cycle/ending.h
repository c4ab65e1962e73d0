#pragma once

// When the daemon may end after the order to end. In every frame until then the supervisor stops
// the vehicle (Supervisor::shut_down). Pure; time is data.

#include <cstdint>

#include "daemon/cycle/controller.h"
#include "drivers/time.h"

namespace lss {

// Whether the vehicle may be left as it is after a frame. A vehicle whose motors brake under power
// has `bool powered() const`: a motor still brakes or holds. In FatalError they go on holding.
template <class Vehicle>
bool may_be_left(const Vehicle& vehicle, const lc::ControllerState& controller) noexcept {
  if constexpr (requires { vehicle.powered(); }) {
    return controller.state == State::fatal_error || !vehicle.powered();
  } else {
    return true;
  }
}

class Ending {
 public:
  // After `frames` frames.
  Ending(std::uint64_t frames, TimeNs now) noexcept
      : frames_(frames), begun_ns_(now), newest_(frames), newest_ns_(now) {}

  // Asked again and again, at least once a second.
  bool over(std::uint64_t frames, TimeNs now, bool may_leave) noexcept {
    if (frames != newest_) {
      newest_ = frames;
      newest_ns_ = now;
    }
    if (now - newest_ns_ >= kFrameless || now - begun_ns_ >= kLongest) return true;
    return frames - frames_ >= kFrames && may_leave;
  }

 private:
  static constexpr std::uint64_t kFrames = 10;      // the safe command reaches every module
  static constexpr TimeNs kFrameless = kSecond;     // nothing stops the vehicle any more
  static constexpr TimeNs kLongest = 10 * kSecond;  // a motor does not come to rest

  std::uint64_t frames_;
  TimeNs begun_ns_;
  std::uint64_t newest_;
  TimeNs newest_ns_;
};

}  // namespace lss
