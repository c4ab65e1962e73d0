#pragma once

// Topic names and QoS of the DDS face, in one place for the daemon, the command line and the tests,
// with owners for the handles of Cyclone's C API. Control topics never touch shared memory;
// telemetry does when the participant has it. Start-up code of ordinary threads: everything here
// may allocate and block.

#include <dds/dds.h>

#include <array>
#include <initializer_list>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <utility>
#include <vector>

#include "dictionary.h"
#include "idl/refusal.h"
#include "idl/roudi.h"
#include "idl/security.h"
#include "lss.h"

namespace lss::dds {

// Deletes the DDS entity with its children when destroyed. Deleting a handle that is gone with its
// parent does nothing.
class Entity {
 public:
  Entity() = default;
  explicit Entity(dds_entity_t handle) : handle_(handle) {}
  Entity(Entity&& other) noexcept : handle_(std::exchange(other.handle_, 0)) {}
  Entity& operator=(Entity&& other) noexcept {
    if (this != &other) {
      reset();
      handle_ = std::exchange(other.handle_, 0);
    }
    return *this;
  }
  ~Entity() { reset(); }

  void reset() noexcept {
    if (handle_ > 0) dds_delete(handle_);
    handle_ = 0;
  }
  dds_entity_t release() noexcept { return std::exchange(handle_, 0); }
  dds_entity_t get() const { return handle_; }
  explicit operator bool() const { return handle_ > 0; }

 private:
  dds_entity_t handle_ = 0;
};

// Of a DDS participant.
using Guid = std::array<std::uint8_t, sizeof(dds_guid_t)>;
// The participant of a writer that the reader is matched with; empty: the writer has gone.
std::optional<Guid> owner_of(dds_entity_t reader, dds_instance_handle_t writer);

constexpr int kEventDepth = 256;  // of a reader
constexpr int kEventsKept = 64;   // old events of each id and subject that a late reader gets

// Errors are sentences that say what to do.
template <class T>
using Result = tl::expected<T, std::string>;

struct ParticipantParameters {
  int domain = 0;
  std::vector<std::string> interfaces = {"lo"};  // stays on this machine by default
  bool shared_memory = false;                    // wanted; used when RouDi runs
  // For a short-lived program: it asks every 4 ms, not every 100 ms, whether its samples were
  // received, so that it learns it at once.
  bool short_lived = false;
  // Interfaces that are not up are left out, instead of an error; without any, loopback is used.
  bool without_missing = false;
  // Marks the participant as a daemon's to all that discover it, before its topics are known.
  bool daemon = false;
  // DDS Security with this enclave; empty: none. Keeps everything off shared memory, which is not
  // encrypted.
  std::filesystem::path enclave{};
  std::chrono::days clock_slack{};  // see read_enclave()
};

// Those that do not exist, are down, or have no IPv4 address. Any thread; some system calls.
std::vector<std::string> missing_interfaces(const std::vector<std::string>& names);

// User data of such a participant, and how many others it knows of (other_daemons.h).
inline constexpr std::string_view kDaemonMark = "lssd";

// Domain and participant with our own configuration; CYCLONEDDS_URI is read after it and wins,
// except that shared memory stays off without a running RouDi. The first Participant of a domain in
// a process configures it and must outlive the others of that domain.
class Participant {
 public:
  static tl::expected<Participant, Refusal> create(const ParticipantParameters& parameters);

  dds_entity_t get() const { return participant_.get(); }
  // The RouDi that was joined; empty without shared memory.
  const std::optional<RoudiIdentity>& roudi() const { return roudi_; }
  // Interfaces that were left out.
  const std::vector<std::string>& missing() const { return missing_; }
  // It ran, but did not answer, and was not joined.
  bool roudi_hangs() const { return roudi_hangs_; }
  // Empty without DDS Security.
  const std::optional<Enclave>& enclave() const { return enclave_; }
  // Problems of the enclave that are not errors: sentences that say what to do.
  std::span<const std::string> warnings() const {
    return enclave_ ? std::span<const std::string>(enclave_->warnings)
                    : std::span<const std::string>();
  }

  // With DDS Security, whether the participant that wrote the sample has a certificate of one of
  // these names; without it always. Writers are remembered: also of samples that outlive them.
  // Thread-safe; some microseconds.
  bool is_by(std::initializer_list<std::string_view> names, dds_entity_t reader,
             const dds_sample_info_t& info) const;
  // Whether the vehicle itself wrote it.
  bool is_by_vehicle(std::string_view vehicle_id, dds_entity_t reader,
                     const dds_sample_info_t& info) const;

  // Leaves the entities to the end of the process, when deleting them could hang.
  void abandon() noexcept {
    participant_.release();
    domain_.release();
  }

 private:
  struct Writers {
    std::mutex mutex;
    std::map<dds_instance_handle_t, Guid> owners;
  };

  std::optional<Guid> remembered_owner(dds_entity_t reader, dds_instance_handle_t writer) const;

  Entity domain_;
  Entity participant_;
  std::optional<RoudiIdentity> roudi_;
  bool roudi_hangs_ = false;
  std::vector<std::string> missing_;
  std::optional<Enclave> enclave_;
  std::unique_ptr<Writers> writers_ = std::make_unique<Writers>();
};

enum class Kind {
  command,
  stop,  // commands of those who may only stop; with DDS Security only
  command_ack,
  heartbeat,
  status,
  event,
  timing_statistics,
  parameters,
  dictionary,
  timing,
  telemetry
};

struct Topic {
  Kind kind;
  std::string name;
  const dds_topic_descriptor_t* descriptor;
};

// The topic that all vehicles share; of any type but telemetry.
Topic common_topic(Kind kind);
// lss/telemetry/NAME with the descriptor of the vehicle's own IDL.
Topic telemetry_topic(std::string_view vehicle, const dds_topic_descriptor_t* descriptor);

enum class Transport {
  best,     // shared memory where the topic and the participant have it
  network,  // off shared memory, also in a participant that has it
};

// Of an error of a writer or reader: another role of the enclave may allow it, or nobody knows.
Refusal refusal_of(std::string error);

// The listener may be null; it must outlive only the call.
Result<Entity> create_writer(dds_entity_t participant, const Topic& topic,
                             Transport transport = Transport::best);
Result<Entity> create_reader(dds_entity_t participant, const Topic& topic,
                             Transport transport = Transport::best,
                             const dds_listener_t* listener = nullptr);
// For commands and heartbeats, the topics that the daemon reads: also matches writers made from the
// IDL alone, with default QoS; ignores its own participant. Only samples for `vehicle_id` and
// kEveryVehicle are kept, so that invented names take no memory; the string must outlive the
// reader.
Result<Entity> create_daemon_reader(dds_entity_t participant, const Topic& topic,
                                    const std::string& vehicle_id, const dds_listener_t* listener);

// The daemon's own source in heartbeats.
inline constexpr std::string_view kDaemonSource = "lssd";

// As vehicle_id of an emergency stop: every vehicle of the domain.
inline constexpr std::string_view kEveryVehicle = "*";

// A command older than this is not obeyed.
inline constexpr dds_duration_t kCommandLifespan_ns = DDS_SECS(1);

}  // namespace lss::dds
