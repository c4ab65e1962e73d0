#include "daemon/vehicles/talaris/actuation.h"

namespace lss::talaris {

void EdgeReport::sent(std::uint8_t before, const ValveSequencer& valves, TimeNs due_ns,
                      TimeNs now) noexcept {
  open = valves.open();
  for (std::size_t i = 0; i < kHopperValves; ++i) {
    if (((before ^ open) >> i & 1) == 0) continue;
    ((open >> i & 1) != 0 ? opened_ns : shut_ns)[i] = now;
    last_ns = now;
    last_late_ns = now - due_ns;
  }
  counters = valves.counters();
}

Actuation::Actuation(const ValveParameters& parameters, HopperCan& can)
    : can_(can), parameters_(parameters), valves_(parameters) {
  twin_.seal(bytes_of(valves_));
}

void Actuation::release(const TalarisOrders& orders, TimeNs release_ns, TimeNs now) noexcept {
  check(now);
  obey(now);
  if (latch_.passes(orders.all_stop, orders.boundary_ns)) {
    TalarisOrders due = orders;
    due.release_ns = release_ns;
    valves_.release(due, now);
    send(release_ns, now);  // before anything slow
    can_.release(due);
    reset_serial_ = due.node_reset_serial;
  } else {
    ++said_.refused_orders;
    send(now, now);
  }
  twin_.seal(bytes_of(valves_));
}

void Actuation::run(TimeNs now) noexcept {
  check(now);
  const TimeNs due_ns = next_wake();
  obey(now);
  send(due_ns, now);
  twin_.seal(bytes_of(valves_));
}

// Nobody knows when which valve was to be shut. The fans go on: the vehicle may be in the air.
void Actuation::check(TimeNs now) noexcept {
  if (twin_.check(bytes_of(valves_)) != MemoryCheck::lost) return;
  valves_.begin_again(parameters_, said_.counters, said_.open, now);
  memory_lost_.store(true, std::memory_order_relaxed);
}

// Orders of the actuate thread itself.
void Actuation::obey(TimeNs now) noexcept {
  if (const std::uint32_t generation = sender_.generation(); generation != generation_) {
    generation_ = generation;
    valves_.reopened(now);
  }
  if (!latch_.fell()) return;
  valves_.all_stop(now);
  send(now, now);
  // Another number would boot nodes, now and when the cycle's own number comes again.
  can_.release({.issued_ns = now,
                .boundary_ns = now,
                .release_ns = now,
                .all_stop = true,
                .node_reset_serial = reset_serial_});
}

void Actuation::send(TimeNs due_ns, TimeNs now) noexcept {
  const std::uint8_t before = valves_.open();
  for (CanFrame frame; valves_.due(now, frame);)
    valves_.sent(sender_.send(frame) == CanSender::Result::sent, now);
  said_.sent(before, valves_, due_ns, now);
  said_.sender = sender_.counters();
  said_.all_stop_pending = latch_.pending();
  report_.put(said_);
}

}  // namespace lss::talaris
