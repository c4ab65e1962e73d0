#pragma once

// One complete frame: inputs, outputs and times of the cycle. FrameView refers to the originals
// (frame thread), FrameRecord has a copy (readers of records).

#include "daemon/cycle/cycle.h"
#include "daemon/record/fields.h"

namespace lss {

// Inputs of any vehicle.
template <class V, class X>
requires requires(X& x) { x.samples, x.requests, x.overrun_limit; }
void fields(V& v, X& x) {
  static_assert(kMembers<std::remove_const_t<X>> == 12);
  v("frame", x.frame);
  v("time_ns", x.time_ns);
  v.list("samples", x.samples, x.sample_count);
  v.list("requests", x.requests, x.request_count);
  v("bus", x.bus);
  v("late_commands", x.late_commands);
  v("overrun_limit", x.overrun_limit);
  v("held", x.held);
  v("shut_down", x.shut_down);
  v("memory", x.memory);
}

namespace record {

template <class Vehicle>
struct FrameRecord {
  Inputs<Vehicle> in;
  typename Vehicle::Command command;
  Supervisor::Outbox outbox;
  SupervisorState state;
  typename Vehicle::Telemetry telemetry;
  bool data_requested;
  TimingPoints timing;
};

template <class Vehicle>
struct FrameView {
  const Inputs<Vehicle>& in;
  const typename Vehicle::Command& command;
  const Supervisor::Outbox& outbox;
  const SupervisorState& state;
  const typename Vehicle::Telemetry& telemetry;
  const bool& data_requested;
  const TimingPoints& timing;
};

// The outputs of the cycle: the same inputs give the same, to the bit.
template <class V, class X>
void outputs(V& v, X& x) {
  v("command", x.command);
  v("outbox", x.outbox);
  v("state", x.state);
  v("telemetry", x.telemetry);
  v("data_requested", x.data_requested);
}

// FrameRecord and FrameView.
template <class V, class X>
requires requires(X& x) { x.in, x.outbox, x.timing; }
void fields(V& v, X&& x) {
  using Frame = std::remove_cvref_t<X>;
  if constexpr (std::is_default_constructible_v<Frame>)  // no references
    static_assert(kMembers<Frame> == 7);
  v("in", x.in);
  outputs(v, x);
  v("timing", x.timing);
}

// The first fault of the frame; none when there is none.
inline FaultId first_fault(const Supervisor::Outbox& outbox) noexcept {
  for (std::uint32_t i = 0; i < outbox.event_count; ++i) {
    if (outbox.events[i].id >= kFaultEventBase)
      return static_cast<FaultId>(outbox.events[i].id - kFaultEventBase);
  }
  return FaultId::none;
}

}  // namespace record
}  // namespace lss
