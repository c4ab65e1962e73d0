#pragma once

// The telemetry plane of the face: two writers, the vehicle's telemetry and the frame timing, on
// shared memory while the RouDi that they were created with runs, else on the network. Publish
// thread only, except state() and could_return().

#include <atomic>
#include <cstdint>
#include <string>
#include <string_view>
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
  void telemetry(const void* vehicle_telemetry, TimeNs now_ns);
  void timing(const TimingPoints& points, TimeNs now_ns);
  bool watch(TimeNs now_ns);  // true when the state changed

  SharedMemory state() const { return state_.load(std::memory_order_relaxed); }
  bool could_return() const;
  const char* text() const { return text_; }  // what the state means and what to do
  std::uint64_t dropped() const { return dropped_; }

 private:
  struct Channel {
    Topic topic;
    Entity writer;
  };

  template <class Fill>
  void write(Channel& channel, void* own_sample, TimeNs now_ns, Fill fill);
  Result<void> open_channels(Transport transport);
  void note_running(TimeNs now_ns);
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
  TimeNs last_running_ns_ = 0;  // 0: not yet, while the daemon starts
  std::uint64_t dropped_ = 0;
  bool changed_ = false;
  bool abandoned_ = false;
};

}  // namespace lss::dds
