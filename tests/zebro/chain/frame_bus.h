#pragma once

// The bus in virtual time, frame by frame: the master's bytes go to the modules as a whole when its
// last bit is on the wire, and so are their replies. The same bytes as on BusLine, through the same
// receivers, in a tenth of the time; replies arrive at the master's next turn, stamped with their
// end. `wire` gets the commands only, no requests. Faults are those of a line. One thread.

#include <array>
#include <random>

#include "tests/zebro/chain/bus.h"
#include "tools/lss-sim/frame/uart.h"

namespace lss::sim::zebro {
class Zebro;
}

namespace lss::zebro {

class FrameBus final : public Bus {
 public:
  // `modules`: outlives this.
  FrameBus(const LegBusParameters& parameters, sim::zebro::Zebro& modules, unsigned seed);

  void plug(bool plugged, TimeNs now) override;
  void turn(TimeNs now, std::span<const std::uint8_t>) override;
  TimeNs next_wake() const override { return open_ ? driver_.next_wake() : kNever; }

  sim::WireFaults faults;

 private:
  static constexpr TimeNs kNever = INT64_MAX;
  static constexpr std::size_t kMost = 32;  // frames under way in one direction

  struct Timed {
    TimeNs end_ns = 0;
    std::size_t size = 0;
    std::array<std::uint8_t, kMaxFrameCharacters> characters{};
    std::span<const std::uint8_t> bytes() const { return {characters.data(), size}; }
  };
  // Frames under way, in the order of their ends.
  struct Way {
    std::array<Timed, kMost> frames{};
    std::size_t first = 0, count = 0;
    Timed* next(TimeNs now);  // that has come, or nullptr
    void put(TimeNs end_ns, std::span<const std::uint8_t> bytes);
    void take() { first = (first + 1) % kMost, --count; }
  };

  void arrive(TimeNs now);
  void send(std::span<const std::uint8_t> frame, TimeNs now);
  void answer(std::span<const std::uint8_t> frame, TimeNs request_end_ns);
  void put(Way& way, TimeNs end_ns, std::span<const std::uint8_t> frame);

  sim::zebro::Zebro& modules_;
  TimeNs character_ns_;
  std::mt19937 random_;
  Way to_modules_, to_master_;
  TimeNs master_free_ns_ = 0, reply_free_ns_ = 0;
  bool open_ = false;
};

}  // namespace lss::zebro
