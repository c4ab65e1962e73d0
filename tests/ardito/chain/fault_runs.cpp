#include "tests/ardito/chain/fault_runs.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/ardito/chain/chain.h"

namespace lss::ardito {
namespace {

constexpr double kHeading_rad = 3 * std::numbers::pi / 180;
constexpr double kLimit_s = 8;
constexpr unsigned kWheelOfSystem[] = {1, 2, 5, 6};
constexpr Thesis kNone{};

constexpr FailurePart part(const char* fault, States found, Thesis theoretical_s, Thesis simulink_s,
                           Thesis coppelia_s) {
  return {fault, found, theoretical_s, simulink_s, coppelia_s};
}
// Found within a frame in all columns.
constexpr FailurePart sensor(const char* fault, unsigned found) {
  return part(fault, state(found), 0.1, 0.1, 0.1);
}
constexpr FailurePart kHTM = sensor("H-TM:#", 1), kETM = sensor("E-TM:#", 1),
                      kETRG = sensor("E-TRG:#", 2), kTM = sensor("TM:#", 3);
constexpr FailurePart trg(double simulink_s, double coppelia_s) {
  return part("TRG:#", state(4), 0.6, simulink_s, coppelia_s);
}
constexpr FailurePart tc(Thesis simulink_s) {
  return part("TC:#", kIsolated, 0.1, simulink_s, kNone);
}
constexpr FailurePart ours(const char* fault, States found) {
  return part(fault, found, kNone, kNone, kNone);
}

// Rows of both tables, in their order, and ours after those they belong to.
const std::vector<FailureRow> kWheelRows = {
    {"H-TM", {kHTM}, false, false, {}, {}, true},
    {"E-TM", {part("E-TM:#", state(1), 0.1, 0.2, 0.1)}, false, false, {}, {}, true},
    {"E-TRG", {kETRG}, false, false, {}, {}, true},
    {"TM", {kTM}, true, false, 0.5, 0.5, true},
    {"TM, free without torque", {ours("TM:#:1", kIsolated)}, true, false, {}, {}},
    {"TRG", {trg(0.7, 0.6)}, true, true, 0.5, 0.5, true},
    {"TRG, coupling lost", {ours("TRG:#:1", kIsolated)}, true, false, {}, {}},
    {"TC", {tc(4.8)}, true, false, {}, {}, true},
    {"H-TM + TM", {kHTM, kTM}, true, false, 0.5, 1.2},
    {"H-TM + TRG", {kHTM, trg(0.9, 0.6)}, true, true, 0.5, 0.5},
    {"H-TM + TC", {part("H-TM:#", state(1), 0.1, 0.3, kNone), tc(1.6)}, true, false, {}, {}},
    {"H-TM + E-TRG", {kHTM, sensor("E-TRG:#", 6)}, false, false, {}, {}},
    {"H-TM + E-TM", {kHTM, part("E-TM:#", state(6), 0.1, 0.1, 0.2)}, false, false, {}, {}, true},
    {"E-TM + E-TRG", {kETM, sensor("E-TRG:#", 6)}, false, false, {}, {}},
    {"E-TM + TM", {kETM, kTM}, true, false, 0.5, 0.5},
    {"E-TM + TC", {part("E-TM:#", state(1), 0.1, 0.2, kNone), tc(kNone)}, true, false, {}, {}},
    {"E-TM + TRG", {kETM, trg(0.7, 0.6)}, true, true, 0.5, 0.5},
    {"E-TRG + TM", {kETRG, kTM}, true, false, 0.5, 0.6},
    {"E-TRG + TRG", {kETRG, trg(0.6, 0.6)}, true, true, 0.5, 0.5},
    {"E-TRG + TC", {kETRG, tc(kNone)}, true, false, {}, {}},
    {"TM + TC", {kTM, part("TC:#", kNothingToSee, 0.1, 0.1, kNone)}, true, false, 0.5, {}},
    {"TM + TC, closes by itself", {kTM, ours("TC:#:1", state(4))}, true, true, {}, {}},
    {"TC + TRG", {tc(0.1), part("TRG:#", state(4), 0.6, 0.8, kNone)}, true, true, {}, {}},
    {"H-TM + E-TM + E-TRG",
     {kHTM, sensor("E-TM:#", 6), sensor("E-TRG:#", 8)},
     true,
     true,
     0.3,
     0.3,
     true},
};

constexpr FailurePart steering(const char* fault, double simulink_s, double coppelia_s) {
  return part(fault, 0, 0.1, simulink_s, coppelia_s);
}
const std::vector<FailureRow> kSteeringRows = {
    {"SM", {steering("SM:#", 5.7, 1.0)}, false, true, 0.5, 1.2, true, "2.3", "3.4"},
    {"SRG", {steering("SRG:#", 5.7, 1.0)}, false, true, 0.5, 1.2, false, "2.3", "3.4"},
    {"E-SM", {steering("E-SM:#", 2.6, 3.4)}, false, false, {}, {}, true, "7.7", "7.3"},
    {"E-SRG", {steering("E-SRG:#", 5.6, 3.8)}, false, false, {}, {}, true, "5.9", "8.4"},
    {"E-SM + E-SRG",
     {steering("E-SM:#", 2.6, 3.3), steering("E-SRG:#", 2.1, 0.9)},
     false,
     true,
     0.5,
     1.3,
     false,
     "5.8 + 2.3",
     "negligible"},
    {"E-SM + SM",
     {steering("E-SM:#", 2.7, 5.7), steering("SM:#", 1.4, 1.9)},
     false,
     true,
     0.5,
     0.8,
     false,
     "6.9 + 3",
     "6.4"},
    {"E-SRG + SM",
     {steering("E-SRG:#", 2.2, 3.9), steering("SM:#", 3.2, 0.9)},
     false,
     true,
     0.5,
     0.5,
     false,
     "4.6 + 5.5",
     "4.6"},
};

std::string with_wheel(const char* fault, unsigned wheel) {
  std::string text = fault;
  text.replace(text.find('#'), 1, std::to_string(wheel));
  return text;
}

Chain::Options options(const DriveCase& drive) {
  return {.rover = {.ground = drive.ground, .soil = drive.soil},
          .seed = drive.seed,
          .adjust = [](Parameters& p) {
            p.beacon_ns = 1500 * kMillisecond;  // the lamp is no part of this and costs time
            p.mobility.top_speed_m_s = 1;
          }};
}

// A run, and frames counted from a moment on.
class Run {
 public:
  Run(const DriveCase& drive, double heading_rad) : chain(options(drive)), drive_(drive) {
    const SpeedLimit limit = drive.speed_m_s > 0.5 ? SpeedLimit::urc : SpeedLimit::erc;
    if (!chain.start(limit) || !chain.drive(drive.speed_m_s, heading_rad)) {
      wrong("does not drive");
      return;
    }
    chain.run(drive.speed_m_s > 0.5 ? 6 : 3);
    const unsigned seed = drive.seed;
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
    const double wanted_m_s = drive_.speed_m_s * (1 - std::abs(std::sin(5 * heading_rad))) *
                              chain.telemetry().speed_share;  // slower by slip
    const bool even = drive_.ground == sim::ardito::Ground::flat && !drive_.soil;
    const double uneven = even ? 1 : 2.5;
    const double most_m_s = uneven * std::max(0.08, 0.16 * wanted_m_s);
    if (!row.fatal && std::abs(speed_m_s - wanted_m_s) > most_m_s)
      wrong("does not drive on at its speed");
  }

