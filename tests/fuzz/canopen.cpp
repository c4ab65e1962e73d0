// CANopen: SDO answers, PDOs, EMCY, heartbeats and anything else on the buses of Ardito, of TALARIS
// and of a vehicle with servos only. Frames that the masters send are possible ones, and no drive
// is enabled after an all-stop.

#include <limits>
#include <utility>
#include <vector>

#include "drivers/ardito/rover_bus.h"
#include "drivers/canopen/velocity_bus.h"
#include "drivers/talaris/hopper_bus.h"
#include "tests/fuzz/fuzz.h"

namespace lss {
namespace {

using canopen::kHeartbeat, canopen::kSdoAnswer, canopen::kSdoRequest;
using fuzz::must;

double any_number(fuzz::Input& in) {
  switch (in.below(6)) {
    case 0: return std::numeric_limits<double>::quiet_NaN();
    case 1: return std::numeric_limits<double>::infinity();
    case 2: return in.number<double>();
    default: return in.number<std::int16_t>();
  }
}

struct Rover {
  ardito::RoverBusParameters parameters{};
  ardito::RoverBus bus{parameters};
  ardito::RoverOrders orders{};
  std::array<ardito::RoverSample, ardito::RoverBus::kMaxSamples> samples{};

  void order(fuzz::Input& in) {
    for (ardito::WheelOrder& wheel : orders.wheel) wheel = {in.below(2) == 0, any_number(in)};
    for (ardito::SteeringOrder& steering : orders.steering)
      steering = {in.below(2) == 0, any_number(in)};
    orders.clutches = in.byte();
  }
  bool drive(std::uint32_t node) const {
    return std::ranges::count(parameters.wheel_node, node) != 0 ||
           std::ranges::count(parameters.steering_node, node) != 0;
  }
  std::uint32_t device_type(std::uint32_t node) const {
    const auto master = ardito::master_parameters(parameters);
    for (const canopen::NodeParameters& one : master.nodes)
      if (one.node == node) return one.device_type;
    return 0;
  }
};

struct Servos {
  canopen::VelocityBusParameters parameters = [] {
    canopen::VelocityBusParameters with;
    with.node = {1, 2, 3, 4};
    return with;
  }();
  canopen::VelocityBus bus{parameters};
  canopen::VelocityOrders orders{};
  std::array<canopen::VelocitySample, canopen::VelocityBus::kMaxSamples> samples{};

  void order(fuzz::Input& in) {
    for (canopen::VelocityOrder& drive : orders.drive) drive = {in.below(2) == 0, any_number(in)};
  }
  bool drive(std::uint32_t node) const { return node >= 1 && node <= 4; }
  std::uint32_t device_type(std::uint32_t) const { return canopen::kServo; }
};

// Its bus has no drives: fans, and valves that other threads open.
struct Hopper {
  talaris::HopperBusParameters parameters = [] {
    talaris::HopperBusParameters with;
    with.load_cell = true;
    return with;
  }();
  talaris::HopperBus bus{parameters};
  talaris::TalarisOrders orders{};
  std::array<talaris::TalarisSample, talaris::HopperBus::kMaxSamples> samples{};

  void order(fuzz::Input& in) {
    orders.all_stop = in.below(4) == 0;
    orders.boot_allowed = in.below(2) == 0;
    orders.enabled = in.byte();
    for (std::uint16_t& width : orders.fan_us) width = in.number<std::uint16_t>();
    orders.node_reset_serial += in.below(8) == 0 ? 1 : 0;
    orders.reset_nodes = in.byte();
  }
  std::uint32_t device_type(std::uint32_t node) const {
    const auto master = talaris::master_parameters(parameters);
    for (const canopen::NodeParameters& one : master.nodes)
      if (one.node == node) return one.device_type;
    return 0;
  }
};

template <class Vehicle>
class World {
 public:
  explicit World(fuzz::Input& in) : in_(in) { vehicle_.bus.restart(now_); }

