// Lunar Zebro's leg bus: the receiver of its frames, and the master of the bus that receives them.
// A leg turns only as the last orders say, and not after an emergency stop.

#include <cmath>
#include <optional>
#include <vector>

#include "drivers/zebro/leg_bus.h"
#include "tests/fuzz/fuzz.h"

namespace lss::zebro {
namespace {

using fuzz::must;

std::vector<Frame> all(Receiver& receiver) {
  std::vector<Frame> frames;
  while (const auto received = receiver.take()) frames.push_back(received->frame);
  return frames;
}

// The same frames from a stream that is split anywhere, and each is its own encoding.
void receive(fuzz::Input& in) {
  const Check check = in.below(2) == 0 ? Check::lrc : Check::crc8;
  const Stop stop = in.below(2) == 0 ? Stop::lf : Stop::crlf;
  Receiver pieces(check, stop), bytes(check, stop);
  while (!in.empty()) {
    const fuzz::Bytes piece = in.take(16);  // less than a frame
    pieces.receive(piece, 1);
    for (const std::uint8_t& byte : piece) bytes.receive({&byte, 1}, 1);
    const std::vector<Frame> frames = all(pieces);
    must(frames == all(bytes), "a stream that is split otherwise gives the same frames");
    for (const Frame& frame : frames) {
      std::array<std::uint8_t, kMaxFrameCharacters> out{};
      Receiver again(check, stop);
      again.receive(encode(frame, check, stop, out), 1);
      const auto same = again.take();
      must(same && same->frame == frame, "a frame that was received can be sent and received");
      must(again.counters().bad_check == 0, "... with its check");
    }
  }
}

class Master {
 public:
  explicit Master(fuzz::Input& in) : in_(in) { bus_.restart(now_); }

  void run() {
    while (!in_.empty()) {
      switch (in_.below(6)) {
        case 0: release(); break;
        case 1: reply(); break;
        case 2: bus_.receive(in_.take(in_.below(64)), now_); break;
        case 3:
          bus_.all_stop(now_);
          void_until_ = serial_;
          break;
        case 4: now_ += in_.number<std::uint16_t>() * TimeNs{500}; break;
        default: now_ += in_.byte() * kMillisecond;
      }
      send();
      look();
    }
  }

 private:
  void release() {
    orders_.issued_ns = now_ - in_.byte() * kMillisecond;
    if (in_.below(8) == 0) {
      ++orders_.emergency_serial;
      void_until_ = serial_;
    }
    for (ModuleOrder& order : orders_.module) {
      if (in_.below(2) == 0) continue;
      order = {.kind = static_cast<ModuleOrder::Kind>(1 + in_.below(6)),
               .position_cdeg = static_cast<std::uint16_t>(in_.number<std::uint16_t>() % 36'000),
               .arrive_ns = now_ + in_.number<std::int32_t>(),
               .serial = ++serial_};
    }
    bus_.release(orders_, now_);
  }

  // Of the module that was asked last, with any content.
  void reply() {
    Frame frame{asked_, static_cast<std::uint8_t>(0x40 + in_.below(4)), {}};
    for (std::uint8_t& byte : frame.data) byte = in_.byte();
    std::array<std::uint8_t, kMaxFrameCharacters> out{};
    bus_.receive(encode(frame, Check::lrc, Stop::lf, out), now_);
  }

  void send() {
    for (int frames = 0;; ++frames) {
      must(frames < 100, "transmit() comes to an end");
      const auto bytes = bus_.transmit(now_);
      if (bytes.empty()) break;
      Receiver module(Check::lrc, Stop::lf);
      module.receive(bytes, now_);
      const auto sent = module.take();
      must(sent.has_value(), "the master sends whole frames");
      if (sent->frame.address != kBroadcast) asked_ = sent->frame.address;
      check(sent->frame);
    }
    must(bus_.next_wake() > now_, "nothing is due when transmit() has nothing");
  }

  void check(const Frame& frame) {
    const auto code = static_cast<Code>(frame.code);
    if (code != Code::rotate_forward && code != Code::rotate_backward) return;
    must(frame.address >= 1 && frame.address <= kBusModules, "a leg turns alone");
    const ModuleOrder& order = orders_.module[frame.address - 1u];
    must(order.rotates(), "a leg turns by order only");
    must((order.kind == ModuleOrder::Kind::rotate_forward) == (code == Code::rotate_forward),
         "a leg turns the way that was ordered");
    must(order.serial > void_until_, "orders from before an emergency stop are void");
    must(now_ - orders_.issued_ns <= LegBusParameters{}.stale_after_ns, "old orders move nothing");
  }

  void look() {
    std::array<ModuleReply, LegBus::kMaxReplies> replies{};
    for (const ModuleReply& reply : std::span(replies).first(bus_.take(replies))) {
      must(reply.module < kBusModules, "a reply is of a module");
      const Status status = decode_status(reply.data);
      const Health health = decode_health(reply.data);
      must(std::isfinite(status.position_rad) && std::isfinite(status.velocity_rad_s) &&
               std::isfinite(status.current_A) && std::isfinite(health.temperature_degC) &&
               std::isfinite(health.supply_V) &&
               std::isfinite(decode_identity(reply.data).uptime_s),
           "measurements are numbers");
      (void)possible(status);
      (void)possible(health);
    }
  }

  fuzz::Input& in_;
  LegBus bus_{LegBusParameters{}};
  BusOrders orders_{};
  TimeNs now_ = kSecond;
  std::uint32_t serial_ = 0, void_until_ = 0;
  std::uint8_t asked_ = 1;
};

}  // namespace
}  // namespace lss::zebro

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lss::fuzz::Input in({data, size});
  if (in.below(2) == 0) {
    lss::zebro::receive(in);
  } else {
    lss::zebro::Master(in).run();
  }
  return 0;
}
