#pragma once

// Row xiii: a bus between a daemon and its simulated vehicle that stamps the first byte of a stop,
// by a FIFO thread of its own. Frames are looked at as the interface documents have them, not by
// the drivers of the daemon.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>

#include "drivers/time.h"
#include "tests/bench/realtime.h"

namespace lss::bench {

class StopLine {
 public:
  virtual ~StopLine() = default;

  // Where the daemon, or the echo, finds it: a path, or a port.
  virtual std::string where() const = 0;
  // From here on the first stop is looked for.
  void expect(TimeNs since_ns);
  TimeNs stopped_ns() const { return first_ns_; }  // 0: not yet
  TimeNs last_stop_ns() const { return last_ns_; }

 protected:
  void saw_stop(TimeNs begin_ns);
  void begin();                // the thread, by the constructors
  void end();                  // by the destructors
  virtual void forward() = 0;  // received data, in either direction; waits for at most 50 ms

 private:
  std::atomic<TimeNs> since_ns_{INT64_MAX}, first_ns_{0}, last_ns_{0};
  std::atomic<bool> stop_{false};
  std::optional<Fifo> thread_;
};

// RS-485 of Lunar Zebro: emergency stops, icd-zebro.md. Without a simulator nobody answers.
class PtyStopLine : public StopLine {
 public:
  explicit PtyStopLine(const std::filesystem::path& simulator = {});
  ~PtyStopLine() override;
  std::string where() const override { return terminal_.name(); }

 private:
  void forward() override;
  void look_at(std::span<const char> bytes, TimeNs now_ns);

  Terminal terminal_;
  int simulator_ = -1;
  std::string line_;  // from ':' on
  TimeNs line_ns_ = 0;
};

// CAN over UDP; `is_stop` of identifier and data. Port 0: nobody answers.
class CanStopLine : public StopLine {
 public:
  using IsStop = bool (*)(std::uint32_t id, std::span<const std::uint8_t> data);
  explicit CanStopLine(IsStop is_stop, std::uint16_t simulator = 0);
  ~CanStopLine() override;
  std::string where() const override { return std::to_string(port_); }

 private:
  void forward() override;
  void look_at(std::span<const std::uint8_t> datagram, TimeNs now_ns);

  IsStop is_stop_;
  int daemon_ = -1, simulator_ = -1;
  std::uint16_t port_ = 0;
  bool known_ = false;  // where the daemon sends from: daemon_ is connected to it
};

}  // namespace lss::bench
