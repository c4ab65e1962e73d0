#pragma once

// Crossbow IMU400 class: 18-byte packets, each polled with 'G', RS-232 8N1 38400
// (docs/icd-talaris.md section 3; TALARIS thesis 5.3.2). Polled on a grid of our clock; a packet
// counts as the poll that it answers, so frames keep their phase when one is lost.

#include <cstdint>

#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

struct CrossbowParameters {
  int baud = 38'400;
  int packets_per_frame = 20;
  TimeNs period_ns = 10 * kMillisecond;
  TimeNs reply_timeout_ns = 8 * kMillisecond;  // from the poll to the last byte
  TimeNs handshake_ns = 100 * kMillisecond;    // for one answer at opening
  int silent_polls = 100;                      // unanswered ones in a row: opened again
  double rate_range_deg_s = 100;               // of the model: GR
  double force_range_g = 2;                    // of the model: GA
};

class Crossbow final : public SensorLine {
 public:
  static constexpr std::size_t kPacket = 18;

  explicit Crossbow(const CrossbowParameters& parameters) noexcept;

  void restart(TimeNs now) noexcept override;
  void receive(std::span<const LineByte> bytes, TimeNs now) noexcept override;
  std::span<const std::uint8_t> transmit(TimeNs now) noexcept override;
  TimeNs next_wake() const noexcept override;

 private:
  // At opening 'R' is answered by 'H', then 'P' (polled), then 'c' is answered by 'C' (scaled).
  enum class Step : std::uint8_t { ping, pinged, polled, told, scaled, run };

  std::span<const std::uint8_t> say(std::uint8_t letter) noexcept;
  void begin(TimeNs now) noexcept;
  void missed() noexcept;
  void letter(const LineByte& byte, TimeNs now) noexcept;
  void packet_byte(const LineByte& byte, TimeNs time_ns) noexcept;
  void accept() noexcept;

  CrossbowParameters parameters_;
  std::uint8_t out_ = 0;
  Step step_ = Step::ping;
  TimeNs step_ns_ = 0;  // when it began
  TimeNs next_poll_ns_ = 0;
  bool asked_ = false;
  TimeNs asked_ns_ = 0;
  std::uint64_t polls_ = 0;  // on the grid, those not made included
  int silent_ = 0;           // polls in a row
  std::array<Held, kPacket> held_{};
  std::size_t size_ = 0;
};

}  // namespace lss::talaris
