#pragma once

// A CANopen node in virtual time, written from docs/icd-ardito.md: object dictionary with the rules
// of PDO configuration, NMT, heartbeats both ways, SYNC, and a drive that executes orders at once.
// Answers come one millisecond after the request.

#include <cstdint>
#include <map>
#include <set>
#include <vector>

#include "drivers/can/frame.h"

namespace lss::testing_support {

class CanNode {
 public:
  enum class Kind { wheel, steering, io, imu };
  enum class Nmt : std::uint8_t {
    booting = 0,
    stopped = 4,
    operational = 5,
    pre_operational = 0x7F
  };
  enum class Drive { disabled, ready, switched_on, enabled, quick_stop, fault };
  struct Object {
    int bytes;
    std::uint32_t value;
  };

  CanNode(Kind kind, std::uint8_t id);

  void reboot(TimeNs now, TimeNs takes = 100 * kMillisecond);  // power-on, or NMT reset
  void receive(const CanFrame& frame, TimeNs now);
  void run(TimeNs now);  // periodic messages
  TimeNs next_wake() const;
  std::vector<CanFrame> take();  // its messages

  void send_emcy(std::uint16_t code, std::uint8_t error_register, TimeNs now);
  void fault(std::uint16_t code, TimeNs now);
  std::uint32_t& object(std::uint16_t index, std::uint8_t sub = 0) {
    return objects.at(std::uint32_t{index} << 8 | sub).value;
  }
  std::int32_t target() const { return target_; }  // that it follows

  Kind kind;
  std::uint8_t id;
  Nmt nmt = Nmt::booting;
  Drive drive = Drive::disabled;
  std::map<std::uint32_t, Object> objects;  // index << 8 | sub
  std::map<std::uint32_t, Object> added{};  // of another make: there after each reset
  int set_points = 0;                       // steering: taken
  int quick_stops = 0;                      // begun
  bool master_lost = false;                 // its heartbeat was missing

  // Its faults.
  bool powered = true;
  bool mute = false;                // sends nothing
  bool deaf = false;                // receives nothing
  int ignored_requests = 0;         // SDO, the next ones
  std::set<std::uint32_t> refused;  // objects that it aborts with 0x06090030
  int shorter_pdos = 0;             // TPDOs with one byte too few, the next ones
  bool ignores_controlword = false;

 private:
  void reset_objects();
  void reset_communication(TimeNs now);
  void set_nmt(Nmt to);
  void heartbeat(TimeNs now);
  void sdo(const CanFrame& frame, TimeNs now);
  std::uint32_t write(std::uint32_t key, int bytes, std::uint32_t value);
  void rpdo(int number, const CanFrame& frame, TimeNs now);
  void tpdos(TimeNs now, int of_type);
  void send_tpdo(int number, TimeNs now);
  void controlword();
  void stop();
  void update();  // objects from what the drive does
  void send(std::uint32_t cob_id, const std::vector<std::uint8_t>& data, TimeNs now);

  std::vector<CanFrame> out_;
  TimeNs boot_ns_ = 0, heartbeat_ns_ = 0, health_ns_ = 0, master_ns_ = 0;
  bool watches_ = false;
  std::uint16_t last_word_ = 0;
  bool acknowledged_ = false;
  std::int32_t target_ = 0;
};

}  // namespace lss::testing_support
