#pragma once

// One CAN bus of a simulator: moves frames between the master's end and the bus of the nodes.

#include <string>

#include "tools/lss-sim/frame/can_bus.h"
#include "tools/lss-sim/frame/can_end.h"
#include "tools/lss-sim/frame/wire_thread.h"

namespace lss::sim {

class CanThread final : public WireThread {
 public:
  // `name`: for people.
  CanThread(std::string name, std::string address, const CanBus::Parameters& parameters,
            CanDevice& device);
  ~CanThread() override { stop(); }

  tl::expected<void, std::string> open() override { return end_.open(); }
  void set_fault(const Fault& fault, bool attach) override;  // of can_fault_kinds()
  bool wants_to_send() const override { return device_.wants_to_send(); }
  std::string place() const override { return "CAN bus " + name_ + " at " + end_.address(); }
  bool is_off();  // bus-off

 private:
  bool is_open() const override { return end_.is_open(); }
  int fd() const override { return end_.fd(); }
  void close(TimeNs now) override;
  TimeNs exchange(TimeNs now) override;

  std::string name_;
  CanDevice& device_;
  CanEnd end_;
  CanBus bus_;
};

}  // namespace lss::sim
