#pragma once

// Drives Lunar Zebro along a course for a lunar day, by command, acknowledgement, status and
// telemetry alone: stands up, walks, steers, lies down to charge with the panel out, and when there
// was a fault lets the daemon solve it, tries again, resets, and asks a person last.

#include "gnc/zebro/locomotion.h"
#include "tests/zebro/mission/link.h"

namespace lss::zebro::mission {

class Autopilot {
 public:
  struct Parameters {
    double course_m = 200;
    gnc::zebro::Speed speed = gnc::zebro::Speed::low;
    double rest_below = 0.30, rest_until = 0.95;  // charge
    double steer_above_rad = 0.09, straight_below_rad = 0.02;
    double steer_rad = 0.35;
    double back_rad_m = 0.1, most_back_rad = 0.2;  // heading for a metre aside
    double restore_after_s = 1800;                 // of walking without a leg
    int solve_tries = 3;
    int reset_tries = 3;  // of everything, without so long an operation in between
    double healthy_s = 60;
    int most_interventions = 20;
  };
  struct Count {
    int stretches = 0, rests = 0, steered = 0;
    int recoveries = 0;  // from FatalError to Idle
    int solves = 0, resets = 0, restores = 0, interventions = 0;
  };

  Autopilot(Link& link, const Parameters& parameters) : link_(link), parameters_(parameters) {}

  // Until it has arrived, it is dark, or persons are tired of it.
  void run();

  double course_m() const { return course_m_; }  // along the course, by dead reckoning
  bool arrived() const { return course_m_ >= parameters_.course_m; }
  const Count& count() const { return count_; }

 private:
  template <class Kind>
  Ack command(Kind kind, std::initializer_list<double> parameters, double limit_s) {
    return command_number(static_cast<std::uint16_t>(kind), parameters, limit_s);
  }
  Ack command_number(std::uint16_t kind, std::initializer_list<double> parameters, double limit_s);
  bool may_go_on() const;
  bool to_idle();
  void recover();
  void person();
  void rest();
  void stretch();
  void refused(const Ack& ack);
  void reckon();
  double steer(double steering_rad);
  bool misses_a_leg() const;
  bool walk(double heading_rad);

  Link& link_;
  Parameters parameters_;
  Count count_;
  double course_m_ = 0, aside_m_ = 0;  // by dead reckoning; to the left
  double said_m_ = 0;                  // by telemetry, since this start
  int refusals_ = 0;                   // in a row
  int resets_ = 0;                     // of everything, in a row
};

}  // namespace lss::zebro::mission
