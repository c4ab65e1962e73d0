#pragma once

// Common part of the rows of lss-bench: a figure is the median of at least five ratios against a
// reference of the same run, with the ratio of the reference to itself (A/A) beside it, which says
// how far a ratio can be trusted. Ordinary code; what runs on FIFO threads only puts numbers down.

#include <cmath>
#include <functional>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace lss::bench {

inline constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
inline constexpr int kRounds = 5;

enum class Campaign { none, idle, load };

struct Options {
  bool quick = false;
  Campaign campaign = Campaign::none;  // of row ii
  bool maxima = false;                 // also maxima, and how often something was missed

  // How many of something: for figures, or for seconds.
  int count(int normal, int quick_count) const { return quick ? quick_count : normal; }
};

using Samples = std::vector<double>;
using Statistic = std::function<double(const Samples&)>;

// 0 <= q <= 1, of the sorted samples; kNone without samples.
double quantile(Samples samples, double q);
double median(const Samples& samples);
double p99(const Samples& samples);
double sigma(const Samples& samples);

// One comparison. The reference is measured twice: side by side, or before and after the subject.
struct Round {
  Samples value, reference, again;
};
using Rounds = std::vector<Round>;

// Reference, subject, subject, reference; each returns its samples.
Rounds turn_by_turn(const std::function<Samples()>& subject,
                    const std::function<Samples()>& reference, int count = kRounds);
// What was measured at once, cut into kRounds parts in the order of time; the halves of each part
// of the reference are compared for A/A.
Rounds side_by_side(const Samples& subject, const Samples& reference);

struct Cycles {
  Samples us;
  int incomplete = 0;
};
// Of the duration of the newest complete cycle before each release and after the last one. Where it
// is still that of the cycle before, the cycle did not end, and took at least `period_us`.
Cycles with_incomplete(const Samples& newest_us, double period_us);

// undecided: the reference differs from itself (A/A) by more than the ratio from its goal.
enum class Met { no, yes, undecided };

struct Figure {
  std::string row, name, unit;
  double value = kNone, reference = kNone, ratio = kNone, aa_ratio = kNone;
  double goal = kNone;    // at most; kNone: only reported
  bool absolute = false;  // the goal is one of the value, not of the ratio
  std::string note{};
  std::string held_back{};   // by what, when the goal is not met
  bool in_document = false;  // although it has no goal
  bool failed = false;       // not measured, since something broke

  std::string remark() const;      // the note, and the bottleneck, if any
  std::optional<Met> met() const;  // nothing: no goal, or not measured
};

Figure figure(const std::string& row, const std::string& name, const std::string& unit,
              const Rounds& rounds, const Statistic& statistic, double goal);
// Of a value and a reference that are each one number.
Figure figure_of(const std::string& row, const std::string& name, const std::string& unit,
                 double value, double reference, double goal, const std::string& note = "");
// The maximum of all rounds.
Figure most(const std::string& row, const std::string& name, const std::string& unit,
            const Rounds& rounds);
// Number of samples above the limit in all rounds; goal: none.
Figure missed(const std::string& row, const std::string& name, const Rounds& rounds, double bound);
Figure at_most(Figure figure, double goal);  // the goal is one of the value
Figure to_be_none(Figure figure);            // the goal is 0
Figure noted(Figure figure, const std::string& note);
Figure held_back(Figure figure, const std::string& by);
// For figures without a goal.
Figure not_measured(const std::string& row, const std::string& name, const std::string& why);

// This machine cannot measure the row; the message says why in one sentence.
struct NotHere : std::runtime_error {
  using std::runtime_error::runtime_error;
};

// Of this build, as in config/NAME.toml.
inline constexpr const char* kVehicles[] = {
    "zebro",
#ifdef LSS_BENCH_ARDITO
    "ardito",
#endif
#ifdef LSS_BENCH_TALARIS
    "talaris",
#endif
};

using Figures = std::vector<Figure>;
Figures wake_up(const Options& options);
Figures byte_to_byte(const Options& options);
Figures event_path(const Options& options, const std::string& how);  // where TALARIS is built
Figures sync_deviation(const Options& options);                      // where Ardito is built
Figures command_to_ack(const Options& options);
Figures estop_call(const Options& options);
Figures telemetry_cost(const Options& options);
Figures leg_bus_cycle(const Options& options);
Figures can_cycle(const Options& options);  // where Ardito is built
Figures frame_mathematics(const Options& options);
Figures state_space(const Options& options);
Figures memory(const Options& options);
Figures time_to_ready(const Options& options);
Figures edge_error(const Options& options);
Figures simulation_speed(const Options& options);
Figures emergency_stop(const Options& options);
Figures lockstep_speed(const Options& options);
Figures fleet(const Options& options);
Figures security(const Options& options);

}  // namespace lss::bench
