#include "tests/zebro/mission/mission.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <chrono>
#include <cmath>
#include <memory>

#include "tests/zebro/chain/chain.h"
#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro::mission {
namespace {

constexpr double kFrame_s = 0.02;
constexpr double kPanelIn_rad = 0.2;
constexpr double kFatalWithin_s = 10, kMustWithin_s = 3;
constexpr double kPerson_h = 2;    // until one has looked
constexpr double kSun_rad = 0.01;  // noise of the Sun sensor
constexpr std::size_t kMostViolations = 20;

bool moves(const WireFrame& frame) {
  const Code code = frame.code();
  return code == Code::start_motion_control || code == Code::rotate_forward ||
         code == Code::rotate_backward;
}

// The world around the autopilot, and the part that it may see.
class Day final : public Link {
 public:
  Day(const Options& options, Result& result)
      : options_(options),
        result_(result),
        faults_(options.seed, options.fault_mean_h, options.lying_faults),
        random_(options.seed + 77) {
    wake(nullptr);
    from_ = chain_->body();
  }

  std::uint64_t send(std::uint16_t kind, std::initializer_list<double> parameters) override {
    chain_->acks.clear();
    if (options_.tell)
      tell(fmt::format("command {}, {}", zebro::logic().command(kind)->name,
                       fmt::join(parameters, " ")));
    return chain_->send(kind, parameters);
  }
  const Ack* answer(std::uint64_t sequence) const override { return chain_->last_ack(sequence); }
  State state() const override { return chain_->state(); }
  Mode mode() const override { return chain_->mode(); }
  const lss_ZebroTelemetry& telemetry() const override { return chain_->telemetry(); }
  double charge() const override { return charge_; }
  bool daylight() const override { return hours() < options_.day_h; }
  double heading_rad() const override { return true_heading_rad() + sun_error_rad_; }
  void pass(double seconds) override;
  void sleep(double charge) override;
  void ask_person() override;

  double hours() const { return slept_h_ + before_h_ + chain_->seconds() / 3600; }
  sim::zebro::BodyState moved() const;

 private:
  void wake(std::unique_ptr<sim::zebro::Zebro> world);
  void frame();
  void look_at_wire();
  void tick();
  void break_something();
  void tell(const std::string& what);
  void tell(const EventRecord& event);
  void violated(const std::string& what);
  double true_heading_rad() const;

