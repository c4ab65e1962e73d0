#pragma once

// A hostile program, built from the IDL and libddsc alone: modes that send what a vehicle must
// stand, and a plain client that stops it. On the loopback only.

#include <cstdint>
#include <cstdio>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "dds/dds.h"
#include "lss.h"

namespace attack {

struct Options {
  dds_domainid_t domain = 0;
  std::string vehicle;
  std::string source = "pilot";  // in whose name
  double rate = 1000;            // messages a second
  double seconds = 8;
};

// Numbers of idl/commands.h and of Command.flags in idl/lss.idl.
enum Kind : std::uint16_t { kStart = 1, kStop = 2, kEmergencyStop = 3, kSolve = 4, kData = 6 };
inline constexpr std::uint16_t kDryRun = 1;
inline constexpr const char* kDaemonSource = "lssd";

std::int64_t now_ns();  // CLOCK_MONOTONIC

template <std::size_t N>
void put_text(char (&field)[N], const std::string& text) {
  std::snprintf(field, N, "%s", text.c_str());
}

lss_Command command(const std::string& vehicle, const std::string& source, std::uint64_t seq,
                    std::uint16_t kind, std::uint16_t flags = 0);
lss_Heartbeat heartbeat(const std::string& vehicle, const std::string& source,
                        std::uint64_t counter);

// One participant with the entities of a mode; DDS is configured by CYCLONEDDS_URI, too. A failure
// ends the program with a message.
class Wire {
 public:
  explicit Wire(dds_domainid_t domain);
  ~Wire();
  Wire(const Wire&) = delete;
  Wire& operator=(const Wire&) = delete;

  enum class Topic { command, heartbeat, ack, status, event, stop, telemetry };
  // Waits until a reader is there when `wait` is set.
  dds_entity_t writer(Topic topic, bool wait = true);
  // 0: DDS Security does not allow it. `as_daemon`: with the QoS that all readers match.
  dds_entity_t try_writer(Topic topic, bool as_daemon = false);
  dds_entity_t reader(Topic topic, const dds_qos_t* qos);
  dds_entity_t participant() const { return participant_; }

 private:
  dds_entity_t topic(Topic topic);
  dds_entity_t domain_, participant_;
};

// Blocks until the status comes; ends the program with a message when it does not within 20 s.
void wait_for(dds_entity_t participant, dds_entity_t entity, std::uint32_t status,
              const char* what);

// Numbers of the run, put out as one line of JSON.
class Counts {
 public:
  explicit Counts(std::string mode) : mode_(std::move(mode)) {}
  void add(const std::string& name, double value) { numbers_.emplace_back(name, value); }
  void add_ns(const std::string& name, std::int64_t value) { times_.emplace_back(name, value); }
  void put_out() const;

 private:
  std::string mode_;
  std::vector<std::pair<std::string, double>> numbers_;
  std::vector<std::pair<std::string, std::int64_t>> times_;
};

// Calls `send` with 0, 1, 2, ... at the rate until the time is over or a signal came; counts what
// was taken and what was refused. Messages more than 20 ms behind are skipped.
void at_rate(const Options& options, Counts& counts,
             const std::function<dds_return_t(std::uint64_t)>& send);
void say_ready();
bool ended();  // by a signal

using Attack = int(const Options&, Counts&);
Attack flood_heartbeats, flood_commands, flood_estop_dry_run, invent_sources, max_sequence,
    many_names, twin, replay, deaf_reader, watch, stop, stops, intrude;

}  // namespace attack
