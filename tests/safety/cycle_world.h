#pragma once

// The cycle of any vehicle in virtual time, without threads: a base for the world of its tests. The
// vehicle's World adds its hardware, as good as it can be; tests break it by hand.
//
//   class World : public safety::CycleWorld<World, Vehicle, Mode> {
//    public:
//     explicit World(const Parameters& p = {}, const Supervisor::Parameters& links = {})
//         : CycleWorld(p, logic(), links, kPeriod) { ... }
//     void sense();  // fills in_.samples, in_.sample_count and in_.bus for the frame at time_ns_
//     void obey();   // the hardware does what out_.command says
//   };
//
// Requests go to the cycle directly, or, after use_port(), by the daemon's own entry of commands
// with its armour.

#include <algorithm>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/runtime/command_port.h"

namespace lss::safety {

inline ParameterName parameter_name(std::string_view text) {
  ParameterName name{};
  text.copy(name.data(), name.size() - 1);
  return name;
}
inline Name source(const std::string& text) {
  Name n{};
  text.copy(n.data(), n.size() - 1);
  return n;
}

// M: the vehicle's modes.
template <class Derived, class V, class M>
class CycleWorld {
 public:
  using Vehicle = V;

  static constexpr std::uint32_t kShortestLease_ms = 100, kLongestLease_ms = 60'000;

  template <class P>
  CycleWorld(const P& parameters, const Logic& logic, const Supervisor::Parameters& links,
             TimeNs period_ns)
      : vehicle_(parameters), supervisor_(logic, links), logic_(logic), period_ns_(period_ns) {
    own_codes = logic.codes;
  }

  void use_port() {
    port_ = std::make_unique<CommandPort>(logic_, kShortestLease_ms, kLongestLease_ms);
    port_->show(supervisor_.state());
  }

  // The daemon is started again; the hardware goes on.
  template <class P>
  void restart(const P& parameters) {
    std::destroy_at(&vehicle_);
    std::construct_at(&vehicle_, parameters);
    std::destroy_at(&supervisor_);
    std::construct_at(&supervisor_, logic_, Supervisor::Parameters{});
    if (port_) use_port();
  }

  // One frame.
  void step() {
    time_ns_ += period_ns_;
    in_.frame += 1;
    in_.time_ns = time_ns_;
    in_.sample_count = 0;
    self().sense();
    if (alter) alter(self());
    take_requests();
    cycle(vehicle_, supervisor_, in_, out_, [](Stage) {});
    if (port_) port_->show(supervisor_.state());
    if (executed) executed();
    self().obey();
    const auto& box = supervisor_.outbox();
    acks.insert(acks.end(), box.acks.begin(), box.acks.begin() + box.ack_count);
    events.insert(events.end(), box.events.begin(), box.events.begin() + box.event_count);
  }
  void run(double seconds) {
    for (const TimeNs end = later(seconds); time_ns_ < end;) step();
  }
  template <class Condition>
  bool run_until(Condition condition, double seconds) {
    for (const TimeNs end = later(seconds); time_ns_ < end;) {
      step();
      if (condition()) return true;
    }
    return false;
  }
  bool run_until(M mode, double seconds) {
    return run_until([&] { return this->mode() == mode; }, seconds);
  }
  bool run_until(State state, double seconds) {
    return run_until([&] { return this->state() == state; }, seconds);
  }

