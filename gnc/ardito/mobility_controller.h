#pragma once

// The mobility controller of D.I.A.N.A. Ardito and its FMEDA behind one call a frame (Ardito thesis
// parts V and VI, corrected: docs/gnc-ardito.md). Called from the frame thread, every 100 ms; time
// is data; nothing allocates; the same calls give the same bits. No input results in a command that
// is not a number, exceeds the limit, or turns a stopped motor.
//
// Run it through Redundant (redundant.h), which votes three of them.

#include "gnc/ardito/fmeda.h"
#include "gnc/ardito/parameters.h"
#include "gnc/ardito/state.h"
#include "gnc/ardito/types.h"

namespace lss::gnc::ardito {

class MobilityController {
 public:
  // Parameters must have passed check().
  explicit MobilityController(const Parameters& parameters = {}) noexcept
      : parameters_(parameters), linkage_(linkage(parameters.geometry)) {}

  // One frame. `measured` are the values of the frame that just ended, in response to earlier
  // commands; the result is the command for the next one.
  Command step(const Request& request, const Measured& measured) noexcept;

  const Parameters& parameters() const noexcept { return parameters_; }
  // From the next step() on; the geometry stays. They must have passed check().
  void configure(const Parameters& parameters) noexcept { parameters_ = parameters; }

  // Members that the voter compares.
  template <class Self>
  static constexpr auto members(Self& self) noexcept {
    return std::tie(self.parameters_, self.linkage_, self.state_);
  }

 private:
  // The stages of step().
  void retry(const Request& request) noexcept;
  Motion estimate(const Request& request, const Inputs& inputs, const Feedback& feedback,
                  const PerWheel<WheelLook>& looks, Command& command) noexcept;
  void diagnose(const Request& request, const Inputs& inputs, const Feedback& feedback,
                const PerWheel<WheelLook>& looks, const Motion& motion, Command& command) noexcept;
  void watch_rocker(const Motion& motion, Command& command) noexcept;
  void watch_imu(const Inputs& inputs, const Motion& motion, Command& command) noexcept;
  void watch_slip(const Inputs& inputs, const Motion& motion, Command& command) noexcept;
  void measure_slip(const Inputs& inputs, const Motion& motion, Command& command) noexcept;
  void watch_sinking(const Inputs& inputs, const Motion& motion, Command& command) noexcept;
  void slow_by_slip(const PlaneMotion& target) noexcept;
  void watch_yaw(const Inputs& inputs, const Motion& motion, Command& command) noexcept;
  double mean_load(const Inputs& inputs) const noexcept;
  bool error(const Request& request, Command& command) const noexcept;
  void decide(const Request& request, const Feedback& feedback, bool stop,
              const PerSteered<double>& asked_rad) noexcept;
  void follow_chart(const Request& request, const Feedback& feedback, bool stop,
                    const PerSteered<double>& asked_rad) noexcept;
  PlaneMotion asked_motion(const Request& request) const noexcept;
  PerWheel<double> hubs_m_s(const Request& request, const PlaneMotion& target,
                            const Feedback& feedback, const Motion& motion) const noexcept;
  void slow_down(WheelSet isolated) noexcept;
  void find_steering(const Inputs& inputs, const Feedback& feedback) noexcept;
  void steer(bool moves, const Feedback& feedback, const PerSteered<double>& asked_rad) noexcept;
  void drive(const Request& request, const PlaneMotion& target, const Inputs& inputs,
             const Feedback& feedback, const Motion& motion) noexcept;
  void stand(const Feedback& feedback) noexcept;
  void report(const Inputs& inputs, const Feedback& feedback, const Motion& motion,
              Command& command) const noexcept;
  WheelSet wheels_in(WheelService service) const noexcept;
  WheelSet probed_wheels() const noexcept;

  Parameters parameters_;
  Linkage linkage_;  // computed from the parameters
  State state_;
};

}  // namespace lss::gnc::ardito
