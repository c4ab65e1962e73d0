#pragma once

// The parameters of Lunar Zebro that can change while the daemon runs (docs/parameters.md).
// Constant data; any thread.

#include "daemon/cycle/tunables.h"
#include "daemon/vehicles/zebro/config.h"

namespace lss::zebro {

const Tuning<Parameters>& tuning() noexcept;

// nullptr, or what is wrong with the limits of current (Zebro thesis [P-Int-1]).
const char* check_currents(const Parameters& parameters) noexcept;
// nullptr, or what is wrong with the movements of the panel.
const char* check_panel(const Parameters& parameters) noexcept;
// How long a safe stop takes at most, when it goes as planned: the end of a step or of a stroke,
// and lying down.
double safe_stop_s(const Parameters& parameters) noexcept;
// Of clients, or the shortest that may be asked for.
TimeNs usual_lease_ns(const Parameters& parameters) noexcept;
// After it a safe stop ends before a silent OBC is an emergency.
double longest_lease_ms(const Parameters& parameters) noexcept;
// nullptr, or that a silent OBC would be an emergency before a safe stop after the usual lease has
// ended.
const char* check_stop(const Parameters& parameters) noexcept;

}  // namespace lss::zebro
