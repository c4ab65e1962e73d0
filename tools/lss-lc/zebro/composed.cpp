#include "tools/lss-lc/zebro/composed.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <utility>

#include "daemon/record/state.h"
#include "idl/angles.h"
#include "idl/zebro/codes.h"
#include "tools/lss-lc/team.h"
#include "tools/lss-lc/zebro/key_of_cycle.h"

namespace lss::zebro {
namespace {

constexpr TimeNs kStep = Composed::kStep;
constexpr TimeNs kPause = kSecond / 2;       // of the operator, before a command
constexpr TimeNs kWalking_ns = 3 * kSecond;  // long enough for the first legs to lift off and land
constexpr TimeNs kRest = 2 * kSecond;        // at the end, motors off
constexpr std::uint8_t kTries = 3;           // of the operator, then a person is needed

bool of_module(Failure f) { return f <= Failure::module_reset; }
bool lasts(Failure f) {
  return f <= Failure::late || (f >= Failure::unplugged && f <= Failure::obc_lost);
}

}  // namespace

std::vector<lc::Choice> Composed::failures() {
  std::vector<lc::Choice> all;
  for (std::size_t f = 0; f < kFailures; ++f) {
    const auto failure = static_cast<Failure>(f);
    if (!of_module(failure)) {
      all.push_back({static_cast<std::uint8_t>(f), 0, false});
      continue;
    }
    const bool legs_only = failure == Failure::jammed || failure == Failure::frozen;
    for (std::size_t i = 0; i < (legs_only ? std::size_t{kLegs} : kModules); ++i)
      all.push_back({static_cast<std::uint8_t>(f), static_cast<std::uint8_t>(i + 1), false});
  }
  return all;
}

Composed::Composed(const Options& options)
    : options_(options),
      vehicle_(options.parameters),
      supervisor_(options.logic != nullptr ? *options.logic : zebro::logic(), options.links),
      in_(std::make_unique<Inputs<Vehicle>>()),
      out_(std::make_unique<Outputs<Vehicle>>()) {
  record::StateWriter size({});
  size(vehicle_, supervisor_);
  at_boot_.resize(size.size());
  record::StateWriter writer(at_boot_);
  writer(vehicle_, supervisor_);
}

void Composed::save(Snapshot& snapshot) {
  snapshot.env = env_;
  snapshot.cycle.resize(at_boot_.size());
  record::StateWriter writer(snapshot.cycle);
  writer(vehicle_, supervisor_);
}

void Composed::restore(const Snapshot& snapshot) {
  env_ = snapshot.env;
  record::StateReader reader(snapshot.cycle);
  reader(vehicle_, supervisor_);
}

void Composed::begin() {
  env_ = {};
  broken_ = nullptr;
  record::StateReader reader(at_boot_);
  reader(vehicle_, supervisor_);
  for (std::size_t i = 0; i < kLegs; ++i) env_.module[i].boot(90, 180);  // stowed, level
  env_.module[kPanel].boot(0, 0);
}

// ---- choices

std::span<const lc::Choice> Composed::choices(bool more, bool every) {
  static const std::vector<lc::Choice> kAll = failures();
  choices_.clear();
  if (env_.changed) {
    for (std::size_t i = 0; i < env_.failed; ++i) {
      const Active& active = env_.active[i];
      if (active.lasts)
        choices_.push_back({static_cast<std::uint8_t>(active.failure), active.module, true});
    }
  }
  if (!more || !(every || env_.changed)) return choices_;
  for (const lc::Choice& choice : kAll) {
    const bool same =
        std::ranges::any_of(std::span(env_.active).first(env_.failed), [&](const Active& a) {
          return choice.module != 0 ? a.module == choice.module && a.lasts
                                    : a.failure == static_cast<Failure>(choice.what) && a.lasts;
        });
    if (!same) choices_.push_back(choice);
  }
  return choices_;
}

void Composed::apply(lc::Choice choice) {
  const auto failure = static_cast<Failure>(choice.what);
  AbstractModule* module = choice.module != 0 ? &env_.module[choice.module - 1u] : nullptr;
  const bool on = !choice.heals;
  if (on) {
    env_.active[env_.failed++] = {failure, choice.module, lasts(failure), 0};
    env_.want = Want::walk;
  } else {
    for (Active& active : env_.active) {
      if (active.failure == failure && active.module == choice.module) active.lasts = false;
    }
  }
  env_.tries = env_.resets = 0;
  switch (failure) {
    case Failure::silent:
    case Failure::deaf:
    case Failure::jammed:
    case Failure::frozen:
    case Failure::late:
      if (on) {
        module->begin(static_cast<Ill>(1 + static_cast<int>(failure)));
      } else {
        module->ill = Ill::well;
      }
      break;
    case Failure::module_reset: module->reset_itself(); break;
    case Failure::unplugged:
      env_.plugged = !on;
      if (!on) {  // the bus begins with a stop of all
        for (AbstractModule& m : env_.module) m.bus_stops(env_.now_ns);
      }
      break;
    case Failure::bus_stands: env_.runs = !on; break;
    case Failure::client_lost: env_.client = !on; break;
    case Failure::obc_lost: env_.obc = !on; break;
    case Failure::emergency_stop: env_.emergency_stop = true; break;
    case Failure::reset_lc: env_.reset_lc = true; break;
    case Failure::restart: {
      record::StateReader reader(at_boot_);
      reader(vehicle_, supervisor_);
      env_.begins = true;
      env_.asked_ns = env_.strategy_ns = env_.motor_ns = env_.unheld_ns = 0;
      env_.since_ns = env_.now_ns;
      break;
    }
    case Failure::overrun: env_.overrun = true; break;
    case Failure::orders_stale:
      ++env_.safe_commands;
      if (env_.plugged && env_.runs) {
        for (AbstractModule& m : env_.module) m.bus_stops(env_.now_ns);
      }
      break;
  }
  begin_bus();
}

// It begins with a stop of all.
void Composed::begin_bus() {
  if (!env_.begins || !env_.plugged || !env_.runs) return;
  env_.begins = false;
  for (AbstractModule& m : env_.module) m.bus_begins(env_.now_ns);
}

// ---- one frame

void Composed::step() {
  env_.now_ns += kStep;
  ++env_.frame;
  const lc::ControllerState before = controller();
  const std::uint32_t faults = supervisor_.state().fault_count;
  sense();
  operate();
  cycle(vehicle_, supervisor_, *in_, *out_, [](Stage) {});
  obey();
  env_.changed = controller() != before || supervisor_.state().fault_count != faults;
  if (controller().state != before.state || controller().mode != before.mode)
    env_.since_ns = env_.now_ns;
  check(before);
  env_.emergency_stop = env_.reset_lc = env_.overrun = false;
}

void Composed::sense() {
  Inputs<Vehicle>& in = *in_;
  in.frame = env_.frame;
  in.time_ns = env_.now_ns;
  in.overrun_limit = env_.overrun;
  replies_.clear();
  env_.seen = 0;
  const bool there = env_.plugged && env_.runs;
  if (env_.runs) env_.reported_ns = env_.now_ns - kMillisecond;
  for (std::size_t i = 0; i < kModules; ++i) {
    AbstractModule& module = env_.module[i];
    module.pass(env_.now_ns, kStep);
    if (module.tripped() || module.disobeys()) env_.seen |= 1u << i;
    if (there) module.reply(static_cast<std::uint8_t>(i), env_.now_ns - kMillisecond, replies_);
    ModuleLink& link = in.bus.counters.module[i];
    link.disobeys = there && module.disobeys();
    link.resets = module.resets();
  }
  in.sample_count = static_cast<std::uint32_t>(replies_.size());
  std::ranges::copy(replies_, in.samples.begin());
  in.bus.time_ns = env_.reported_ns;
  in.bus.open = env_.plugged;
  in.bus.was_open = true;
  in.bus.counters.safe_commands = env_.safe_commands;
}

void Composed::obey() {
  if (!env_.plugged || !env_.runs) return;
  for (std::size_t i = 0; i < kModules; ++i)
    env_.module[i].obey(out_->command.module[i], env_.now_ns);
}

// ---- the operator, who does what docs/operators.md says

Request Composed::request(const char* from, std::uint16_t kind) const {
  Request r{};
  std::strncpy(r.source.data(), from, r.source.size() - 1);
  r.kind = kind;
  r.sequence = env_.sequence;
  r.lease_ms = options_.lease_ms;
  r.arrival_ns = env_.now_ns;
  return r;
}

void Composed::ask(std::uint16_t kind, std::initializer_list<double> parameters) {
  ++env_.sequence;
  env_.asked_ns = env_.now_ns;
  Request r = request("operator", kind);
  std::ranges::copy(parameters, r.parameter.begin());
  in_->requests[in_->request_count++] = r;
}

void Composed::operate() {
  Inputs<Vehicle>& in = *in_;
  in.request_count = 0;
  if (env_.obc) in.requests[in.request_count++] = request("obc", 0);
  const bool client = env_.client && env_.obc;
  if (client) in.requests[in.request_count++] = request("operator", 0);
  // In a frame with a stop or a reset the operator commands nothing: it would be obeyed after it.
  if (env_.emergency_stop)
    in.requests[in.request_count++] = request("another", kind_of(lss::CommandKind::emergency_stop));
  if (env_.reset_lc) {
    Request r = request("operator", kind_of(lss::CommandKind::reset));
    r.parameter[0] = -1;
    in.requests[in.request_count++] = r;
    return;
  }
  // The answer to the last command.
  refused_ = {};
  const Supervisor::Outbox& box = supervisor_.outbox();
  for (std::uint32_t i = 0; i < box.ack_count; ++i) {
    const Ack& ack = box.acks[i];
    if (ack.sequence == env_.sequence && ack.phase == Phase::rejected) refused_ = ack.verdict;
  }
  if (!client || env_.emergency_stop || env_.now_ns - env_.since_ns < kPause) return;
  if (env_.asked_ns != 0 && refused_.reason == Reason::none && env_.now_ns - env_.asked_ns < kPause)
    return;
  const lc::ControllerState& c = controller();
  const auto mode = static_cast<Mode>(c.mode);
  switch (c.state) {
    case State::idle:
      if (refused_.reason == reasons::fault_latched && env_.resets < kTries) {
        ++env_.resets;
        return ask(kind_of(lss::CommandKind::reset), {static_cast<double>(refused_.subject)});
      }
      if (refused_.reason != Reason::none && env_.tries < kTries) {
        ++env_.tries;
        return ask(kind_of(lss::CommandKind::emergency_stop));  // then solve
      }
      if (refused_.reason != Reason::none) return finish();
      if (env_.want == Want::walk) return ask(kind_of(lss::CommandKind::start), {1});
      if (env_.now_ns - env_.since_ns >= kRest) finish();
      return;
    case State::operational:
      if (env_.want == Want::stop && mode != Mode::walking) return;
      if (mode == Mode::standing) return ask(kind_of(CommandKind::walk), {1, 0, 3});
      if (mode == Mode::walking && env_.now_ns - env_.since_ns >= kWalking_ns) {
        env_.want = Want::stop;
        return ask(kind_of(lss::CommandKind::stop), {1});
      }
      return;
    case State::fatal_error:
      env_.want = Want::walk;
      if (refused_.reason == reasons::solved_too_often && env_.resets < kTries) {
        ++env_.resets;
        return ask(kind_of(lss::CommandKind::reset), {-1});
      }
      if (env_.tries >= kTries) return finish();
      ++env_.tries;
      return ask(kind_of(lss::CommandKind::solve));
    case State::solve_errors: return;
  }
}

// The operator has nothing left to do.
void Composed::finish() {
  env_.over = true;
  const bool walked = controller().state == State::idle && env_.want == Want::stop;
  if (!walked && can_recover())
    broken_ = "whatever can be isolated and leaves a gait ends in Operational again";
}

// ---- the key

std::uint64_t Composed::key() {
  const lc::ControllerState& c = controller();
  KeyOfCycle h(env_.now_ns, kStep);
  const bool moves = c.state == State::operational || (c.flags & (kFreeing | kPanelMoving)) != 0;
  h.solving(c.state == State::solve_errors);
  vehicle_.keep(h);
  supervisor_.keep(h);
  for (std::size_t i = 0; i < kModules; ++i)
    env_.module[i].hash(h.numbers(), env_.now_ns, kStep, moves ? 5 : 0, out_->command.module[i]);
  auto& n = h.numbers();
  n(env_.plugged, env_.runs, env_.begins, env_.client, env_.obc, env_.emergency_stop, env_.reset_lc,
    env_.overrun, env_.changed);
  n(h.age(env_.reported_ns, 5));
  for (std::size_t i = 0; i < env_.failed; ++i) {
    const Active& a = env_.active[i];
    n(a.failure, a.module, a.lasts, a.lasts ? a.exposed_ns / kStep : 0);
  }
  n(env_.want, h.age(env_.since_ns, 30), env_.asked_ns == 0 ? -1 : h.age(env_.asked_ns, 6),
    env_.tries, env_.resets, env_.over, env_.suspects, env_.seen);
  n(env_.strategy_ns == 0 ? 0 : (env_.strategy_ns + env_.strategy_limit_ns - env_.now_ns) / kStep,
    env_.motor_ns / kStep, env_.unheld_ns / kStep);
  const Supervisor::Outbox& box = supervisor_.outbox();
  for (std::uint32_t i = 0; i < box.ack_count; ++i) {
    const Ack& ack = box.acks[i];
    if (ack.sequence == env_.sequence && ack.phase == Phase::rejected)
      n(ack.verdict.reason, ack.verdict.subject);
  }
  return n.value();
}

// ---- for people

std::string Composed::name(lc::Choice choice) {
  std::string text = kFailureNames[choice.what];
  if (choice.module != 0) text = fmt::format("{} {}", kModuleNames[choice.module - 1u], text);
  return choice.heals ? text + ": well again" : text;
}

std::string Composed::line(const std::string& text) const {
  return fmt::format("{:>8.1f} s  {}", seconds(), text);
}

std::string Composed::text() const {
  const SupervisorState& s = supervisor_.state();
  std::string text = kStateNames[static_cast<std::size_t>(s.controller.state)];
  if (s.controller.mode != 0) text += fmt::format(" {}", kModeNames[s.controller.mode]);
  if (s.controller.strategy != 0) text += fmt::format(", strategy {}", s.controller.strategy);
  if (s.controller.isolated != 0) text += fmt::format(", isolated {:#x}", s.controller.isolated);
  for (const FaultRecord& fault : s.faults) {
    if (fault.id == FaultId::none) continue;
    text += fmt::format(", {}", info(fault.id)->name);
    if (fault.subject != 0) text += fmt::format(" {}", kModuleNames[fault.subject - 1u]);
  }
  return text;
}

// ---- the exploration

lc::Composition compose(const lc::Depth& depth, const Composed::Options& options) {
  const auto begin = std::chrono::steady_clock::now();
  own_codes = zebro::logic().codes;  // names of faults
  std::vector<lc::Choice> first = Composed::failures();
  if (!depth.only.empty())
    std::erase_if(first, [&](lc::Choice c) { return depth.only != kFailureNames[c.what]; });
  std::erase_if(first, [&](lc::Choice c) {
    return c.module != 0 && (unsigned{depth.modules} >> (c.module - 1) & 1u) == 0;
  });
  std::vector<lc::Composition> found(first.size());
  std::atomic<bool> broken{false};
  lc::Team team(depth.threads != 0 ? depth.threads
                                   : std::max(1U, std::thread::hardware_concurrency()));
  team.run(first.size(), [&](std::size_t i, unsigned) {
    if (broken) return;
    Composed system(options);
    found[i] = lc::Search<Composed>(system, depth, first[i]).run();
    if (found[i].violation) broken = true;
  });
  lc::Composition all;
  for (lc::Composition& one : found) {
    all.states += one.states;
    all.steps += one.steps;
    all.choices += one.choices;
    if (one.violation && !all.violation) all.violation = std::move(one.violation);
  }
  all.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return all;
}

}  // namespace lss::zebro
