#include "tests/zebro/drivers/leg_bus_world.h"

#include <algorithm>
#include <cmath>

namespace lss::zebro {
namespace {

void put_u16(Frame& frame, std::size_t at, TimeNs value) {
  const auto v = static_cast<std::uint16_t>(std::clamp<TimeNs>(value, 0, 65'535));
  frame.data[at] = static_cast<std::uint8_t>(v >> 8);
  frame.data[at + 1] = static_cast<std::uint8_t>(v & 0xFF);
}

TimeNs get_u16(const Frame& frame, std::size_t at) {
  return frame.data[at] * 256 + frame.data[at + 1];
}

}  // namespace

World::World(const LegBusParameters& p, TimeNs turn_around_characters)
    : parameters(p),
      bus(p),
      frame_ns(frame_time_ns(p.baud, p.stop)),
      character_ns_(frame_ns / static_cast<TimeNs>(frame_characters(p.stop))),
      turn_around_ns_(turn_around_characters * character_ns_) {
  bus.restart(now);
}

void World::order(int m, ModuleOrder::Kind kind, std::uint16_t position_cdeg, TimeNs arrive_ns) {
  ModuleOrder& o = orders.module[static_cast<std::size_t>(m)];
  o = {kind, position_cdeg, arrive_ns, o.serial + 1};
}

void World::run_frames(int n) {
  for (int i = 0; i < n; ++i) {
    release();
    run_for(parameters.period_ns);
    take_all();
  }
}

void World::run_until(TimeNs end) {
  while (true) {
    for (auto bytes = bus.transmit(now); !bytes.empty(); bytes = bus.transmit(now)) written(bytes);
    const TimeNs wake = bus.next_wake();
    stuck |= wake <= now;
    TimeNs next = std::max(wake, now + 1);
    if (!events_.empty()) next = std::min(next, events_.begin()->first);
    if (next > end) break;
    now = next;
    while (!events_.empty() && events_.begin()->first <= now) {
      const auto event = events_.extract(events_.begin());
      event.mapped()();
    }
  }
  now = end;
}

void World::written(std::span<const std::uint8_t> bytes) {
  const TimeNs start = std::max(now, tx_free_ns_);
  too_far_ahead |= start - now > frame_ns;
  tx_free_ns_ = start + frame_ns;
  Receiver receiver(parameters.check, parameters.stop);
  receiver.receive(bytes, now);
  const Frame frame = receiver.take().value().frame;
  sent.push_back({start, tx_free_ns_, frame});
  events_.emplace(tx_free_ns_, [this, frame] { execute(frame); });
}

void World::execute(const Frame& frame) {
  for (std::size_t i = 0; i < module.size(); ++i) {
    TestModule& m = module[i];
    if (m.dead || (frame.address != kBroadcast && frame.address != parameters.address[i])) continue;
    const auto code = static_cast<Code>(frame.code);
    if (code != Code::request_data && m.deaf != 0) {
      m.deaf = std::max(m.deaf - 1, -1);
      continue;
    }
    switch (code) {
      case Code::start_motion_control: m.on = true; break;
      case Code::stop_motion_control:
      case Code::emergency_stop: m.on = false; break;
      case Code::rotate_forward:
      case Code::rotate_backward:
        if (!m.on) break;
        m.set_point_cdeg = static_cast<std::uint16_t>(get_u16(frame, 0));
        m.arrival_ns = now + get_u16(frame, 2) * kMillisecond;
        break;
      case Code::reset:
        m.on = false;
        m.boot_ns = now;
        m.reset_since_status = m.tells_resets;
        break;
      default: reply(frame);
    }
  }
}

void World::reply(const Frame& asked) {
  const auto i = static_cast<std::size_t>(
      std::find(parameters.address.begin(), parameters.address.end(), asked.address) -
      parameters.address.begin());
  TestModule& m = module[i];
  Frame frame{asked.address, static_cast<std::uint8_t>(0x40 + asked.data[0]), {}};
  if (asked.data[0] == 0) {
    put_u16(frame, 0, (m.on ? 1 : 0) | (m.reset_since_status ? 0x80 : 0));
    put_u16(frame, 2, m.set_point_cdeg);
    m.reset_since_status = false;
  } else if (asked.data[0] == 1) {
    put_u16(frame, 4, m.set_point_cdeg);
    put_u16(frame, 6, m.on ? (m.arrival_ns - now) / kMillisecond : 0);
  } else {
    const auto uptime_ms =
        std::llround(static_cast<double>(now - m.boot_ns) * m.clock / kMillisecond);
    put_u16(frame, 4, uptime_ms >> 16);
    put_u16(frame, 6, uptime_ms & 0xFFFF);
  }
  std::array<std::uint8_t, kMaxFrameCharacters> buffer{};
  const auto bytes = encode(frame, parameters.check, parameters.stop, buffer);
  std::vector<std::string> lines{{bytes.begin(), bytes.end()}};
  if (reply_filter) lines = reply_filter(frame, lines[0]);

  TimeNs at = now + turn_around_ns_;
  collision |= at < rx_free_ns_;
  at = std::max(at, rx_free_ns_);  // as a pseudo-terminal does; a wire would lose both
  for (const std::string& line : lines) {
    for (const char c : line) {
      at += character_ns_;
      events_.emplace(at, [this, c] {
        const auto byte = static_cast<std::uint8_t>(c);
        bus.receive(std::span(&byte, 1), now);
      });
    }
  }
  rx_free_ns_ = at;
}

std::vector<Sent> World::sent_with(Code code) const {
  std::vector<Sent> found;
  for (const Sent& s : sent) {
    if (s.frame.code == static_cast<std::uint8_t>(code)) found.push_back(s);
  }
  return found;
}

std::vector<Sent> World::sent_to(std::uint8_t address, Code code) const {
  std::vector<Sent> found = sent_with(code);
  std::erase_if(found, [address](const Sent& s) { return s.frame.address != address; });
  return found;
}

std::vector<ModuleReply> World::take_all() {
  std::vector<ModuleReply> all(LegBus::kMaxReplies);
  all.resize(bus.take(all));
  return all;
}

}  // namespace lss::zebro
