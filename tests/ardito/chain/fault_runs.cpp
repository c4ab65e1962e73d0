#include "tests/ardito/chain/fault_runs.h"

#include <algorithm>
#include <cmath>

#include "tests/ardito/chain/chain.h"

namespace lss::ardito {
namespace {

constexpr double kSpeed_m_s = 0.5;
constexpr double kHeading_rad = 3 * std::numbers::pi / 180;
constexpr double kLimit_s = 8;
constexpr unsigned kWheelOfSystem[] = {1, 2, 5, 6};
constexpr std::optional<double> kNotFound{};

constexpr FailurePart kHTM{"H-TM:#", state(1), 0.1}, kETM{"E-TM:#", state(1), 0.1},
    kETRG{"E-TRG:#", state(2), 0.1}, kTM{"TM:#", state(3), 0.1}, kTRG{"TRG:#", state(4), 0.6};
constexpr FailurePart kETRG2{"E-TRG:#", state(6), 0.1};
constexpr FailurePart tc(std::optional<double> thesis_s) { return {"TC:#", kIsolated, thesis_s}; }

const std::vector<FailureRow> kWheelRows = {
    {"H-TM", {kHTM}, "19.2", false, false, {}, true},
    {"E-TM", {kETM}, "19.2", false, false, {}, true},
    {"E-TRG", {kETRG}, "19.2", false, false, {}, true},
    {"TM", {kTM}, "19.2", true, false, 0.5, true},
    {"TM, free without torque", {{"TM:#:1", kIsolated, kNotFound}}, "-", true, false, {}},
    {"TRG", {kTRG}, "19.2", true, true, 0.5, true},
    {"TRG, coupling lost", {{"TRG:#:1", kIsolated, kNotFound}}, "-", true, false, {}},
    {"TC", {tc(4.8)}, "19.1", true, false, {}, true},
    {"H-TM + TM", {kHTM, kTM}, "19.2", true, false, 1.2},
    {"H-TM + TRG", {kHTM, kTRG}, "19.2", true, true, 0.5},
    {"H-TM + TC", {kHTM, tc(1.6)}, "19.1", true, false, {}},
    {"H-TM + E-TRG", {kHTM, kETRG2}, "19.2", false, false, {}},
    {"H-TM + E-TM", {kHTM, {"E-TM:#", state(6), 0.2}}, "19.2", false, false, {}, true},
    {"E-TM + E-TRG", {kETM, kETRG2}, "19.2", false, false, {}},
    {"E-TM + TM", {kETM, kTM}, "19.2", true, false, 0.5},
    {"E-TM + TC", {kETM, tc(kNotFound)}, "19.1", true, false, {}},
    {"E-TM + TRG", {kETM, kTRG}, "19.2", true, true, 0.5},
    {"E-TRG + TM", {kETRG, kTM}, "19.2", true, false, 0.6},
    {"E-TRG + TRG", {kETRG, kTRG}, "19.2", true, true, 0.5},
    {"E-TRG + TC", {kETRG, tc(kNotFound)}, "19.1", true, false, {}},
    {"TC + TRG", {tc(kNotFound), {"TRG:#", state(4), 0.8}}, "19.1", true, true, {}},
    {"H-TM + E-TM + E-TRG",
     {kHTM, {"E-TM:#", state(6), 0.2}, {"E-TRG:#", state(8), 0.1}},
     "19.2",
     true,
     true,
     0.3,
     true},
};

constexpr FailurePart kESM{"E-SM:#", 0, 3.4}, kESRG{"E-SRG:#", 0, 3.8};
const std::vector<FailureRow> kSteeringRows = {
    {"SM", {{"SM:#", 0, 1.0}}, "19.2", false, true, 1.2, true},
    {"SRG", {{"SRG:#", 0, 1.0}}, "19.2", false, true, 1.2},
    {"E-SM", {kESM}, "19.2", false, false, {}, true},
    {"E-SRG", {kESRG}, "19.2", false, false, {}, true},
    {"E-SM + E-SRG", {{"E-SM:#", 0, 3.3}, {"E-SRG:#", 0, 0.9}}, "19.2", false, true, 1.3},
    {"E-SM + SM", {{"E-SM:#", 0, 5.7}, {"SM:#", 0, 1.9}}, "19.2", false, true, 0.8},
    {"E-SRG + SM", {{"E-SRG:#", 0, 3.9}, {"SM:#", 0, 0.9}}, "19.2", false, true, 0.5},
};

std::string with_wheel(const char* fault, unsigned wheel) {
  std::string text = fault;
  text.replace(text.find('#'), 1, std::to_string(wheel));
  return text;
}

Chain::Options flat(unsigned seed) {
  // The lamp is no part of this and costs time.
  return {.seed = seed, .adjust = [](Parameters& p) { p.beacon_ns = 1500 * kMillisecond; }};
}

// A run, and frames counted from a moment on.
class Run {
 public:
  Run(unsigned seed, double heading_rad) : chain(flat(seed)) {
    if (!chain.start() || !chain.drive(kSpeed_m_s, heading_rad)) {
      wrong("does not drive");
      return;
    }
    chain.run(3);
    // Odd seeds: in step, just after a SYNC has sampled everything, as where failures are injected
    // between two steps of a simulation. Even ones: some time between.
    const bool in_step = seed % 2 == 1;
    phase_ns_ = in_step ? kMillisecond : seed * 37 % 90 * kMillisecond;
    const TimeNs sync_ns =
        chain.frame_ns() + chain.parameters().bus.period_ns - chain.parameters().bus.sync_lead_ns;
    chain.run(static_cast<double>(sync_ns + phase_ns_ - chain.now()) * 1e-9);
    if (chain.supervisor().fault_count != 0) wrong("a fault before anything was broken");
  }

