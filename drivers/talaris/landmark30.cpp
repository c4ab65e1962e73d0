#include "drivers/talaris/landmark30.h"

#include <algorithm>

#include "drivers/talaris/units.h"

namespace lss::talaris {
namespace {

constexpr std::uint8_t kSync = 0x2A, kCommandSync = 0x2B;
constexpr TimeNs kLate = 10 * kMillisecond;  // a stamp late by more restarts the rhythm
constexpr int kDrift = 500;                  // one part in so many: largest drift of the sensor
constexpr int kMostMissing = 8;              // largest count step to a packet out of step
constexpr int kPauses = 10;
constexpr TimeNs kPauseEvery = kMillisecond;
constexpr TimeNs kBetweenCommands = 20 * kMillisecond;
constexpr std::uint8_t kScaleBit = 0x40, kScaleBits = 0x3F;

// Places in its last reports on itself.
constexpr std::size_t kToldFirmware = 0, kToldProduct = 2, kToldFilter = 4, kToldBoard = 5,
                      kToldSerial = 9, kToldTest = 13;

std::int16_t i16(const std::uint8_t* at) {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(at[0] | at[1] << 8));
}

}  // namespace

double landmark_rate_unit_rad_s(std::uint8_t status) noexcept {
  switch (status & 0x31) {
    case 0x11: return 0.015 * kDegree;
    case 0x21: return 0.05 * kDegree;
    case 0x31: return 0.005 * kDegree;
    default: return 0.01 * kDegree;
  }
}

double landmark_force_unit_m_s2(std::uint8_t status) noexcept {
  constexpr double kUnit_g[8] = {1e-3, 1e-4, 1e-4, 5e-4, 5e-4, 5e-4, 1e-3, 2e-3};
  return kUnit_g[status >> 1 & 7] * kG_m_s2;
}

std::array<std::uint8_t, 8> landmark_command(std::uint8_t cmd0, std::uint8_t cmd1,
                                             std::uint32_t payload) noexcept {
  std::array<std::uint8_t, 8> bytes = {kCommandSync, cmd0, cmd1, 0};
  for (std::size_t i = 0; i < 4; ++i) bytes[4 + i] = static_cast<std::uint8_t>(payload >> (8 * i));
  unsigned sum = 0;
  for (const std::uint8_t byte : bytes) sum += byte;
  bytes[3] = static_cast<std::uint8_t>(0u - sum);
  return bytes;
}

LandMark30::LandMark30(const LandMark30Parameters& parameters) noexcept
    : SensorLine({parameters.baud, SerialFormat::Parity::even, 2, true}), parameters_(parameters) {
  restart(0);
}

// Counts, frames and scale go on, also in the air: until the sensor says its scale again, up to 11
// packets come. Its other reports on itself are repeated.
void LandMark30::restart(TimeNs now) noexcept {
  clear();
  size_ = 0;
  in_step_ = heard_ = false;
  told_.fill(-1);
  status_.rate_unit_rad_s = landmark_rate_unit_rad_s(scale_);
  status_.force_unit_m_s2 = landmark_force_unit_m_s2(scale_);
  step_ = parameters_.configure ? 0 : kDone;
  step_ns_ = alive_ns_ = now;
}

void LandMark30::receive(std::span<const LineByte> bytes, TimeNs now) noexcept {
  status_.counters.bytes += bytes.size();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    held_[size_++] = {bytes[i], arrival_ns(now, i, bytes.size())};
    behind_ = bytes.size() - 1 - i;
    while (take_packet()) {
    }
  }
}

// Classifies the `kPacket` bytes from `at` on.
LandMark30::Looks LandMark30::look(std::size_t at) const noexcept {
  if (held_[at].byte.value != kSync) return Looks::no_packet;
  unsigned sum = 0;
  bool marked = false;
  for (std::size_t i = at; i < at + kPacket; ++i) {
    sum += held_[i].byte.value;
    marked = marked || held_[i].byte.bad;
  }
  if (marked) return Looks::marked;
  return sum % 256 == 0 ? Looks::good : Looks::bad_sum;
}

