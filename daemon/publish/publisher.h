#pragma once

// The publish thread and the DDS face behind it: passes the output of the frame thread
// (acknowledgements, events, timing, telemetry, state) to DDS and to the log, watches shared memory
// and the grants of the kernel. Ordinary thread. The frame thread's side is wait-free: full rings
// drop and count, so that a slow subscriber, a full disk or a stuck logger never delays a frame.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/config/config.h"
#include "daemon/cycle/supervisor.h"
#include "daemon/cycle/text.h"
#include "daemon/parameters/saver.h"
#include "daemon/publish/face.h"
#include "daemon/publish/status_pace.h"
#include "daemon/record/certificate.h"
#include "daemon/runtime/clock_step.h"
#include "daemon/runtime/expiry_watch.h"
#include "daemon/runtime/latest.h"
#include "daemon/runtime/ring.h"
#include "daemon/runtime/thread.h"
#include "daemon/runtime/wake_up.h"
#include "drivers/lockstep/lockstep.h"

namespace lss {

class Publisher {
 public:
  using Threads = std::vector<std::unique_ptr<rt::Thread>>;

  // Callbacks into other threads; each is called on the publish thread only.
  struct Sources {
    std::function<const void*()> newest_telemetry;    // nullptr: nothing new
    std::function<std::uint64_t()> telemetry_missed;  // samples that a newer one replaced
    std::function<std::uint64_t()> commands_refused;
    std::function<bool(EventId&)> log_event;  // of the log thread; false: none
    std::function<std::uint64_t()> log_dropped;
    std::function<bool()> recording;
    std::function<bool(SaveResult&)> parameters_saved;  // false: none
  };
  // Additional events at its start.
  struct Told {
    EventId id;
    std::string text;  // empty: text of the list
    std::array<double, 2> argument{};
  };

  // `dictionary`: contents of lss/dictionary.
  Publisher(const config::Config& config, const Logic& logic, const Vocabulary& vocabulary,
            std::string dictionary);
  ~Publisher() { stop(); }
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  // Start-up, main thread.
  tl::expected<void, Refusal> open(RequestSink sink);
  void complain(const std::string& refused);  // refusals of the kernel: log and status
  void memory_locked(bool locked) { memory_locked_ = locked; }
  void start(const Threads& threads, Sources sources);
  // Before start(): the initial parameters.
  void parameters(const ParameterReport& report, std::vector<Told> told);
  // Before start(): frames are compared with it.
  void certificate(const record::Certificate& certificate) { certified_.emplace(certificate); }
  void stop();

  // Listener thread: an answer that needs no frame. And publish thread.
  void answer(const Ack& ack, std::string_view name);

  // Frame thread.
  void put(const Supervisor::Outbox& outbox) noexcept;
  void put(const SupervisorState& state) noexcept { state_.put(state); }
  void put(const TimingPoints& timing) noexcept { timings_.push(timing); }
  void put(const TunableValues& values) noexcept { tunables_.put(values); }
  void put(const Ack& ack) noexcept { acks_.push(ack); }
  void airborne(bool airborne) noexcept { airborne_.store(airborne, std::memory_order_relaxed); }
  // Any thread.
  void wake() noexcept { wake_up_.wake(); }

  // Main thread.
  const std::string& dictionary() const { return dictionary_; }
  std::string summary() const;
  const char* restart_reason() const { return restart_reason_; }
  std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }

 private:
  // For some frames. A quarter is reserved for the holder (Outbox::holder).
  static constexpr std::size_t kAcks = 4 * Supervisor::kMaxAcks;

  void run();
  void drain();
  void saved(const SaveResult& result);
  void publish_status(TimeNs now);
  void watch(TimeNs now);
  void watch_clock();
  void watch_expiry(TimeNs now);
  void publish(const EventRecord& event);  // to DDS and to the log
  void publish(const EventRecord& event, std::string text);
  void tell(const EventRecord& event);  // of this thread: counted, then published
  void tell(EventId id, TimeNs now, double argument = 0);
  StatusReport report(TimeNs now) const;

  const config::Config& config_;
  std::span<const CommandInfo> commands_;       // of the vehicle
  std::span<const TunableInfo> tunable_infos_;  // of the vehicle
  Vocabulary vocabulary_;
  std::string dictionary_;
  std::unique_ptr<Face> face_;
  std::atomic<Face*> answering_{nullptr};  // face_, while the listener may use it
  const Threads* threads_ = nullptr;
  Sources sources_;

  Ring<Ack, kAcks> acks_;
  Ring<EventRecord, 512> events_;
  Ring<TimingPoints, 256> timings_;
  Latest<SupervisorState> state_;
  Latest<TunableValues> tunables_;
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<std::uint64_t> dropped_{0};  // in the outbox of a frame
  std::atomic<bool> airborne_{false};
  WakeUp wake_up_;

  std::uint64_t foreign_ = 0;  // Face::foreign() that was logged
  TimeNs next_foreign_ns_ = 0;
  ParameterReport parameters_;
  std::vector<Told> told_;
  EventSeries series_;  // of events that are not the cycle's

  TimingPoints timing_;  // the newest
  TimingCollector<TimingPoints> statistics_;
  std::optional<record::CertificateWatch> certified_;
  TimeNs statistics_from_ns_ = 0;  // only later frames count
  ClockStep clock_step_;
  ExpiryWatch expiry_;  // of the enclave
  StatusPace pace_;
  std::atomic<bool> answered_{false};  // since the last status was due
  TimeNs contact_ns_ = 0;              // as it was then
  TimeNs next_status_ns_ = 0, heartbeat_ns_ = 0, next_watch_ns_ = 0;
  bool memory_locked_ = false, granted_ = true;

  mutable std::mutex summary_mutex_;  // main and publish thread only
  std::string summary_;
  std::atomic<const char*> restart_reason_{nullptr};
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace lss