  // Frames whose measurements are later than now, until the condition.
  int frames_until(const std::function<bool()>& condition) {
    const TimeNs since_ns = chain.now() + chain.parameters().bus.sync_lead_ns;
    int frames = 0;
    const bool came = chain.run_until(
        [&] {
          frames += chain.frame_ns() >= since_ns ? 1 : 0;
          return condition();
        },
        kLimit_s);
    return came ? frames : FailureTimes::kNever;
  }
  void find(const std::function<bool()>& condition) {
    const TimeNs from_ns = chain.now();
    times.found.push_back(frames_until(condition));
    times.found_s.push_back(static_cast<double>(chain.frame_ns() - from_ns) * 1e-9);
  }
  void wrong(const std::string& what) { times.wrong.push_back(what); }
  // Results at the end of a run.
  void check_end(const FailureRow& row) {
    chain.run(2);
    if ((chain.state() == State::fatal_error) != row.fatal)
      wrong(row.fatal ? "no FatalError" : "FatalError");
    const double speed_m_s = chain.world().rover().body().velocity_m_s.norm();
    if (row.fatal && chain.state() == State::fatal_error && speed_m_s > 0.02)
      wrong("still moves after FatalError");
    // Slower in curves (Ardito thesis 11.2.2).
    const double heading_rad = chain.telemetry().heading_rad;
    const double wanted_m_s = kSpeed_m_s * (1 - std::abs(std::sin(5 * heading_rad)));
    if (!row.fatal && std::abs(speed_m_s - wanted_m_s) > 0.08)
      wrong("does not drive on at its speed");
  }

  // To the same moment of a frame some time later; call it after a find().
  void pause(double seconds) { chain.run(seconds + static_cast<double>(phase_ns_) * 1e-9); }

  Chain chain;
  FailureTimes times;

