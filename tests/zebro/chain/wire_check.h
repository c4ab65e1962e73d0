#pragma once

// Conditions on the bus after an emergency (docs/icd-zebro.md section 10), judged by the frames on
// the wire alone.

#include <span>
#include <string>

#include "tests/zebro/chain/bus_line.h"

namespace lss::zebro {

// From `order_ns`, when the order reached the bus: the emergency stop to all begins within two
// frame times, then one goes to each module, all within ten; from there on nothing but requests and
// stops until `until_ns`. Empty: satisfied; otherwise the violation, for a person.
std::string emergency_on_wire(std::span<const WireFrame> wire, const LegBusParameters& bus,
                              TimeNs order_ns, TimeNs until_ns);

// Nothing from `from_ns` on until `until_ns` can move a leg.
std::string harmless(std::span<const WireFrame> wire, TimeNs from_ns, TimeNs until_ns);

}  // namespace lss::zebro
