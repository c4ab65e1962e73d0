#pragma once

// Error solving of Lunar Zebro (Zebro thesis [Conf-3]): the bare minimum the thesis asks for, a
// reset of what is at fault, and then a proof: every module must answer, without a fault flag, for
// a while. Frame thread.

#include <array>
#include <cstdint>

#include "drivers/time.h"
#include "idl/zebro_commands.h"

namespace lss::zebro {

class Solver {
 public:
  enum class Outcome : std::uint8_t { idle, running, solved, unsolved };

  // `reset`: bit i asks for a reset of module i+1 first.
  void begin(TimeNs now, TimeNs budget_ns) noexcept {
    begun_ns_ = now;
    budget_ns_ = budget_ns;
    healthy_since_ns_ = 0;
    running_ = true;
  }
  void end() noexcept { running_ = false; }
  bool running() const noexcept { return running_; }

  // Once per frame while running: `healthy` says that nothing is wrong in this frame.
  Outcome step(TimeNs now, bool healthy) noexcept {
    if (!running_) return Outcome::idle;
    if (!healthy) healthy_since_ns_ = 0;
    if (healthy && healthy_since_ns_ == 0) healthy_since_ns_ = now;
    if (healthy && now - healthy_since_ns_ >= kProof) return Outcome::solved;
    return now - begun_ns_ > budget_ns_ ? Outcome::unsolved : Outcome::running;
  }

 private:
  static constexpr TimeNs kProof = kSecond;

  TimeNs begun_ns_ = 0, budget_ns_ = 0, healthy_since_ns_ = 0;
  bool running_ = false;
};

}  // namespace lss::zebro
