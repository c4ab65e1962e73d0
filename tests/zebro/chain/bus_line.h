#pragma once

// The bus thread of daemon/runtime/serial_bus.h in virtual time: the shipping bus master on one
// side, the line of lss-sim on the other, every byte at its instant. A turn does what a turn of the
// thread does, in the same order. Writes down every frame of the master with its time on the wire.
// One thread.

#include "tests/zebro/chain/bus.h"
#include "tools/lss-sim/frame/uart.h"

namespace lss::zebro {

class BusLine final : public Bus {
 public:
  // `line`: outlives this.
  BusLine(const LegBusParameters& parameters, sim::Uart& line);

  void plug(bool plugged, TimeNs now) override;
  void turn(TimeNs now, std::span<const std::uint8_t> bytes) override;
  TimeNs next_wake() const override;

 private:
  void serve(TimeNs now, std::span<const std::uint8_t> bytes);
  void log(std::span<const std::uint8_t> frame, TimeNs now);
  void tell(TimeNs now);

  sim::Uart& line_;
  TimeNs wire_free_ns_ = 0;
  bool plugged_ = true, open_ = false;
  TimeNs reopen_ns_ = 0;
  TimeNs turned_ns_ = 0;
  int turns_at_once_ = 0;  // at one instant
};

}  // namespace lss::zebro