  void run() {
    while (!in_.empty()) {
      switch (in_.below(7)) {
        case 0: release(); break;
        case 1: answer(); break;
        case 2:
        case 3: any_frame(); break;
        case 4: all_stop(); break;
        case 5: now_ += in_.number<std::uint16_t>() * TimeNs{5'000}; break;
        default: now_ += in_.byte() * 10 * kMillisecond;
      }
      send();
      const std::size_t samples = vehicle_.bus.take(vehicle_.samples);
      must(samples <= vehicle_.samples.size(), "samples have their room");
      (void)vehicle_.bus.status();
    }
  }

 private:
  static constexpr bool kDrives = requires(Vehicle & vehicle) { vehicle.orders.emergency_serial; };

  void release() {
    auto& orders = vehicle_.orders;
    orders.issued_ns = now_ - in_.byte() * 2 * kMillisecond;
    vehicle_.order(in_);
    if constexpr (kDrives) {
      orders.serial += in_.below(4);
      const unsigned what = in_.byte();
      orders.quick_stop = (what & 1u) != 0;
      orders.standing = (what & 2u) != 0;
      orders.fault_reset_serial += what >> 2 & 1u;
      orders.node_reset_serial += what >> 3 & 1u;
      orders.reset_nodes = in_.number<std::uint16_t>();
      orders.next_frame_ns = now_ + in_.byte() * kMillisecond;
      if ((what & 0x70u) == 0) {
        ++orders.emergency_serial;
        ended_ = orders.serial;
      }
      may_move_ = orders.serial > ended_ && !orders.quick_stop;
    }
    vehicle_.bus.release(orders, now_);
  }
  void all_stop() {
    if constexpr (kDrives) {
      vehicle_.bus.all_stop(now_);
      ended_ = vehicle_.orders.serial;
      may_move_ = false;
    } else {
      vehicle_.bus.restart(now_);
    }
  }

  void receive(CanFrame frame) {
    frame.time_ns = now_;
    vehicle_.bus.receive({&frame, 1});
  }
  // What a good node answers: the bus comes to operation.
  void answer() {
    CanFrame frame;
    for (const CanFrame& request : std::exchange(requests_, {})) {
      const std::uint32_t node = request.id & 0x7Fu;
      frame = {.id = kSdoAnswer + node, .size = 8, .data = request.data};
      const bool reads = request.data[0] == 0x40;
      frame.data[0] = reads ? 0x43 : 0x60;
      const std::uint32_t value = reads ? vehicle_.device_type(node) : 0;
      std::memcpy(&frame.data[4], &value, sizeof value);
      receive(frame);
    }
    const std::uint32_t node = in_.byte() & 0x7Fu;
    constexpr std::array<std::uint8_t, 4> kStates = {0x00, 0x05, 0x7F, 0x04};
    receive({.id = kHeartbeat + node, .size = 1, .data = {kStates[in_.below(4)]}});
  }
  void any_frame() {
    CanFrame frame;
    const auto bits = in_.number<std::uint16_t>();
    frame.id = bits & 0x7FFu;
    frame.extended = (bits & 0xF000u) == 0xF000u;
    frame.remote = (bits & 0xF000u) == 0xE000u;
    frame.size = (bits >> 11 & 1u) != 0 ? in_.below(9) : 8;
    for (std::size_t i = 0; i < frame.size; ++i) frame.data[i] = in_.byte();
    receive(frame);
  }

  void send() {
    CanFrame frame;
    for (int frames = 0; vehicle_.bus.transmit(now_, frame); ++frames) {
      must(frames < 1000, "transmit() comes to an end");
      must(frame.size <= 8 && frame.id <= kStandardIds, "a frame that is sent is possible");
      if ((frame.id & ~0x7Fu) == kSdoRequest) {
        if (requests_.size() < 16) requests_.push_back(frame);
      }
      if constexpr (kDrives) {
        const bool orders = (frame.id & ~0x7Fu) == canopen::kRpdo1 &&
                            vehicle_.drive(frame.id & 0x7Fu) && frame.size >= 2;
        if (orders && (frame.data[0] & 0x0Fu) == canopen::kEnableOperation)
          must(may_move_, "no drive is enabled after a stop");
      }
    }
    must(vehicle_.bus.next_wake() > now_, "nothing is due when transmit() has nothing");
  }

  fuzz::Input& in_;
  Vehicle vehicle_{};
  TimeNs now_ = kSecond;
  std::uint32_t ended_ = 0;
  bool may_move_ = false;
  std::vector<CanFrame> requests_;
};

}  // namespace
}  // namespace lss

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lss::fuzz::Input in({data, size});
  switch (in.below(3)) {
    case 0: lss::World<lss::Rover>(in).run(); break;
    case 1: lss::World<lss::Hopper>(in).run(); break;
    default: lss::World<lss::Servos>(in).run();
  }
  return 0;
}
