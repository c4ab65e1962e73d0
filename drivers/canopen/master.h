#pragma once

// CANopen master of up to 16 nodes: boots and configures them, watches their heartbeats, sends its
// own and SYNC, passes PDO data in and out. Knows only frames and time, no file descriptor and no
// thread: the bus thread passes both in. Nothing here allocates, locks or logs.
//
// Schedule of messages: docs/icd-ardito.md sections 6, 7 and 11. The master decides nothing about
// motion: RPDO data come from the caller, and so does the permission to boot nodes again.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "drivers/canopen/canopen.h"
#include "drivers/canopen/node.h"
#include "drivers/canopen/sdo.h"

namespace lss::canopen {

inline constexpr std::size_t kMaxNodes = 16;

struct MasterParameters {
  HeartbeatParameters heartbeat{};
  std::array<NodeParameters, kMaxNodes> nodes{};  // node 0: end
  TimeNs sync_period_ns = 100 * kMillisecond;     // 0: no SYNC
  TimeNs boot_timeout_ns = 2 * kSecond;           // from reset to boot-up
  TimeNs sdo_timeout_ns = 200 * kMillisecond;     // of one attempt
  int sdo_attempts = 3;                           // in all
  TimeNs start_timeout_ns = 500 * kMillisecond;   // from start to its heartbeat in operational
  TimeNs retry_ns = kSecond;                      // after a boot that failed, to the next reset
  TimeNs wrong_device_retry_ns = 5 * kSecond;
  TimeNs babble_window_ns = 100 * kMillisecond;
  int babble_frames = 100;           // more in one window: the node babbles
  TimeNs babble_quiet_ns = kSecond;  // and until it has been quiet for this long
};

enum class NodeState : std::uint8_t {
  off,           // not reset yet
  booting,       // reset, waits for its boot-up message
  missing,       // none came; it is reset again now and then
  identifying,   // reads its device type
  wrong_device,  // wrong type: found_type; read again now and then
  configuring,   // objects are written
  failed,        // one could not be: failed_entry, abort_code; booted again soon
  starting,      // waits for its heartbeat in operational
  operational,   // the only state in which its PDOs are used
  lost,          // was operational, no heartbeat any more
  rebooted,      // was operational, sent an unexpected boot-up
  fallen_back,   // was operational, reports pre-operational or stopped
  babbling,      // sends too much: nothing of it is used
};

struct NodeStatus {
  NodeState state = NodeState::off;
  NmtState nmt = NmtState::unknown;  // its last heartbeat
  TimeNs since_ns = 0;               // when `state` began
  TimeNs heartbeat_ns = 0;           // when the last one came; 0: never
  std::uint32_t found_type = 0;      // object 0x1000, once it was read
  Entry failed_entry{};              // last entry that could not be written or read
  std::uint32_t abort_code = 0;      // and why
  std::uint16_t emcy_code = 0;       // of the last EMCY
  std::uint8_t emcy_register = 0;
  TimeNs emcy_ns = 0;
  bool emcy_storm = false;  // more than ten within a second
  std::uint64_t emcys = 0;
  std::uint64_t frames = 0;         // of any type
  std::uint64_t boots = 0;          // boot-up messages
  std::uint64_t reboots = 0;        // those of an operational node
  std::uint64_t losses = 0;         // times that its heartbeat was missing
  std::uint64_t fall_backs = 0;     // times that it left operational by itself
  std::uint64_t wrong_lengths = 0;  // PDOs
  std::uint64_t babbles = 0;        // times
  std::uint64_t ignored = 0;        // frames not used: babbling, or PDOs out of operational
};

// Data of a TPDO, raw.
struct PdoSample {
  TimeNs time_ns = 0;
  std::uint8_t node = 0;    // index in the parameters
  std::uint8_t number = 0;  // 1 to 4
  std::uint8_t size = 0;
  std::array<std::uint8_t, 8> data{};
};

struct MasterCounters {
  std::uint64_t frames_received = 0;
  std::uint64_t frames_sent = 0;
  std::uint64_t syncs = 0;
  std::uint64_t syncs_skipped = 0;   // the thread was too late for them
  std::uint64_t unknown_nodes = 0;   // frames of nodes that are not configured
  std::uint64_t unknown_frames = 0;  // of no service used here; extended, remote, wrong length
  std::uint64_t other_masters = 0;   // frames that only we may send
  std::uint64_t overflows = 0;       // samples that were not taken
};

class Master {
 public:
  explicit Master(const MasterParameters& parameters) noexcept;

  // The bus was opened (again): all nodes are booted from the beginning, not before `reset_at`.
  void restart(TimeNs now, TimeNs reset_at) noexcept;
  // In the place of a master whose memory was lost and that last reported this: its counts go on,
  // and no node is booted that ran.
  void take_over(std::size_t node, const NodeStatus& said, TimeNs now) noexcept;
  void take_over(const MasterCounters& said) noexcept { counters_ = said; }

