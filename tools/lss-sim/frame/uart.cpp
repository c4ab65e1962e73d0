#include "tools/lss-sim/frame/uart.h"

#include <algorithm>
#include <limits>

namespace lss::sim {
namespace {

constexpr FaultArgument kProbability[] = {{"P", "probability", 0, 1}};
constexpr FaultArgument kLate[] = {{"MS", "milliseconds", 0, 10'000}};
constexpr FaultKind kKinds[] = {
    {"noise", kProbability, "each character loses a bit with this probability, either direction"},
    {"drop", kProbability, "a frame is lost with this probability, either direction"},
    {"duplicate", kProbability, "a reply comes twice with this probability"},
    {"late", kLate, "replies come so much later"},
    {"bus-cut", {}, "the bus is cut: nothing passes in either direction"},
};
constexpr FaultArgument kLine = {"LINE", "number of the line, as they are named at start", 1, 8,
                                 true};
constexpr FaultArgument kLineOnly[] = {kLine};
constexpr FaultArgument kLineProbability[] = {kLine, kProbability[0]};
constexpr FaultArgument kLineLate[] = {kLine, kLate[0]};
constexpr FaultArgument kLineUnplug[] = {kLine, {"SECONDS", "how long it is gone", 0.01, 3600}};
constexpr FaultKind kNumberedKinds[] = {
    {"line-noise", kLineProbability, "a line's characters lose a bit, either direction", false, 1},
    {"line-drop", kLineProbability, "a line's frames are lost, either direction", false, 1},
    {"line-duplicate", kLineProbability, "what a line's device says comes twice", false, 1},
    {"line-late", kLineLate, "what a line's device says comes so much later", false, 1},
    {"line-cut", kLineOnly, "the line is cut: nothing passes in either direction", false, 1},
    {"line-unplug", kLineUnplug, "the line's port goes away, and comes back", false, 1},
};
constexpr TimeNs kMostWaited = 2;  // replies that another waits for

}  // namespace

std::span<const FaultKind> line_fault_kinds() { return kKinds; }
std::span<const FaultKind> numbered_line_fault_kinds() { return kNumberedKinds; }

Uart::Uart(const Parameters& parameters, LineDevice& device)
    : parameters_(parameters),
      device_(device),
      character_ns_(parameters.paced ? parameters.bits * kSecond / parameters.baud : 0),
      random_(parameters.seed) {}

std::uint8_t Uart::through_noise(std::uint8_t character) {
  if (!strikes(faults.noise, random_)) return character;
  const int bit = std::uniform_int_distribution(0, 7)(random_);
  return static_cast<std::uint8_t>(character ^ (1 << bit));
}

void Uart::from_master(std::span<const std::uint8_t> characters, TimeNs now) {
  for (const std::uint8_t character : characters) {
    master_free_ns_ = std::max(now, master_free_ns_) + character_ns_;
    if (character == parameters_.frame_begin) dropping_ = strikes(faults.drop, random_);
    if (faults.cut || dropping_) continue;
    arriving_.push_back({master_free_ns_, through_noise(character)});
  }
}

void Uart::advance(TimeNs now) {
  while (!arriving_.empty() && arriving_.front().at_ns <= now) {
    const Timed arrived = arriving_.front();
    arriving_.pop_front();
    const std::span<const std::uint8_t> reply = device_.receive(arrived.character, arrived.at_ns);
    say(reply, arrived.at_ns + character_ns_);
  }
  for (auto frame = device_.send(now); !frame.empty(); frame = device_.send(now)) say(frame, now);
}

void Uart::say(std::span<const std::uint8_t> frame, TimeNs now) {
  if (frame.empty() || faults.cut || strikes(faults.drop, random_)) return;
  queue(frame, now);
  if (strikes(faults.duplicate, random_)) queue(frame, now);
}

// A reply begins one character after its request ended. The distance between requests is at least
// the length of a reply, so without faults replies never overlap; a late or doubled reply waits for
// the one before. A reply that would wait too long behind others is lost, so a cleared fault leaves
// no backlog.
void Uart::queue(std::span<const std::uint8_t> frame, TimeNs now) {
  const TimeNs wanted_ns = now + faults.late_ns;
  const TimeNs most_ns = kMostWaited * static_cast<TimeNs>(frame.size()) * character_ns_;
  if (reply_free_ns_ - wanted_ns > most_ns) return;
  TimeNs at_ns = std::max(wanted_ns, reply_free_ns_);
  for (const std::uint8_t character : frame) {
    at_ns += character_ns_;
    leaving_.push_back({at_ns, through_noise(character)});
  }
  reply_free_ns_ = at_ns;
}

std::span<const std::uint8_t> Uart::take(TimeNs now) {
  taken_.clear();
  if (next_wake() > now) return {};
  while (!leaving_.empty() && leaving_.front().at_ns <= now) {
    taken_.push_back(leaving_.front().character);
    leaving_.pop_front();
  }
  return taken_;
}

TimeNs Uart::next_wake() const {
  TimeNs wake = std::numeric_limits<TimeNs>::max();
  for (const Timed& character : arriving_) {
    wake = character.at_ns;
    if (character.character == parameters_.frame_end) break;
  }
  TimeNs piece = std::numeric_limits<TimeNs>::max();
  for (std::size_t i = 0; i < std::min(parameters_.fifo, leaving_.size()); ++i) {
    piece = leaving_[i].at_ns;
    if (leaving_[i].character == parameters_.frame_end) break;
  }
  return std::min(wake, piece);
}

void Uart::forget() {
  arriving_.clear();
  leaving_.clear();
}

}  // namespace lss::sim
