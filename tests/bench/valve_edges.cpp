// Row xi: the edges of a valve of TALARIS, by its own sequencer on the actuate thread between
// releases.

#include <unistd.h>

#include <array>
#include <atomic>

#include "daemon/runtime/frame_engine.h"
#include "drivers/serial/serial_port.h"
#include "drivers/talaris/valves.h"
#include "tests/bench/edge_error.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

using talaris::TalarisOrders;

// Frames by the clock, no sensor being there; each opens valve 1 and shuts it.
constexpr TimeNs kFrame = 10 * kMillisecond, kOffset = 2 * kMillisecond;
constexpr TimeNs kDelay = 2 * kMillisecond, kOn = 4 * kMillisecond;

class Valve {
 public:
  Valve(SerialPort& port, std::size_t count) : port_(port) {
    errors.issued_us.reserve(count);
    errors.written_us.reserve(count);
  }
  Errors errors;
  std::atomic<bool> over{false};

  void release(const TalarisOrders& orders, const Boundary& boundary) noexcept {
    TalarisOrders due = orders;
    due.release_ns = boundary.time_ns + kOffset;
    valves_.release(due, now_ns());
    send(now_ns());
  }
  TimeNs next_wake() const noexcept { return valves_.next_wake(); }
  void run(TimeNs issued_ns) noexcept {
    const TimeNs due_ns = valves_.next_wake();
    const std::uint8_t before = valves_.open();
    send(issued_ns);
    const TimeNs written_ns = now_ns();
    if (valves_.open() == before || over) return;
    errors.issued_us.push_back(static_cast<double>(issued_ns - due_ns) * 1e-3);
    errors.written_us.push_back(static_cast<double>(written_ns - due_ns) * 1e-3);
    over = errors.issued_us.size() == errors.issued_us.capacity();
  }

 private:
  void send(TimeNs now) noexcept {
    for (CanFrame frame; valves_.due(now, frame);)
      valves_.sent(port_.write(std::span(frame.data).first(frame.size)).bytes == frame.size, now);
  }

  SerialPort& port_;
  talaris::ValveSequencer valves_{{.frame_ns = kFrame}};
};

}  // namespace

Errors valve_edges(int count, TimeNs spin_ns) {
  Terminal terminal;
  SerialPort port;
  if (port.open(terminal.name().c_str(), 115'200, false) != SerialPort::Status::ok)
    throw NotHere("a pseudo-terminal cannot be opened as a port here");
  SensorFrames frames({.packets = 1, .period_ns = kFrame, .grace_ns = kMillisecond});
  FrameEngine<SensorFrames, TalarisOrders> engine(
      frames, {.period_ns = kFrame, .offset_ns = kOffset, .actuate_spin_ns = spin_ns});
  Valve valve(port, static_cast<std::size_t>(count));
  {
    Fifo frame("frame", kFramePriority, measured_cpu(), [&] {
      engine.frame(
          [](const Boundary& boundary, const Released&, TimingPoints&) noexcept {
            TalarisOrders orders{.issued_ns = boundary.time_ns, .boundary_ns = boundary.time_ns};
            orders.enabled = 1;
            orders.pulse[0] = {.delay_ns = kDelay, .on_ns = kOn};
            return orders;
          },
          [](const TimingPoints&) noexcept {});
    });
    Fifo actuate("actuate", kActuatePriority, measured_cpu(), [&] {
      engine.actuate([&](const TalarisOrders& orders,
                         const Boundary& boundary) noexcept { valve.release(orders, boundary); },
                     valve);
    });
    // The far end takes the bytes.
    const auto drain = [&] {
      std::array<char, 256> bytes;
      while (::read(terminal.fd(), bytes.data(), bytes.size()) > 0) {
      }
      return valve.over.load();
    };
    [[maybe_unused]] const bool done = eventually(drain, std::chrono::minutes(5));
    engine.stop();
  }
  return valve.errors;
}

}  // namespace lss::bench
