#pragma once

// The DDS face of the daemon in two planes: control (commands, acknowledgements, heartbeats,
// status, events; never on shared memory) and telemetry (shared memory through RouDi when it runs).
// No DDS type leaves daemon/publish. Nothing here is ever called from a real-time thread. The facts
// about Cyclone DDS 0.10.2 and iceoryx 2.0.3 behind it were measured in 2026-11: docs/dds.md.

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "daemon/cycle/messages.h"
#include "idl/refusal.h"

namespace lss {

struct FaceParameters {
  int domain = 0;
  std::string vehicle;     // "zebro"
  std::string vehicle_id;  // at most 15 characters
  std::string version;
  std::span<const char* const> modules{};  // their names; subject n is modules[n - 1]
  std::span<const TunableInfo> tunables{};
  std::span<const CommandInfo> commands = {};  // the vehicle's own
  std::string dictionary{};                    // contents of lss/dictionary; empty: none
  std::vector<std::string> interfaces = {"lo"};
  bool shared_memory = true;        // wanted; used when RouDi runs
  std::filesystem::path enclave{};  // of DDS Security; empty: none
  std::chrono::days clock_slack{};
};

// Called by the listener, on a thread of Cyclone, one call at a time. May call acknowledge().
// `writer`: the DDS writer of the request.
using RequestSink = std::function<void(const Request&, std::uint64_t writer)>;

class Face {
 public:
  // Creates participant, topics, writers and, last, the readers that call the sink.
  static tl::expected<std::unique_ptr<Face>, Refusal> create(const FaceParameters& parameters,
                                                             RequestSink sink);
  ~Face();  // no call of the sink is running when it returns

  // Thread-safe; the text is made here from the verdict. `name`: of a parameter, in the command.
  void acknowledge(const Ack& ack, std::string_view name = {});
  void event(const EventRecord& record, std::string_view text);  // publish thread
  void status(const StatusReport& report);                       // publish thread
  void timing(const TimingPoints& points);                       // publish thread
  void timing(const TimingStatistics& statistics);               // publish thread
  void parameters(const ParameterReport& report);                // publish thread
  void heartbeat(State state);                                   // publish thread
  // Publish thread. Points to the struct of the vehicle, e.g. lss::zebro::Telemetry.
  void telemetry(const void* vehicle_telemetry);

  // Publish thread. True: since the last call a client appeared whose lss/command is of another
  // type than ours, so that DDS does not let it reach us.
  bool other_interface();
  // Thread-safe. Samples so far whose sender may not send them, or gave a name that its
  // certificate does not have: they are dropped. Always 0 without DDS Security.
  std::uint64_t foreign() const;
  // Of the enclave; the same always.
  std::span<const std::string> warnings() const;
  std::int64_t expires_utc_s() const;  // INT64_MAX: without DDS Security

  // Publish thread, about ten times a second: other daemons, for clients (idl/other_daemons.h).
  void look_for_others();

  // Configured interfaces that were not up, and are left out. Whether one of them is up now, so
  // that a restart of the daemon would use it.
  const std::vector<std::string>& missing_interfaces() const;
  bool interfaces_could_return() const;

  // Checks whether RouDi is still the one we started with; when it ended or was replaced, moves the
  // telemetry writers to the network. Publish thread, about ten times a second, also when there is
  // nothing to publish: a second without a call counts as a standstill of the process, after which
  // RouDi may have dropped us. True when the result changed.
  bool watch_shared_memory();
  SharedMemory shared_memory() const;  // thread-safe
  // RouDi runs (again) and a restart of the daemon would use shared memory; it answered.
  // Publish thread; does not wait.
  bool shared_memory_could_return();

 private:
  struct Impl;
  explicit Face(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace lss
