#pragma once

// One CANopen node as its firmware sees the bus: NMT states, boot-up and heartbeats both ways, SDO
// server, PDOs by SYNC, change and timer, EMCY. Derived classes add sensors and actuators. Written
// only from CiA 301 and the interface documents of the vehicles, not from the daemon's driver. Time
// is the node's own: it passes in step(), 1 ms a call. One thread at a time.

#include <cstdint>
#include <deque>
#include <optional>
#include <random>
#include <span>
#include <vector>

#include "drivers/can/frame.h"
#include "tools/lss-sim/canopen/objects.h"
#include "tools/lss-sim/canopen/signal.h"

namespace lss::sim::nodes {

enum class Nmt : std::uint8_t {
  initialising = 0x00,  // receives and sends nothing; ends in boot-up
  stopped = 0x04,
  operational = 0x05,
  pre_operational = 0x7F,
};

// Injected faults of a node on the bus.
struct NodeFaults {
  bool silent = false;          // its transceiver is dead, both ways
  int longer_pdos = 0;          // bytes by which its PDOs are too long, negative: too short
  std::uint32_t sdo_abort = 0;  // abort code for every SDO
  std::uint16_t no_object = 0;  // this one is not there; 0: all are
  double babble_1_s = 0;        // unrequested frames
  double emcy_storm_1_s = 0;
};

// The identity of a node: its number, 0x1000 and product code and revision of 0x1018.
struct Identity {
  std::uint8_t id = 0;
  std::uint32_t device_type = 0;
  std::uint32_t product = 0;
  std::uint32_t revision = 0x0001'0000;
};

class Node {
 public:
  Node(const Identity& identity, std::size_t rpdos, std::size_t tpdos,
       std::span<const Object> objects, unsigned seed);
  virtual ~Node() = default;
  Node(const Node&) = delete;
  Node& operator=(const Node&) = delete;

  void receive(const CanFrame& frame);
  void step();
  std::optional<CanFrame> send();
  bool wants_to_send() const { return !outbox_.empty(); }

  void power_on();  // and what a reboot is
  void inject_emcy(std::uint16_t code, bool attach);
  void set_device_type(std::uint32_t claimed) { claimed_type_ = claimed; }  // 0: its own
  NodeFaults faults;
  // Measured signals, from 1; null when there is no such signal.
  virtual Signal* signal(int number) = 0;

  std::uint8_t id() const { return id_; }
  Nmt state() const { return nmt_; }
  const Objects& objects() const { return objects_; }

 protected:
  // Copies the measurements into the objects: at SYNC, for timers and before each SDO read.
  virtual void measure() = 0;
  virtual void count_sync() {}
  // An object was written, by SDO or PDO.
  virtual void written(std::uint16_t index, std::uint8_t sub) = 0;
  virtual void left_operational(bool communication_error) = 0;
  virtual void reset() = 0;  // of the application, power-on or reset node
  virtual void tick() = 0;   // one millisecond

  void raise(std::uint16_t code);
  void settle(std::uint16_t code);
  void changed(std::size_t tpdo) { tpdos_[tpdo].due = true; }  // type 254 sends it
  bool ready() const { return nmt_ != Nmt::initialising; }

  Objects objects_;
  std::mt19937 random_;

 private:
  struct Pdo {
    std::uint16_t parameters, mapping;  // indices of its objects
    int syncs = 0;                      // since it was sent
    int since_ms = 0;
    bool due = false;
  };
  struct Emcy {
    std::uint16_t code;
    std::uint8_t bits;
  };
  static constexpr int kBoot_ms =
      150;  // plus 10 for each node before it, so that they do not start at once

  void enter(Nmt state, bool communication_error);
  void command(std::uint8_t command);
  void begin_boot();
  void sync();
  void heard_heartbeat();
  void watch_master();
  void take_rpdo(Pdo& pdo, const CanFrame& frame);
  void send_tpdo(Pdo& pdo);
  void serve_timers();
  void serve_sdo(const CanFrame& request);
  Abort write(std::uint16_t index, std::uint8_t sub, std::size_t bytes, std::uint32_t value);
  Abort check_pdo(const Pdo& pdo, bool transmit, std::uint16_t index, std::uint8_t sub,
                  std::uint32_t value) const;
  std::size_t mapped_bits(const Pdo& pdo) const;
  bool valid(const Pdo& pdo) const;
  std::uint32_t type_of(const Pdo& pdo) const { return objects_.get(pdo.parameters, 2); }
  void put(std::uint32_t id, std::span<const std::uint8_t> data);
  void serve_emcy();
  void misbehave();

  std::uint8_t id_;
  std::uint32_t device_type_, claimed_type_ = 0;
  std::vector<Pdo> rpdos_, tpdos_;
  Nmt nmt_ = Nmt::initialising;
  std::deque<CanFrame> outbox_;
  int boot_left_ms_ = 0, heartbeat_ms_ = 0, unheard_ms_ = 0, emcy_ms_ = 0;
  bool watching_ = false;
  std::vector<std::uint16_t> active_;  // errors
  std::deque<Emcy> to_tell_;
  double babble_ = 0, storm_ = 0;  // frames to send
};

}  // namespace lss::sim::nodes
