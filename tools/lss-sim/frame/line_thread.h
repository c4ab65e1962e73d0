#pragma once

// One serial line of a simulator: moves bytes between its pseudo-terminal and the UART of the
// devices.

#include <filesystem>

#include "drivers/lockstep/wire.h"
#include "tools/lss-sim/frame/pty_port.h"
#include "tools/lss-sim/frame/uart.h"
#include "tools/lss-sim/frame/wire_thread.h"

namespace lss::sim {

class LineThread final : public WireThread {
 public:
  LineThread(std::filesystem::path link, const Uart::Parameters& parameters, LineDevice& device);
  ~LineThread() override { stop(); }

  tl::expected<void, std::string> open() override;           // creates the port
  void set_fault(const Fault& fault, bool attach) override;  // of line_fault_kinds()
  bool wants_to_send() const override { return device_.wants_to_send(); }
  std::string place() const override;

 private:
  bool is_open() const override { return port_.is_open(); }
  int fd() const override { return port_.fd(); }
  void close(TimeNs now) override;
  TimeNs exchange(TimeNs now) override;
  void read(TimeNs now);

  LineDevice& device_;
  PtyPort port_;
  lockstep::Wire wire_{lockstep::Wire::Side::simulator};
  Uart uart_;
};

}  // namespace lss::sim