  Options options_;
  Result& result_;
  Power power_;
  Faults faults_;
  std::mt19937 random_;
  std::unique_ptr<Chain> chain_;
  sim::zebro::BodyState from_;
  double before_h_ = 0, slept_h_ = 0, operated_s_ = 0;
  double charge_ = 1;
  double sun_error_rad_ = 0;
  unsigned wakes_ = 0;
  std::size_t seen_ = 0;  // frames on the wire of this daemon
  unsigned ticks_ = 0;
  State before_ = State::idle, before_that_ = State::idle;
  // The last fault that was injected, until its result is known.
  struct Watched {
    std::size_t shape = 0;
    bool watched = false, must = false;
    double since_s = 0;
    std::string text;
  } watched_;
};

void Day::wake(std::unique_ptr<sim::zebro::Zebro> world) {
  auto kept = std::make_shared<std::unique_ptr<sim::zebro::Zebro>>(std::move(world));
  chain_ = std::make_unique<Chain>(Chain::Options{
      .seed = options_.seed + 1000 * wakes_++,
      .vehicle =
          [this, kept](const sim::zebro::TerrainOptions& terrain) {
            if (*kept) return std::move(*kept);
            sim::zebro::TerrainOptions own = terrain;
            own.seed = options_.seed;
            return std::make_unique<sim::zebro::Zebro>(
                sim::zebro::ZebroOptions{.terrain = own,
                                         .plant = sim::zebro::PlantKind::kinematic,
                                         .step_ns = 20 * kMillisecond});
          },
      .whole_frames = true,
      .adjust = [this](Parameters& p) { p.locomotion.flight_s = options_.flight_s; }});
  before_ = before_that_ = State::idle;
  seen_ = 0;
  for (const std::string& fault : faults_.attached()) chain_->inject(fault);
  chain_->run(1);  // contact
}

// From where it began, along the course.
sim::zebro::BodyState Day::moved() const {
  sim::zebro::BodyState moved = chain_->body();
  moved.position_m = from_.attitude.conjugate() * (moved.position_m - from_.position_m);
  moved.attitude = from_.attitude.conjugate() * moved.attitude;
  return moved;
}

double Day::true_heading_rad() const {
  const Eigen::Vector3d ahead = moved().attitude * Eigen::Vector3d::UnitX();
  return std::atan2(ahead.y(), ahead.x());
}

void Day::pass(double seconds) {
  const State began = state();
  chain_->run_until(
      [&] {
        frame();
        return state() != began;
      },
      seconds);
}

// Conditions of every frame.
void Day::frame() {
  const State now = state();
  look_at_wire();
  for (const EventRecord& event : chain_->events) {
    result_.isolations += event.id == static_cast<std::uint16_t>(EventId::module_isolated) ? 1 : 0;
    tell(event);
  }
  chain_->events.clear();
  if (now == State::operational) {
    if (chain_->world().panel_rad() > kPanelIn_rad) violated("operational with the panel out");
    if (chain_->has_fatal()) violated("operational with a fatal fault");
  }
  if (now == State::fatal_error && before_ != State::fatal_error && before_ != State::solve_errors)
    ++result_.emergencies;
  before_that_ = std::exchange(before_, now);
  if (++ticks_ % 5 == 0) tick();
}

// An order is on the wire up to two frames after the state that gave it.
void Day::look_at_wire() {
  const auto allowed = [&](std::size_t module) {
    const auto in = [&](State s) { return state() == s || before_ == s || before_that_ == s; };
    if (module + 1 == kModules) return in(State::idle);
    return in(State::operational) || in(State::solve_errors);
  };
  for (; seen_ < chain_->wire().size(); ++seen_) {
    const WireFrame& frame = chain_->wire()[seen_];
    if (moves(frame) && !allowed(frame.frame.address - 1u))
      violated(fmt::format("motion of module {} ordered in {}", frame.frame.address,
                           kStateNames[static_cast<std::size_t>(state())]));
  }
}

// Ten times a second: energy and faults.
void Day::tick() {
  const double dt_s = 5 * kFrame_s;
  const double motors_W = chain_->world().current_A() * power_.motor_V;
  const bool sun = chain_->world().panel_rad() > 1.5;
  const double net_W = (sun ? power_.panel_W : 0) - power_.awake_W - motors_W;
  charge_ = std::min(1.0, charge_ + net_W * dt_s / 3600 / power_.capacity_Wh);
  result_.least_charge = std::min(result_.least_charge, charge_);
  if (state() == State::operational) operated_s_ += dt_s;
  if (mode() == Mode::walking) result_.walked_h += dt_s / 3600;
  if (ticks_ % 50 == 0) sun_error_rad_ = std::normal_distribution(0.0, kSun_rad)(random_);
  break_something();
}

void Day::break_something() {
  for (const std::string& over : faults_.end(hours() * 3600)) {
    chain_->inject(over);
    tell(over);
  }
  if (watched_.watched) {
    const double since_s = operated_s_ - watched_.since_s;
    const bool stopped = state() == State::fatal_error || state() == State::solve_errors;
    if (stopped) ++result_.faults[watched_.shape].fatal;
    if (!stopped && watched_.must && state() == State::operational && since_s > kMustWithin_s)
      violated(watched_.text + " did not stop it");
    if (stopped || since_s > kFatalWithin_s || state() == State::idle) watched_.watched = false;
  }
  const auto due = faults_.begin(operated_s_, hours() * 3600);
  if (!due) return;
  const bool operational = state() == State::operational;
  const bool leg = due->unit >= 1 && due->unit <= kLegs;
  const bool in_service =
      leg && !chain_->telemetry().modules[static_cast<std::size_t>(due->unit) - 1].isolated;
  const std::string_view name = kFaultShapes[due->shape].name;
  ++result_.faults[due->shape].begun;
  if (operational) ++result_.faults[due->shape].operational;
  chain_->inject(due->attach);
  tell("fault " + due->attach);
  watched_ = {.shape = due->shape,
              .watched = operational,
              .must = in_service && (name == "module-reset" || name == "driver-fault"),
              .since_s = operated_s_,
              .text = due->attach};
}

void Day::sleep(double charge) {
  std::unique_ptr<sim::zebro::Zebro> world = chain_->take_world();
  before_h_ += chain_->seconds() / 3600;
  const double net_W = power_.panel_W - power_.asleep_W;
  const double hours = std::max(0.0, (charge - charge_) * power_.capacity_Wh / net_W);
  if (world->panel_rad() < 1.5) violated("sleeps without its panel");
  charge_ = std::max(charge, charge_);
  slept_h_ += hours;
  result_.rested_h += hours;
  world->rest(hours * 3600);
  wake(std::move(world));
}

void Day::ask_person() {
  tell("a person is asked");
  chain_->inject("clear");
  faults_.forget();
  slept_h_ += kPerson_h;
}

void Day::tell(const std::string& what) {
  if (options_.tell) options_.tell(fmt::format("{:.4f} h: {}", hours(), what));
}

void Day::tell(const EventRecord& event) {
  if (!options_.tell) return;
  const bool fault = event.id >= kFaultEventBase;
  tell(fmt::format("{}{}, module {}, {} {}", fault ? "latched: " : "", event_info(event.id)->name,
                   event.subject, event.argument[0], event.argument[1]));
}

void Day::violated(const std::string& what) {
  if (result_.violations.size() < kMostViolations)
    result_.violations.push_back(fmt::format("{:.4f} h: {}", hours(), what));
}

}  // namespace

int Result::fault_total() const {
  int total = 0;
  for (const FaultCount& kind : faults) total += kind.begun;
  return total;
}

Result run(const Options& options) {
  using Clock = std::chrono::steady_clock;
  const auto begin = Clock::now();
  Result result;
  result.seed = options.seed;
  Day day(options, result);
  Autopilot autopilot(day, options.autopilot);
  autopilot.run();
  const Eigen::Vector3d moved = day.moved().position_m;
  result.arrived = autopilot.arrived();
  result.course_m = autopilot.course_m();
  result.true_m = moved.x();
  result.aside_m = moved.y();
  result.elapsed_h = day.hours();
  result.count = autopilot.count();
  result.wall_s = std::chrono::duration<double>(Clock::now() - begin).count();
  return result;
}

}  // namespace lss::zebro::mission
