#pragma once

// A stand-in for lssd on DDS, so that lss-cli is tested as a whole program without one:
// acknowledges commands, changes state and mode as Lunar Zebro would, in no time, and can be told
// to misbehave. Thread-safe; its own thread runs from construction to destruction.

#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "idl/codes.h"
#include "idl/timing_statistics.h"
#include "idl/topics.h"
#include "idl/zebro_commands.h"
#include "lss.h"

namespace lss::cli::test {

inline constexpr std::uint16_t kStart = 1, kStop = 2, kEstop = 3, kSolve = 4, kReset = 5, kData = 6,
                               kSetParameter = 9, kSaveParameters = 10, kStand = 101,
                               kLayDown = 102, kStow = 103, kWalk = 104, kPanel = 105, kLeg = 106;

// What happens to a command instead of being done.
struct Trouble {
  enum class Kind { reject, fail, no_answer, never_ends };
  Kind kind;
  Reason reason = Reason::none;
};

class FakeDaemon {
 public:
  explicit FakeDaemon(int domain, const std::string& vehicle_id = "zebro-1");
  ~FakeDaemon();
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;

  void trouble(std::uint16_t kind, Trouble trouble);
  void set_state(lss_State state, zebro::Mode mode = zebro::Mode::none);
  void set_authority(const std::string& source);
  void latch(FaultId fault, std::uint16_t subject);
  void silence_module(std::uint8_t id);
  void telemetry_on_request();
  void fall_silent();  // as if killed: no status, no answer
  void timing(const TimingStatistics& statistics);
  void event(EventId id, const std::string& text);
  void saved_parameters(lss_SavedParameters saved);
  // The command that is being executed fails.
  void emergency();

  // Of commands that were not dry runs, in order.
  std::vector<std::uint16_t> kinds() const;
  lss_Command last(std::uint16_t kind) const;
  std::uint64_t heartbeats() const { return heartbeats_; }
  lss_State state() const;
  zebro::Mode mode() const;

 private:
  void run();
  void take_commands();
  void obey(const lss_Command& command);
  void perform(const lss_Command& command);
  void obey_parameters(const lss_Command& command);
  void publish_parameters();
  void acknowledge(const lss_Command& command, lss_Phase phase, Reason reason = Reason::none);
  void finish(lss_Phase phase, Reason reason = Reason::none);
  void publish_status();
  void publish_telemetry();

  mutable std::mutex mutex_;
  dds::Participant participant_;
  dds::Entity commands_, heartbeat_reader_, acks_, status_, events_, timing_, parameter_writer_,
      telemetry_;
  std::string vehicle_id_;
  std::string authority_;
  std::map<std::uint16_t, Trouble> troubles_;
  std::map<std::string, std::uint64_t> sequences_;  // newest of each source
  lss_State state_ = lss_STATE_IDLE;
  zebro::Mode mode_ = zebro::Mode::none;
  std::vector<lss_Command> heard_;
  lss_Command active_{};  // kind 0: none
  std::vector<lss_Fault> faults_;
  lss_Parameters parameters_{};
  std::uint8_t silent_module_ = 0;
  bool periodic_ = true, silent_ = false, changed_ = true;
  std::uint64_t event_index_ = 0;
  double distance_m_ = 0;
  std::atomic<std::uint64_t> heartbeats_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace lss::cli::test
