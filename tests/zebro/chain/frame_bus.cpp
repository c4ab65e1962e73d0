#include "tests/zebro/chain/frame_bus.h"

#include <algorithm>

#include "tools/lss-sim/zebro/vehicle.h"

namespace lss::zebro {
namespace {

constexpr TimeNs kMostWaited =
    2;  // replies that another waits for, as in tools/lss-sim/frame/uart.cpp
constexpr std::size_t kCodeAt = 3;  // characters of the code in a frame: two digits

bool asks(std::span<const std::uint8_t> frame) {
  return frame[kCodeAt] == '0' &&
         frame[kCodeAt + 1] == '0' + static_cast<std::uint8_t>(Code::request_data);
}

}  // namespace

FrameBus::FrameBus(const LegBusParameters& parameters, sim::zebro::Zebro& modules, unsigned seed)
    : Bus(parameters),
      modules_(modules),
      character_ns_(10 * kSecond / parameters.baud),
      random_(seed) {}

FrameBus::Timed* FrameBus::Way::next(TimeNs now) {
  return count > 0 && frames[first].end_ns <= now ? &frames[first] : nullptr;
}

void FrameBus::Way::put(TimeNs end_ns, std::span<const std::uint8_t> bytes) {
  if (count == kMost) return;
  Timed& frame = frames[(first + count) % kMost];
  frame.end_ns = end_ns;
  frame.size = bytes.size();
  std::ranges::copy(bytes, frame.characters.begin());
  ++count;
}

void FrameBus::plug(bool plugged, TimeNs now) {
  const auto held = hold(now);
  if (plugged && !open_) driver_.restart(now);
  if (!plugged) to_modules_.count = to_master_.count = 0;
  open_ = plugged;
  report_.was_open |= plugged;
  report_.open = open_;
  report_.time_ns = now;
}

void FrameBus::turn(TimeNs now, std::span<const std::uint8_t>) {
  const auto held = hold(now);
  if (open_) {
    arrive(now);
    obey(now);
    for (auto out = driver_.transmit(now); !out.empty(); out = driver_.transmit(now))
      send(out, now);
    take_replies();
  }
  report_.counters = driver_.counters();
  report_.all_stop_pending = latch_.pending();
  report_.time_ns = now;
}

// Data received by now, on both sides.
void FrameBus::arrive(TimeNs now) {
  while (const Timed* frame = to_modules_.next(now)) {
    const auto reply = modules_.receive(frame->bytes(), frame->end_ns);
    if (!reply.empty() && !faults.cut && !sim::strikes(faults.drop, random_)) {
      answer(reply, frame->end_ns);
      if (sim::strikes(faults.duplicate, random_)) answer(reply, frame->end_ns);
    }
    to_modules_.take();
  }
  while (const Timed* frame = to_master_.next(now)) {
    driver_.receive(frame->bytes(), frame->end_ns);
    to_master_.take();
  }
}

void FrameBus::send(std::span<const std::uint8_t> frame, TimeNs now) {
  const TimeNs begin_ns = std::max(now, master_free_ns_);
  master_free_ns_ = begin_ns + frame_ns_;
  if (!asks(frame)) {
    overheard_.receive(frame, now);
    if (const auto received = overheard_.take())
      wire.push_back({begin_ns, master_free_ns_, received->frame});
  }
  if (faults.cut || sim::strikes(faults.drop, random_)) return;
  put(to_modules_, master_free_ns_, frame);
}

// A reply begins one character after its request ended, or waits for the one before, but not long.
void FrameBus::answer(std::span<const std::uint8_t> frame, TimeNs request_end_ns) {
  const TimeNs wanted_ns = request_end_ns + character_ns_ + faults.late_ns;
  if (reply_free_ns_ - wanted_ns > kMostWaited * frame_ns_) return;
  reply_free_ns_ = std::max(wanted_ns, reply_free_ns_) + frame_ns_;
  put(to_master_, reply_free_ns_, frame);
}

void FrameBus::put(Way& way, TimeNs end_ns, std::span<const std::uint8_t> frame) {
  if (faults.noise <= 0) return way.put(end_ns, frame);
  std::array<std::uint8_t, kMaxFrameCharacters> heard{};
  for (std::size_t i = 0; i < frame.size(); ++i) {
    const int flip =
        sim::strikes(faults.noise, random_) ? 1 << std::uniform_int_distribution(0, 7)(random_) : 0;
    heard[i] = static_cast<std::uint8_t>(frame[i] ^ flip);
  }
  way.put(end_ns, std::span(heard).first(frame.size()));
}

}  // namespace lss::zebro
