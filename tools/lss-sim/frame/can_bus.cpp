#include "tools/lss-sim/frame/can_bus.h"

#include <algorithm>
#include <limits>

namespace lss::sim {
namespace {

constexpr FaultArgument kProbability[] = {{"P", "probability", 0, 1}};
constexpr FaultArgument kLate[] = {{"MS", "milliseconds", 0, 10'000}};
constexpr FaultArgument kSeconds[] = {{"SECONDS", "how long", 0.01, 3600}};
constexpr FaultKind kKinds[] = {
    {"noise", kProbability, "a frame arrives with a wrong byte or length, either direction"},
    {"drop", kProbability, "a frame is lost with this probability, either direction"},
    {"duplicate", kProbability, "a frame comes twice with this probability, either direction"},
    {"late", kLate, "frames of nodes come so much later"},
    {"bus-cut", {}, "the bus is cut: nothing passes in either direction"},
    {"bus-off", kSeconds, "the interface reports bus-off, and its restart after this time"},
};

// Linux's error frames (linux/can/error.h), which cannelloni carries like any other.
constexpr std::uint32_t kBusOff = 0x40, kRestarted = 0x100;

// All bits with stuffing: start of frame to CRC.
class Bits {
 public:
  void add(std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) add_bit((value >> i & 1) != 0);
  }
  std::uint32_t crc() const { return crc_; }
  int total() const { return total_; }

 private:
  void add_bit(bool bit) {
    const bool top = (crc_ >> 14 & 1) != 0;
    crc_ = (crc_ << 1) & 0x7FFF;
    if (bit != top) crc_ ^= 0x4599;
    ++total_;
    run_ = bit == last_ ? run_ + 1 : 1;
    last_ = bit;
    if (run_ < 5) return;
    ++total_;  // a stuff bit, which begins a new run
    last_ = !bit;
    run_ = 1;
  }

  std::uint32_t crc_ = 0;
  int total_ = 0, run_ = 0;
  bool last_ = true;  // the bus is recessive before a frame
};

}  // namespace

int bits_on_wire(const CanFrame& frame) {
  constexpr int kAfterCrc =
      1 + 1 + 1 + 7 + 3;  // CRC delimiter, ACK slot and delimiter, end of frame, intermission
  Bits bits;
  bits.add(0, 1);
  if (frame.extended) {
    bits.add(frame.id >> 18, 11);
    bits.add(3, 2);
    bits.add(frame.id & 0x3'FFFF, 18);
    bits.add(frame.remote ? 1 : 0, 1);
    bits.add(0, 2);
  } else {
    bits.add(frame.id, 11);
    bits.add(frame.remote ? 1 : 0, 1);
    bits.add(0, 2);
  }
  bits.add(frame.size, 4);
  for (std::size_t i = 0; i < frame.size && !frame.remote; ++i) bits.add(frame.data[i], 8);
  bits.add(bits.crc(), 15);
  return bits.total() + kAfterCrc;
}

std::span<const FaultKind> can_fault_kinds() { return kKinds; }

CanBus::CanBus(const Parameters& parameters, CanDevice& device)
    : parameters_(parameters), device_(device), random_(parameters.seed) {}

CanFrame CanBus::through_noise(CanFrame frame) {
  if (!strikes(faults.noise, random_)) return frame;
  std::uniform_int_distribution<unsigned> any(0, 255);
  if (frame.size == 0 || any(random_) % 4 == 0) {
    frame.size = static_cast<std::uint8_t>((frame.size + 1 + any(random_) % 8) % 9);
  } else {
    frame.data[any(random_) % frame.size] ^= static_cast<std::uint8_t>(1 + any(random_) % 255);
  }
  return frame;
}

void CanBus::from_master(const CanFrame& frame, TimeNs now) {
  if (!frame.error) master_.push_back({now, frame});
}

void CanBus::advance(TimeNs now) {
  if (off_until_ns_ != 0 && off_until_ns_ <= now) bus_off(now, 0);
  collect(now);
  while ((wire_ || begin(now)) && wire_->end_ns <= now) {
    const OnWire done = *wire_;
    wire_.reset();
    free_ns_ = done.end_ns;
    deliver(done.frame, done.by_master, done.end_ns);
    collect(done.end_ns);
  }
}

void CanBus::collect(TimeNs now) {
  while (const auto frame = device_.send()) nodes_.push_back({now, *frame});
}

// When the bus is free and frames wait, puts the one that wins the arbitration on the wire.
bool CanBus::begin(TimeNs now) {
  TimeNs first_ns = master_.empty() ? std::numeric_limits<TimeNs>::max() : master_.front().ready_ns;
  for (const Waiting& waiting : nodes_) first_ns = std::min(first_ns, waiting.ready_ns);
  const TimeNs start_ns = std::max(free_ns_, first_ns);
  if (start_ns > now) return false;

  auto best = nodes_.end();
  for (auto it = nodes_.begin(); it != nodes_.end(); ++it) {
    const bool lower = best == nodes_.end() || it->frame.id < best->frame.id;
    if (it->ready_ns <= start_ns && lower) best = it;
  }
  const bool master_waits = !master_.empty() && master_.front().ready_ns <= start_ns;
  const bool by_master =
      master_waits && (best == nodes_.end() || master_.front().frame.id <= best->frame.id);
  const CanFrame frame = by_master ? master_.front().frame : best->frame;
  if (by_master) {
    master_.pop_front();
  } else {
    nodes_.erase(best);
  }
  const TimeNs takes_ns =
      parameters_.paced ? bits_on_wire(frame) * kSecond / parameters_.bit_rate : 0;
  wire_ = OnWire{start_ns + takes_ns, frame, by_master};
  return true;
}

void CanBus::deliver(const CanFrame& frame, bool by_master, TimeNs at_ns) {
  if (faults.cut || off_until_ns_ != 0 || strikes(faults.drop, random_)) return;
  const int times = strikes(faults.duplicate, random_) ? 2 : 1;
  for (int i = 0; i < times; ++i) {
    if (by_master) {
      device_.receive(through_noise(frame));
    } else {
      to_master(through_noise(frame), at_ns + faults.late_ns);
    }
  }
}

void CanBus::to_master(const CanFrame& frame, TimeNs at_ns) {
  // After `late` was cleared, a new frame must not overtake delayed ones.
  const TimeNs after_ns = arriving_.empty() ? at_ns : arriving_.back().ready_ns;
  arriving_.push_back({std::max(at_ns, after_ns), frame});
}

std::span<const CanFrame> CanBus::take(TimeNs now) {
  taken_.clear();
  while (!arriving_.empty() && arriving_.front().ready_ns <= now) {
    taken_.push_back(arriving_.front().frame);
    arriving_.pop_front();
  }
  return taken_;
}

TimeNs CanBus::next_wake() const {
  TimeNs wake = std::numeric_limits<TimeNs>::max();
  if (wire_) wake = std::min(wake, wire_->end_ns);
  if (off_until_ns_ != 0) wake = std::min(wake, off_until_ns_);
  if (!arriving_.empty()) wake = std::min(wake, arriving_.front().ready_ns);
  return wake;
}

void CanBus::forget() {
  master_.clear();
  nodes_.clear();
  arriving_.clear();
  wire_.reset();
}

void CanBus::bus_off(TimeNs now, TimeNs duration_ns) {
  const bool was_off = is_off();
  off_until_ns_ = duration_ns > 0 ? now + duration_ns : 0;
  if (was_off == is_off()) return;
  CanFrame report{.id = is_off() ? kBusOff : kRestarted, .error = true, .size = 8};
  to_master(report, now);
}

}  // namespace lss::sim
