#include "tests/zebro/chain/wire_check.h"

#include <fmt/format.h>

#include <algorithm>

namespace lss::zebro {
namespace {

double ms(TimeNs time) { return static_cast<double>(time) * 1e-6; }

std::string text(const WireFrame& frame, TimeNs since) {
  return fmt::format("code {:#04x} to address {} after {:.3f} ms", frame.frame.code,
                     frame.frame.address, ms(frame.begin_ns - since));
}

std::span<const WireFrame> from(std::span<const WireFrame> wire, TimeNs time) {
  const auto first = std::ranges::lower_bound(wire, time, {}, &WireFrame::begin_ns);
  return wire.subspan(static_cast<std::size_t>(first - wire.begin()));
}

}  // namespace

std::string emergency_on_wire(std::span<const WireFrame> wire, const LegBusParameters& bus,
                              TimeNs order_ns, TimeNs until_ns) {
  const TimeNs frame_ns = frame_time_ns(bus.baud, bus.stop);
  // The frame on the wire, and the next one, could not be cancelled.
  auto left = from(wire, order_ns);
  while (!left.empty() && left.front().begin_ns - order_ns <= 2 * frame_ns &&
         !(left.front().code() == Code::emergency_stop && left.front().frame.address == kBroadcast))
    left = left.subspan(1);
  if (left.empty() || left.front().begin_ns - order_ns > 2 * frame_ns)
    return fmt::format("no emergency stop to all within {:.3f} ms", ms(2 * frame_ns));
  if (left.size() <= kBusModules) return "the emergency stops to each module are missing";
  for (std::size_t i = 0; i < kBusModules; ++i) {
    const WireFrame& stop = left[i + 1];
    if (stop.code() != Code::emergency_stop || stop.frame.address != bus.address[i])
      return fmt::format("instead of the emergency stop to address {}: {}", bus.address[i],
                         text(stop, order_ns));
    if (stop.end_ns - order_ns > 10 * frame_ns)
      return fmt::format("the emergency stop to address {} is over after {:.3f} ms only",
                         bus.address[i], ms(stop.end_ns - order_ns));
  }
  return harmless(left, left.front().begin_ns, until_ns);
}

std::string harmless(std::span<const WireFrame> wire, TimeNs from_ns, TimeNs until_ns) {
  for (const WireFrame& frame : from(wire, from_ns)) {
    if (frame.begin_ns >= until_ns) break;
    if (frame.code() != Code::request_data && frame.code() != Code::emergency_stop &&
        frame.code() != Code::stop_motion_control)
      return text(frame, from_ns);
  }
  return {};
}

}  // namespace lss::zebro
