#include "drivers/canopen/velocity_bus.h"

#include <algorithm>

namespace lss::canopen {
namespace {

MasterParameters master_of(const VelocityBusParameters& p) noexcept {
  MasterParameters master;
  master.heartbeat = p.heartbeat;
  master.sync_period_ns = p.period_ns;
  for (std::size_t i = 0; i < p.node.size() && p.node[i] != 0; ++i)
    master.nodes[i] = velocity_drive(p.node[i], p.acceleration_rpm_s);
  return master;
}

std::size_t drives_of(const VelocityBusParameters& p) noexcept {
  return static_cast<std::size_t>(std::ranges::find(p.node, 0) - p.node.begin());
}

}  // namespace

bool stops_all(const VelocityOrders& orders) noexcept {
  return orders.quick_stop ||
         std::ranges::none_of(orders.drive, [](const VelocityOrder& o) { return o.enabled; });
}

VelocityBus::VelocityBus(const VelocityBusParameters& parameters) noexcept
    : DriveBus(master_of(parameters), parameters, drives_of(parameters)) {
  restart(0);
}

void VelocityBus::release(const VelocityOrders& orders, TimeNs now) noexcept {
  orders_ = orders;
  release_orders(orders, now);
}

VelocityBus::Order VelocityBus::order(std::size_t drive) const noexcept {
  return {orders_.drive[drive].enabled, orders_.drive[drive].motor_rpm};
}

void VelocityBus::send_order(std::size_t drive, bool enabled, TimeNs) noexcept {
  const std::uint16_t word = controlword(drive, enabled);
  const double rpm = word == kEnableOperation ? orders_.drive[drive].motor_rpm : 0;
  master_.send_rpdo(drive, 1, drive_rpdo(word, field_i32(rpm)));
}

void VelocityBus::send_stop(std::size_t drive, std::uint16_t controlword) noexcept {
  master_.send_rpdo(drive, 1, drive_rpdo(controlword, 0));
}

void VelocityBus::receive(std::span<const CanFrame> frames) noexcept {
  PdoSample raw;
  for (const CanFrame& frame : frames) {
    master_.receive(frame);
    while (master_.take(raw)) {
      if (raw.number != 1 || raw.size != 8) continue;
      const VelocitySample sample{raw.time_ns, raw.node, u16(raw.data, 0),
                                  static_cast<double>(i32(raw.data, 2)),
                                  static_cast<double>(i16(raw.data, 6))};
      heard(raw.node, sample.statusword);
      if (!samples_.put(sample)) ++counters_.overflows;
    }
  }
}

const VelocityStatus& VelocityBus::status() noexcept {
  for (std::size_t i = 0; i < master_.nodes(); ++i) describe(i, status_.link[i]);
  describe(status_.counters);
  return status_;
}

}  // namespace lss::canopen