  void receive(const CanFrame& frame) noexcept;  // by frame.time_ns
  // True: `frame` is to be sent now. Call until it returns false.
  bool transmit(TimeNs now, CanFrame& frame) noexcept;
  TimeNs next_wake() const noexcept;

  // SYNC goes out at this time and every period after it. Not without a period.
  void sync_at(TimeNs next) noexcept;
  // Resets a node, with power stage and outputs, and boots it again, in any state.
  void reset(std::size_t node, TimeNs now) noexcept;
  // Whether nodes that were lost, rebooted, fell back or failed may be booted (again) now.
  void allow_boot(bool allowed) noexcept { allow(boot_allowed_, allowed); }
  // Whether nodes that only fell back, powered all the time, may be booted when the others may not.
  void allow_resume(bool allowed) noexcept { allow(resume_allowed_, allowed); }
  // Sent with the next transmit(), before everything else; a newer one replaces it.
  void send_rpdo(std::size_t node, int number, std::span<const std::uint8_t> data) noexcept;

  // Data received since the last call; at most kMaxSamples are kept, the oldest dropped.
  static constexpr std::size_t kMaxSamples = 64;
  bool take(PdoSample& sample) noexcept;

  std::size_t nodes() const noexcept { return count_; }
  const NodeStatus& status(std::size_t node) const noexcept { return nodes_[node].status; }
  const SdoCounters& sdo(std::size_t node) const noexcept { return nodes_[node].sdo.counters(); }
  const MasterCounters& counters() const noexcept { return counters_; }
  // False: two nodes have one number, or a configuration has too many entries. Then nothing is sent
  // to any node.
  bool parameters_fit() const noexcept { return fit_; }

 private:
  static constexpr TimeNs kAlways = INT64_MIN;

  struct Outgoing {
    std::uint8_t size = 0;
    std::array<std::uint8_t, 8> data{};
  };

  struct Node {
    NodeParameters parameters{};
    Configuration configuration{};
    SdoClient sdo{};
    NodeStatus status{};
    std::size_t step = 0;         // of the configuration
    TimeNs deadline_ns = kNever;  // of the state
    bool nmt_due = false;
    Nmt nmt = Nmt::reset_node;
    std::array<Outgoing, kMaxPdos> rpdo{};
    TimeNs window_ns = 0;  // babbling: begin of the window, frames in it
    int window_frames = 0;
    bool was_operational = false;  // before it babbled
    TimeNs storm_ns = 0;           // EMCYs: begin of the second, and how many in it
    int storm_emcys = 0;
  };

  Node* node_of(std::uint32_t id) noexcept;
  bool waits(const Node& node) const noexcept;
  void enter(Node& node, NodeState state, TimeNs now, TimeNs deadline = kNever) noexcept;
  void command(Node& node, Nmt nmt) noexcept;
  void boot(Node& node, Nmt how, TimeNs now) noexcept;
  void identify(Node& node, TimeNs now) noexcept;
  void fail(Node& node, TimeNs now) noexcept;
  static bool needs_care(const Node& node, TimeNs now) noexcept;
  void advance(Node& node, TimeNs now) noexcept;
  void sdo_over(Node& node, TimeNs now) noexcept;
  void deadline_over(Node& node, TimeNs now) noexcept;

  bool babbles(Node& node, TimeNs time) noexcept;
  void heartbeat(Node& node, const CanFrame& frame) noexcept;
  void emergency(Node& node, const CanFrame& frame) noexcept;
  void pdo(Node& node, int number, const CanFrame& frame) noexcept;
  void booted(Node& node, TimeNs time) noexcept;

  void allow(bool& what, bool allowed) noexcept {
    if (what != allowed) quiet_ns_ = kAlways;
    what = allowed;
  }
  bool care(TimeNs now, CanFrame& frame) noexcept;
  bool transmit_sync(TimeNs now, CanFrame& frame) noexcept;
  bool transmit_heartbeat(TimeNs now, CanFrame& frame) noexcept;
  bool transmit_rpdo(CanFrame& frame) noexcept;

  MasterParameters parameters_;
  std::array<Node, kMaxNodes> nodes_{};
  std::size_t count_ = 0;
  bool fit_ = true;
  std::array<std::uint8_t, kMaxNode + 1> index_{};  // of a node's number; kMaxNodes: not ours
  MasterCounters counters_{};
  bool boot_allowed_ = true, resume_allowed_ = false;
  std::uint64_t rpdos_due_ = 0;  // bit: node * kMaxPdos + number - 1
  static_assert(kMaxNodes * kMaxPdos <= 64);
  // Before this time no node needs care. Nodes are looked at one by one only from then on, or each
  // frame received would cost more with each node.
  TimeNs quiet_ns_ = kAlways, transmitted_ns_ = 0;
  TimeNs sync_ns_ = 0, last_sync_ns_ = 0, heartbeat_ns_ = 0;
  std::array<PdoSample, kMaxSamples> samples_{};  // ring
  std::size_t first_sample_ = 0, sample_count_ = 0;
};

// Frames that a master has use for: a filter for the CAN interface.
std::span<const CanFilter> filters() noexcept;

}  // namespace lss::canopen