 private:
  TimeNs phase_ns_ = 0;
};

bool isolated(const gnc::ardito::Command& c, std::size_t wheel) {
  return !gnc::ardito::contains(c.clutches_engaged, wheel) &&
         gnc::ardito::contains(c.motors_stopped, wheel);
}

}  // namespace

std::span<const FailureRow> wheel_rows() { return kWheelRows; }
std::span<const FailureRow> steering_rows() { return kSteeringRows; }

void FailureTimes::worst_of(const FailureTimes& other) {
  found.resize(std::max(found.size(), other.found.size()));
  found_s.resize(found.size());
  for (std::size_t i = 0; i < other.found.size(); ++i) {
    found[i] = std::max(found[i], other.found[i]);
    found_s[i] = std::max(found_s[i], other.found_s[i]);
  }
  mitigated = std::max(mitigated, other.mitigated);
  fatal = std::max(fatal, other.fatal);
  wrong.insert(wrong.end(), other.wrong.begin(), other.wrong.end());
}

FailureTimes break_wheel(const FailureRow& row, unsigned wheel, unsigned seed) {
  Run run(seed, 0);
  const std::size_t i = wheel - 1;
  const auto& c = [&]() -> const gnc::ardito::Command& { return run.chain.mobility(); };
  std::uint32_t lost = 0;
  for (std::size_t n = 0; n < row.parts.size(); ++n) {
    const FailurePart& part = row.parts[n];
    if (n > 0) run.pause(2);
    lost = c().sensors_lost[i];
    run.chain.inject(with_wheel(part.fault, wheel));
    run.find([&] {
      if (part.found == kIsolated) return isolated(c(), i);
      return (part.found & (state(static_cast<unsigned>(c().wheel_suspect[i])) |
                            state(static_cast<unsigned>(c().wheel_failure[i])))) != 0;
    });
  }
  const auto mitigated = [&] {
    return row.isolates ? isolated(c(), i) : c().sensors_lost[i] != lost;
  };
  run.times.mitigated = mitigated() ? 0 : run.frames_until(mitigated);
  if (row.fatal) {
    const auto fatal = [&] { return run.chain.state() == State::fatal_error; };
    run.times.fatal = run.times.mitigated + (fatal() ? 0 : run.frames_until(fatal));
  }
  run.check_end(row);
  for (std::size_t other = 0; other < kWheels; ++other) {
    if (other != i && c().wheel_failure[other] != gnc::ardito::WheelFailure::none)
      run.wrong("wheel " + std::to_string(other + 1) + " is suspected too");
  }
  return run.times;
}

FailureTimes break_steering(const FailureRow& row, unsigned system, unsigned seed) {
  Run run(seed, -kHeading_rad);
  const std::size_t i = system - 1;
  const auto& c = [&]() -> const gnc::ardito::Command& { return run.chain.mobility(); };
  double heading_rad = kHeading_rad;
  for (std::size_t n = 0; n < row.parts.size(); ++n) {
    if (n > 0) run.pause(4);
    run.chain.inject(with_wheel(row.parts[n].fault, kWheelOfSystem[i]));
    run.chain.send(CommandKind::drive, {kSpeed_m_s, heading_rad, 1.0, 0.0});
    heading_rad = -heading_rad;
    const auto before = c().steering_failure[i];
    run.find([&] { return c().steering_suspect[i] > before; });
  }
  if (row.fatal) {
    const auto fatal = [&] { return run.chain.state() == State::fatal_error; };
    run.times.fatal = fatal() ? 0 : run.frames_until(fatal);
    run.times.mitigated = run.times.fatal;
  } else {
    const auto left_out = [&] { return c().encoders_lost[i] != 0; };
    run.times.mitigated = left_out() ? 0 : run.frames_until(left_out);
  }
  run.check_end(row);
  for (std::size_t other = 0; other < kSteered; ++other) {
    if (other != i && c().steering_failure[other] != gnc::ardito::SteeringFailure::none)
      run.wrong("steering system " + std::to_string(other + 1) + " is suspected too");
  }
  return run.times;
}

}  // namespace lss::ardito