// One step at the front of the buffer. False: more bytes are needed.
bool LandMark30::take_packet() noexcept {
  if (size_ == 0) return false;
  if (held_[0].byte.value != kSync) {
    in_step_ = false;
    ++status_.counters.skipped;
    drop(held_, size_, 1);
    return true;
  }
  if (size_ < kPacket) return false;
  const Looks looks = look(0);
  if (looks != Looks::good) {
    // Damaged packets are counted apart from bytes that never were a packet.
    if (in_step_) ++(looks == Looks::marked ? status_.counters.parity : status_.counters.bad_check);
    in_step_ = false;
    ++status_.counters.skipped;
    drop(held_, size_, 1);
    return true;
  }
  const std::uint8_t counter = held_[1].byte.value;
  if (!in_step_ && !goes_on(counter, held_[0].time_ns)) {
    if (size_ < 2 * kPacket) return false;  // the next one decides
    const auto next = static_cast<std::uint8_t>(counter + 1);
    if (look(kPacket) != Looks::good || held_[kPacket + 1].byte.value != next) {
      ++status_.counters.skipped;
      drop(held_, size_, 1);
      return true;
    }
  }
  in_step_ = true;
  accept();
  drop(held_, size_, kPacket);
  return true;
}

// The counts from the last good packet to one with `counter` at that time: the number nearest to
// the elapsed time.
std::int64_t LandMark30::counts_since(std::uint8_t counter, TimeNs time_ns) const noexcept {
  const TimeNs away = time_ns - stamp_ns_;
  const std::int64_t by_time = (away + parameters_.period_ns / 2) / parameters_.period_ns;
  const auto by_counter = static_cast<std::uint8_t>(counter - counter_);
  const std::int64_t turns = (by_time - by_counter + 128) >> 8;
  return turns * 256 + by_counter;
}

bool LandMark30::goes_on(std::uint8_t counter, TimeNs time_ns) const noexcept {
  if (!heard_) return false;
  const std::int64_t counts = counts_since(counter, time_ns);
  return counts >= 1 && counts <= kMostMissing;
}

// The packet at the front.
void LandMark30::accept() noexcept {
  std::array<std::uint8_t, kPacket> packet;
  for (std::size_t i = 0; i < kPacket; ++i) packet[i] = held_[i].byte.value;
  const std::uint8_t counter = packet[1];
  const TimeNs raw_ns = held_[0].time_ns;
  std::int64_t counts = 1;
  if (heard_) {
    counts = counts_since(counter, raw_ns);
    if (counts <= 0) {
      // A restarted sensor, or old bytes: the same number is no new packet.
      if (counter == counter_) {
        ++status_.counters.repeated;
        return;
      }
      counts = static_cast<std::uint8_t>(counter - counter_);
    }
    status_.counters.lost += static_cast<std::uint64_t>(counts - 1);
  }
  counter_ = counter;
  count_ += static_cast<std::uint64_t>(counts);
  stamp_ns_ = stamp(raw_ns, counts);
  heard_ = true;
  ++status_.counters.packets;
  status_.heard_ns = stamp_ns_;
  alive_ns_ = std::max(alive_ns_, raw_ns);

  read_status(counter, packet[16], stamp_ns_);
  ImuPacket out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.rate_rad_s[i] = i16(&packet[2 + 2 * i]) * status_.rate_unit_rad_s;
    out.force_m_s2[i] = i16(&packet[8 + 2 * i]) * status_.force_unit_m_s2;
  }
  out.temperature_degC = i16(&packet[14]) * 0.01;
  out.count = count_;
  out.status = packet[16];
  keep({stamp_ns_, out});
  tick(count_, stamp_ns_, parameters_.packets_per_frame, parameters_.period_ns);
}