  // To the same moment of a frame some time later; call it after a find().
  void pause(double seconds) { chain.run(seconds + static_cast<double>(phase_ns_) * 1e-9); }

  Chain chain;
  FailureTimes times;

 private:
  DriveCase drive_;
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
  const std::size_t was = found.size();
  found.resize(std::max(found.size(), other.found.size()));
  found_s.resize(found.size());
  for (std::size_t i = 0; i < other.found.size(); ++i) {
    found[i] = i < was ? std::max(found[i], other.found[i]) : other.found[i];
    found_s[i] = std::max(found_s[i], other.found_s[i]);
  }
  mitigated = std::max(mitigated, other.mitigated);
  angle_deg = std::max(angle_deg, other.angle_deg);
  fatal = std::max(fatal, other.fatal);
  wrong.insert(wrong.end(), other.wrong.begin(), other.wrong.end());
}

FailureTimes break_wheel(const FailureRow& row, unsigned wheel, const DriveCase& drive) {
  Run run(drive, 0);
  const std::size_t i = wheel - 1;
  const auto& c = [&]() -> const gnc::ardito::Command& { return run.chain.mobility(); };
  std::uint32_t lost = 0;
  for (std::size_t n = 0; n < row.parts.size(); ++n) {
    const FailurePart& part = row.parts[n];
    if (n > 0) run.pause(2);
    lost = c().sensors_lost[i];
    run.chain.inject(with_wheel(part.fault, wheel));
    if (part.found == kNothingToSee) {
      run.times.found.push_back(FailureTimes::kNothing);
      run.times.found_s.push_back(0);
      continue;
    }
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

FailureTimes break_steering(const FailureRow& row, unsigned system, const DriveCase& drive) {
  Run run(drive, -kHeading_rad);
  const std::size_t i = system - 1;
  const auto& c = [&]() -> const gnc::ardito::Command& { return run.chain.mobility(); };
  double heading_rad = kHeading_rad;
  for (std::size_t n = 0; n < row.parts.size(); ++n) {
    if (n > 0) run.pause(4);
    run.chain.inject(with_wheel(row.parts[n].fault, kWheelOfSystem[i]));
    run.chain.send(CommandKind::drive, {drive.speed_m_s, heading_rad, 1.0, 0.0});
    heading_rad = -heading_rad;
    const auto before = c().steering_failure[i];
    run.find([&] {
      const double true_rad = run.chain.world().rover().steering()[i].angle_rad;
      run.times.angle_deg = std::max(
          run.times.angle_deg, std::abs(c().steering_rad[i] - true_rad) * 180 / std::numbers::pi);
      return c().steering_suspect[i] > before;
    });
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
