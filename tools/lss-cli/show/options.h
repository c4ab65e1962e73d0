#pragma once

// The options of the command line for all verbs. Plain data.

#include <algorithm>
#include <cstdint>
#include <optional>
#include <string>

namespace lss::cli {

struct Options {
  int domain = 0;
  std::string vehicle_id;      // empty: the only one on the domain
  bool vehicle_typed = false;  // on the command line, not in the environment
  std::string source;          // empty: lss-cli:PID, detached lss-cli
  std::string enclave;         // folder, for DDS Security; empty: none
  std::optional<double> timeout_s;
  std::uint32_t lease_ms = 2000;
  bool json = false, jsonl = false;
  bool dry_run = false, detach = false, wait = false;
  bool shared_memory = false;
  bool no_color = false;
  bool lockstep = false;  // simulated time, independent of the machine's clock

  bool machine() const { return json || jsonl; }
  // To find the daemon.
  double find_timeout_s() const { return timeout_s.value_or(lockstep ? 30 : 3); }
  // To complete one command that takes this long by itself.
  double finish_timeout_s(double takes_s = 0) const {
    return timeout_s.value_or(std::max(120.0, takes_s + 30));
  }
};

}  // namespace lss::cli
