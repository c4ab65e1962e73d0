#pragma once

// A stand-in for lssd on DDS, so that lss-cli is tested as a whole program without one:
// acknowledges commands, changes state and mode as Lunar Zebro would, in no time, and
// misbehaves on request. Thread-safe; its own thread runs from construction to destruction.

#include <atomic>
#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "idl/codes.h"
#include "idl/other_daemons.h"
#include "idl/timing_statistics.h"
#include "idl/topics.h"
#include "idl/zebro/commands.h"
#include "lss.h"
#include "tools/lss-cli/session/waker.h"

namespace lss::cli::test {

inline constexpr std::uint16_t kStart = 1, kStop = 2, kEstop = 3, kSolve = 4, kReset = 5, kData = 6,
                               kSetParameter = 9, kSaveParameters = 10, kStand = 101,
                               kLayDown = 102, kStow = 103, kWalk = 104, kPanel = 105, kLeg = 106,
                               kLand = 313;

// The failure of a command.
struct Trouble {
  enum class Kind { reject, fail, no_answer, never_ends };
  Kind kind;
  Reason reason = Reason::none;
  int times = -1;  // so many, and then it is done; -1: always
};

// Which daemon it is, and how it comes up.
struct Birth {
  std::string vehicle_id = "zebro-1";
  std::string vehicle = "zebro";
  std::int32_t pid = 1;
  std::string dictionary{};  // empty: that of this build
  bool earlier = false;      // its type of commands is that of an earlier version
  enum class Late {
    status,  // its topics are there and it says nothing yet
    topics,  // DDS knows of a daemon, and nothing more
  };
  Late late = Late::status;
  std::chrono::milliseconds late_by{0};  // from then on it is as any other
  std::string mark{};                    // user data of its participant; empty: as of any other
};

class FakeDaemon {
 public:
  explicit FakeDaemon(int domain, const std::string& vehicle_id = "zebro-1")
      : FakeDaemon(domain, Birth{.vehicle_id = vehicle_id}) {}
  FakeDaemon(int domain, const Birth& birth);
  ~FakeDaemon();
  FakeDaemon(const FakeDaemon&) = delete;
  FakeDaemon& operator=(const FakeDaemon&) = delete;

  void trouble(std::uint16_t kind, Trouble trouble);
  void set_state(lss_State state, zebro::Mode mode = zebro::Mode::none);
  void take_off(lss_StopInFlight stop = lss_STOP_LANDS);
  void set_authority(const std::string& source);
  void latch(FaultId fault, std::uint16_t subject);
  void silence_module(std::uint8_t id);
  void telemetry_on_request();
  void fall_silent();  // as if killed: no status, no answer
  void timing(const TimingStatistics& statistics);
  // count > 0: a report of the one series of this id.
  void event(EventId id, const std::string& text, std::uint32_t count = 0);
  void saved_parameters(lss_SavedParameters saved);
  // The command that is being executed fails.
  void emergency();

  // Of commands that were not dry runs, in order.
  std::vector<std::uint16_t> kinds() const;
  lss_Command last(std::uint16_t kind) const;
  unsigned others() const { return others_; }  // daemons that it knows of
  std::uint64_t heartbeats() const { return heartbeats_; }
  std::string heart() const;  // source of the newest heartbeat
  lss_State state() const;
  zebro::Mode mode() const;

 private:
  void open();
  void run();
  bool take_commands();  // true: somebody spoke
  void obey(const lss_Command& command, std::uint64_t writer);
  bool is_troubled(std::uint16_t kind, Trouble::Kind what);
  void perform(const lss_Command& command);
  void obey_parameters(const lss_Command& command);
  void publish_parameters();
  void acknowledge(const lss_Command& command, lss_Phase phase, Reason reason = Reason::none);
  void finish(lss_Phase phase, Reason reason = Reason::none);
  lss_Instance instance() const;
  void publish_status();
  void publish_heartbeat();
  void publish_telemetry();

  mutable std::mutex mutex_;
  Birth birth_;  // outlives the readers, which look at the name
  dds::Participant participant_;
  dds::Entity commands_, heartbeat_reader_, heartbeat_writer_, acks_, status_, events_, timing_,
      parameter_writer_, dictionary_, telemetry_;
  Clock::time_point speaks_;
  std::string authority_, heart_;
  std::map<std::uint16_t, Trouble> troubles_;
  std::map<std::uint64_t, std::uint64_t> sequences_;  // newest of each writer
  lss_State state_ = lss_STATE_IDLE;
  zebro::Mode mode_ = zebro::Mode::none;
  std::vector<lss_Command> heard_;
  lss_Command active_{};  // kind 0: none
  std::vector<lss_Fault> faults_;
  lss_Parameters parameters_{};
  std::uint8_t silent_module_ = 0;
  bool periodic_ = true, silent_ = false, changed_ = true, airborne_ = false;
  lss_StopInFlight stop_in_flight_ = lss_STOP_LANDS;
  std::uint64_t event_index_ = 0;
  double distance_m_ = 0;
  std::atomic<std::uint64_t> heartbeats_ = 0;
  std::atomic<unsigned> others_ = 0;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

}  // namespace lss::cli::test