// With more packets behind it this one waited to be read, and its time is that of the rhythm.
TimeNs LandMark30::stamp(TimeNs raw_ns, std::int64_t counts) const noexcept {
  if (!heard_) return raw_ns;
  const TimeNs period = parameters_.period_ns;
  const TimeNs latest = stamp_ns_ + counts * (period + period / kDrift);
  if (raw_ns - latest > kLate && behind_ < kPacket) return raw_ns;
  return std::max(std::min(raw_ns, latest), stamp_ns_ + 1);
}

void LandMark30::tell(ImuStatus::Kind kind, std::size_t place, std::uint8_t index,
                      std::uint8_t value, TimeNs time_ns) noexcept {
  std::int16_t& told = told_[place + index];
  if (told == value) return;
  told = value;
  keep({time_ns, ImuStatus{kind, index, value, 0, 0}});
}

void LandMark30::read_status(std::uint8_t counter, std::uint8_t value, TimeNs time_ns) noexcept {
  using Kind = ImuStatus::Kind;
  if (counter <= 1) {
    const bool major = counter == 0;
    if ((value & 0x80) == 0) {
      return tell(major ? Kind::firmware_major : Kind::firmware_minor, kToldFirmware + counter, 0,
                  value & 0x3F, time_ns);
    }
    return tell(major ? Kind::product : Kind::release, kToldProduct + counter, 0, value & 0x7F,
                time_ns);
  }
  if (counter == 247) return tell(Kind::filter, kToldFilter, 0, value, time_ns);
  if (counter >= 252) {
    return tell(Kind::serial_number, kToldSerial, static_cast<std::uint8_t>(counter - 252), value,
                time_ns);
  }
  if (counter >= 248) {
    return tell(Kind::board_number, kToldBoard, static_cast<std::uint8_t>(counter - 248), value,
                time_ns);
  }
  if ((value & kScaleBit) == 0) {
    return tell(Kind::test_flags, kToldTest, 0, value & kScaleBits, time_ns);
  }
  read_scale(value, time_ns);
}

// Noise that the sum does not detect must not change a factor: a new one has to come twice.
void LandMark30::read_scale(std::uint8_t value, TimeNs time_ns) noexcept {
  const std::uint8_t scale = value & kScaleBits;
  const bool again = scale == next_scale_;
  next_scale_ = scale;
  if (scale_known_ && (scale == scale_ || !again)) return;
  scale_known_ = true;
  scale_ = scale;
  status_.rate_unit_rad_s = landmark_rate_unit_rad_s(scale);
  status_.force_unit_m_s2 = landmark_force_unit_m_s2(scale);
  keep({time_ns, ImuStatus{ImuStatus::Kind::scale, 0, value, status_.rate_unit_rad_s,
                           status_.force_unit_m_s2}});
}

// Pause ten times, 200 Hz, run.
std::span<const std::uint8_t> LandMark30::transmit(TimeNs now) noexcept {
  if (!parameters_.configure) return {};
  if (step_ == kDone && now - alive_ns_ >= parameters_.silent_after_ns) {
    ++status_.counters.restarts;
    step_ = 0;
    step_ns_ = now;
  }
  if (step_ == kDone || now < step_ns_) return {};
  ++status_.counters.commands;
  if (step_ < kPauses) {
    ++step_;
    step_ns_ = now + (step_ < kPauses ? kPauseEvery : kBetweenCommands);
    out_[0] = kLandmarkPause;
    return std::span(out_).first(1);
  }
  out_ = landmark_command(step_ == kPauses ? kLandmark200Hz : kLandmarkRun);
  step_ns_ = now + kBetweenCommands;
  if (++step_ == kDone) alive_ns_ = now;
  return out_;
}

TimeNs LandMark30::next_wake() const noexcept {
  if (!parameters_.configure) return INT64_MAX;
  return step_ == kDone ? alive_ns_ + parameters_.silent_after_ns : step_ns_;
}

}  // namespace lss::talaris
