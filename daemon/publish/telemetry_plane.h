#pragma once

// The telemetry plane of the face: two writers, the vehicle's telemetry and the frame timing, on
// shared memory while the RouDi that they were created with runs, else on the network. Publish
// thread only, except state().

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "daemon/cycle/messages.h"
#include "daemon/publish/telemetry_topic.h"
#include "idl/topics.h"

namespace lss::dds {

class TelemetryPlane {
 public:
  // `participant` outlives this. `wanted`: the configuration asks for shared memory.
  TelemetryPlane(Participant& participant, const TelemetryTopic& topic, std::string vehicle_id,
                 bool wanted);
  ~TelemetryPlane();
  TelemetryPlane(const TelemetryPlane&) = delete;
  TelemetryPlane& operator=(const TelemetryPlane&) = delete;

  // The error is a sentence.
  Result<void> open();

  // A struct of the topic's type; its key is set here.
  void telemetry(const void* vehicle_telemetry);
  void timing(const TimingPoints& points);
  bool watch();  // true when the state changed

  SharedMemory state() const { return state_.load(std::memory_order_relaxed); }
  bool could_return();
  const char* text() const { return text_; }  // what the state means and what to do
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Channel {
    Topic topic;
    Entity writer;
  };

  // Whether the whole process stood still so long that RouDi may have dropped it. A thread of its
  // own notices it: the publisher also waits when there is nothing to send.
  class Standstill {
   public:
    void start();
    bool seen() const;  // and stays so

   private:
    std::atomic<TimeNs> last_ns_{0};
    std::atomic<bool> seen_{false};
    std::mutex mutex_;
    std::condition_variable_any waiting_;
    std::jthread thread_;
  };

  template <class Fill>
  void write(Channel& channel, void* own_sample, Fill fill);
  Result<void> open_channels(Transport transport);
  void leave_after_standstill();
  void fall_back();
  void abandon();

  Participant& participant_;
  const TelemetryTopic& telemetry_topic_;
  const std::string vehicle_id_;
  const bool wanted_;
  Channel telemetry_;
  Channel timing_;
  std::vector<std::uint64_t>
      own_sample_;  // written when no sample is loaned; aligned for any field
  std::atomic<SharedMemory> state_{SharedMemory::off};
  const char* text_ = "";
  Standstill standstill_;
  std::uint64_t dropped_ = 0;
  bool changed_ = false;
  bool abandoned_ = false;
  std::optional<RoudiCall> call_;  // to the one that could be joined by a restart
  std::optional<RoudiIdentity> called_;
};

}  // namespace lss::dds
