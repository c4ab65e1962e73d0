#include "drivers/talaris/crossbow.h"

#include <algorithm>

#include "drivers/talaris/units.h"

namespace lss::talaris {
namespace {

constexpr std::uint8_t kHeader = 0xFF;

std::uint16_t u16(const std::uint8_t* at) { return static_cast<std::uint16_t>(at[0] << 8 | at[1]); }

}  // namespace

Crossbow::Crossbow(const CrossbowParameters& parameters) noexcept
    : SensorLine({parameters.baud, SerialFormat::Parity::none, 1, false}), parameters_(parameters) {
  status_.rate_unit_rad_s = parameters_.rate_range_deg_s * 1.5 / 32768 * kDegree;
  status_.force_unit_m_s2 = parameters_.force_range_g * 1.5 / 32768 * kG_m_s2;
  restart(0);
}

void Crossbow::restart(TimeNs now) noexcept {
  clear();
  begin(now);
}

void Crossbow::begin(TimeNs now) noexcept {
  step_ = Step::ping;
  step_ns_ = now;
  asked_ = false;
  silent_ = 0;
  size_ = 0;
}

void Crossbow::receive(std::span<const LineByte> bytes, TimeNs now) noexcept {
  status_.counters.bytes += bytes.size();
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    if (step_ != Step::run) {
      letter(bytes[i], now);
    } else if (!asked_) {
      ++status_.counters.skipped;
    } else {
      packet_byte(bytes[i], arrival_ns(now, i, bytes.size()));
    }
  }
}

void Crossbow::letter(const LineByte& byte, TimeNs now) noexcept {
  const bool ping = step_ == Step::pinged && byte.value == 'H';
  const bool scaled = step_ == Step::scaled && byte.value == 'C';
  if (byte.bad || (!ping && !scaled)) {
    ++status_.counters.skipped;
    return;
  }
  step_ = ping ? Step::polled : Step::run;
  step_ns_ = now;
  if (scaled) next_poll_ns_ = std::max(next_poll_ns_, now);
}

// 0xFF occurs in data: with a wrong sum, the packet may begin at a later one.
void Crossbow::packet_byte(const LineByte& byte, TimeNs time_ns) noexcept {
  if (size_ == 0 && byte.value != kHeader) {
    ++status_.counters.skipped;
    return;
  }
  held_[size_++] = {byte, time_ns};
  while (size_ == kPacket) {
    unsigned sum = 0;
    bool marked = false;
    for (std::size_t i = 0; i < kPacket; ++i) {
      if (i > 0 && i + 1 < kPacket) sum += held_[i].byte.value;
      marked = marked || held_[i].byte.bad;
    }
    if (!marked && (sum & 0xFF) == held_[kPacket - 1].byte.value) return accept();
    ++(marked ? status_.counters.parity : status_.counters.bad_check);
    const auto next = std::find_if(held_.begin() + 1, held_.end(),
                                   [](const Held& h) { return h.byte.value == kHeader; });
    status_.counters.skipped += static_cast<std::uint64_t>(next - held_.begin());
    size_ = static_cast<std::size_t>(held_.end() - next);
    std::copy(next, held_.end(), held_.begin());
  }
}

void Crossbow::accept() noexcept {
  std::array<std::uint8_t, kPacket> packet;
  for (std::size_t i = 0; i < kPacket; ++i) packet[i] = held_[i].byte.value;
  const TimeNs time_ns = std::max(held_[0].time_ns, status_.heard_ns + 1);
  size_ = 0;
  asked_ = false;
  silent_ = 0;
  ++status_.counters.packets;
  status_.heard_ns = time_ns;
  ImuPacket out;
  for (std::size_t i = 0; i < 3; ++i) {
    out.rate_rad_s[i] =
        static_cast<std::int16_t>(u16(&packet[1 + 2 * i])) * status_.rate_unit_rad_s;
    out.force_m_s2[i] =
        static_cast<std::int16_t>(u16(&packet[7 + 2 * i])) * status_.force_unit_m_s2;
  }
  out.temperature_degC = 44.44 * (u16(&packet[13]) * 5.0 / 4096 - 1.375);
  out.count = polls_;
  keep({time_ns, out});
  tick(polls_, time_ns, parameters_.packets_per_frame, parameters_.period_ns);
}

// A poll without an answer.
void Crossbow::missed() noexcept {
  ++status_.counters.lost;
  asked_ = false;
  size_ = 0;
  ++silent_;
}

std::span<const std::uint8_t> Crossbow::say(std::uint8_t letter) noexcept {
  ++status_.counters.commands;
  out_ = letter;
  return {&out_, 1};
}

std::span<const std::uint8_t> Crossbow::transmit(TimeNs now) noexcept {
  if (asked_ && now >= asked_ns_ + parameters_.reply_timeout_ns) missed();
  if (step_ == Step::run && silent_ >= parameters_.silent_polls) {
    ++status_.counters.restarts;
    begin(now);
  }
  switch (step_) {
    case Step::pinged:
    case Step::scaled:
      if (now < step_ns_ + parameters_.handshake_ns) return {};
      [[fallthrough]];
    case Step::ping:
      step_ = Step::pinged;
      step_ns_ = now;
      return say('R');
    case Step::polled: step_ = Step::told; return say('P');
    case Step::told:
      step_ = Step::scaled;
      step_ns_ = now;
      return say('c');
    case Step::run: break;
  }
  if (asked_ || now < next_poll_ns_) return {};
  const TimeNs skipped = (now - next_poll_ns_) / parameters_.period_ns;
  next_poll_ns_ += (skipped + 1) * parameters_.period_ns;
  polls_ += static_cast<std::uint64_t>(skipped) + 1;
  status_.counters.lost += static_cast<std::uint64_t>(skipped);
  asked_ = true;
  asked_ns_ = now;
  size_ = 0;
  out_ = 'G';
  return {&out_, 1};
}

TimeNs Crossbow::next_wake() const noexcept {
  switch (step_) {
    case Step::ping:
    case Step::polled:
    case Step::told: return INT64_MIN;
    case Step::pinged:
    case Step::scaled: return step_ns_ + parameters_.handshake_ns;
    case Step::run: break;
  }
  return asked_ ? asked_ns_ + parameters_.reply_timeout_ns : next_poll_ns_;
}

}  // namespace lss::talaris
