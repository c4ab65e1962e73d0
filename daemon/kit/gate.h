#pragma once

// The end of a vehicle's gate, where a failed check means the safe orders at once. Frame thread.

#include "daemon/cycle/supervisor.h"

namespace lss::kit {

// What leaves the gate, as `sent`: what was wanted, or, when a check failed, the vehicle's `orders`
// after make_safe().
template <class Check, class Orders, class MakeSafe>
const Orders& pass_gate(Check failed, const Orders& wanted, const Orders& orders, Orders& sent,
                        Supervisor& supervisor, MakeSafe&& make_safe) noexcept {
  sent = wanted;
  if (failed != Check::passed) {
    supervisor.gate_closed(static_cast<double>(failed));
    make_safe();
    sent = orders;
  }
  return sent;
}

}  // namespace lss::kit
