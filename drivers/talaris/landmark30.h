#pragma once

// Gladiator LandMark 30: 18-byte packets at 200 Hz, RS-485 8E2 (docs/icd-talaris.md section 2;
// TALARIS thesis 4.4.4). It sends by itself; commands are written only when `configure` says so.
//
// A packet is good when it begins with 2A, its bytes sum to 0 and none is marked. That is enough
// right behind the last one, where it is due. Elsewhere its counter must continue, too: from the
// last good packet, or in the following packet, for which it is kept back.
//
// Stamps: the time of the first byte as in sensor_line.h, at most the stamp before plus one period
// for each count, plus 0.2 % for the sensor's clock; so the delay of a late reader is not taken for
// a late sensor. A packet more than 10 ms behind that restarts the rhythm, unless it was read
// together with others.

#include <cstdint>

#include "drivers/talaris/sensor_line.h"

namespace lss::talaris {

struct LandMark30Parameters {
  int baud = 115'200;
  int packets_per_frame = 40;
  TimeNs period_ns = 5 * kMillisecond;
  bool configure = false;            // pause, 200 Hz, run at opening and when it is silent
  TimeNs silent_after_ns = kSecond;  // ... for so long
};

class LandMark30 final : public SensorLine {
 public:
  static constexpr std::size_t kPacket = 18;

  explicit LandMark30(const LandMark30Parameters& parameters) noexcept;

  void restart(TimeNs now) noexcept override;
  void receive(std::span<const LineByte> bytes, TimeNs now) noexcept override;
  std::span<const std::uint8_t> transmit(TimeNs now) noexcept override;
  TimeNs next_wake() const noexcept override;

 private:
  enum class Looks : std::uint8_t { no_packet, marked, bad_sum, good };
  static constexpr int kDone = 12;  // of the commands: pauses, rate, run

  Looks look(std::size_t at) const noexcept;
  bool take_packet() noexcept;
  std::int64_t counts_since(std::uint8_t counter, TimeNs time_ns) const noexcept;
  bool goes_on(std::uint8_t counter, TimeNs time_ns) const noexcept;
  void accept() noexcept;
  TimeNs stamp(TimeNs raw_ns, std::int64_t counts) const noexcept;
  void tell(ImuStatus::Kind kind, std::size_t place, std::uint8_t index, std::uint8_t value,
            TimeNs time_ns) noexcept;
  void read_status(std::uint8_t counter, std::uint8_t value, TimeNs time_ns) noexcept;
  void read_scale(std::uint8_t value, TimeNs time_ns) noexcept;

  LandMark30Parameters parameters_;
  std::array<Held, 2 * kPacket> held_{};  // bytes that are no packet yet
  std::size_t size_ = 0;
  std::size_t behind_ = 0;  // bytes of the same read that are still to come
  bool in_step_ = false;    // the next packet is due at the front
  bool heard_ = false;
  std::uint8_t counter_ = 0;             // of the last good packet
  std::uint64_t count_ = 0;              // unwrapped
  TimeNs stamp_ns_ = 0;                  // its stamp
  std::array<std::int16_t, 14> told_{};  // last reports on itself; -1: none
  bool scale_known_ = false;
  std::uint8_t scale_ = 0, next_scale_ = 0;  // in force; last received
  int step_ = kDone;
  TimeNs step_ns_ = 0;   // when it is due
  TimeNs alive_ns_ = 0;  // last packet, or last command
  std::array<std::uint8_t, 8> out_{};
};

// Factors of a scale status.
double landmark_rate_unit_rad_s(std::uint8_t status) noexcept;
double landmark_force_unit_m_s2(std::uint8_t status) noexcept;
// A command: 2B, cmd0, cmd1, sum to 0, payload.
std::array<std::uint8_t, 8> landmark_command(std::uint8_t cmd0, std::uint8_t cmd1 = 0,
                                             std::uint32_t payload = 0) noexcept;
inline constexpr std::uint8_t kLandmarkPause = 0xD4, kLandmark200Hz = 0x02, kLandmark100Hz = 0x0A,
                              kLandmarkRun = 0x0D;

}  // namespace lss::talaris