  template <class Kind>
  void send(Kind kind, std::initializer_list<double> parameters = {}, const char* from = "test",
            std::uint16_t flags = 0) {
    Request r{.source = source(from),
              .kind = static_cast<std::uint16_t>(kind),
              .flags = flags,
              .lease_ms = 1000};
    std::copy(parameters.begin(), parameters.end(), r.parameter.begin());
    put(r);
  }
  // Its number and time of arrival are set here; the number.
  std::uint64_t put(Request request) {
    request.sequence = ++sequence_;
    request.arrival_ns = time_ns_;
    if (port_) {
      port_->receive(request, 1, [this](const Ack& ack) { acks.push_back(ack); });
    } else {
      requests_.push_back(request);
    }
    return sequence_;
  }
  // Sends and steps; the verdict of the answer that refuses it, reason none: there is none.
  template <class Kind>
  Verdict ask(Kind kind, std::initializer_list<double> parameters = {}, const char* from = "test",
              std::uint16_t flags = 0) {
    acks.clear();
    send(kind, parameters, from, flags);
    step();
    const Ack* refused = last(Phase::rejected);
    return refused != nullptr ? refused->verdict : Verdict{};
  }
  template <class Kind>
  Reason why(Kind kind, std::initializer_list<double> parameters = {}) {
    return ask(kind, parameters).reason;
  }

  // Of a parameter, by its name; steps. The last answer.
  Ack set(const char* name, double value) {
    acks.clear();
    Request request{.source = source("test"),
                    .kind = static_cast<std::uint16_t>(CommandKind::set_parameter),
                    .parameter = {value},
                    .name = parameter_name(name)};
    put(request);
    step();
    return acks.empty() ? Ack{} : acks.back();
  }

  State state() const { return supervisor_.controller().state; }
  M mode() const { return static_cast<M>(supervisor_.controller().mode); }
  bool has(FaultId id, std::uint16_t subject = 0) const {
    return std::ranges::any_of(supervisor_.state().faults, [&](const FaultRecord& f) {
      return f.id == id && f.subject == subject;
    });
  }
  // The last one; nullptr: there is none.
  const EventRecord* heard(EventId id) const {
    const auto i = std::find_if(events.rbegin(), events.rend(), [&](const EventRecord& e) {
      return e.id == static_cast<std::uint16_t>(id);
    });
    return i != events.rend() ? &*i : nullptr;
  }
  const Ack* last(Phase phase) const {
    const auto i = std::find_if(acks.rbegin(), acks.rend(),
                                [&](const Ack& ack) { return ack.phase == phase; });
    return i != acks.rend() ? &*i : nullptr;
  }
  // The answer to the last command of this kind in this phase; nullptr: there is none.
  template <class Kind>
  const Ack* answer(Kind kind, Phase phase) const {
    const auto i = std::find_if(acks.rbegin(), acks.rend(), [&](const Ack& ack) {
      return ack.kind == static_cast<std::uint16_t>(kind) && ack.phase == phase;
    });
    return i != acks.rend() ? &*i : nullptr;
  }

  // Called before the cycle, when its inputs but the requests are there; and after it, before the
  // hardware obeys.
  std::function<void(Derived&)> alter;
  std::function<void()> executed;

  std::vector<Ack> acks;
  std::vector<EventRecord> events;
  Inputs<V> in_{};
  Outputs<V> out_{};
  V vehicle_;
  Supervisor supervisor_;
  Logic logic_;
  bool heartbeat_ = true;  // of the source "test", once per frame
  TimeNs time_ns_ = 1000 * kSecond;
  TimeNs period_ns_;

 private:
  Derived& self() { return static_cast<Derived&>(*this); }
  TimeNs later(double seconds) const { return time_ns_ + static_cast<TimeNs>(seconds * 1e9); }

  void take_requests() {
    if (port_) {
      if (heartbeat_)
        port_->receive({.source = source("test"), .arrival_ns = time_ns_}, 1, [](const Ack&) {});
      in_.request_count = port_->take(in_.requests);
      return;
    }
    in_.request_count = 0;
    for (const Request& r : requests_) in_.requests[in_.request_count++] = r;
    requests_.clear();
    if (heartbeat_ && in_.request_count < kMaxRequests)
      in_.requests[in_.request_count++] = {.source = source("test")};
  }

  std::unique_ptr<CommandPort> port_;
  std::vector<Request> requests_;
  std::uint64_t sequence_ = 0;
};

}  // namespace lss::safety
