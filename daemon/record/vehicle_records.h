#pragma once

// Operations on the records of any vehicle.

#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <string>
#include <tl/expected.hpp>

#include "daemon/config/config.h"
#include "daemon/cycle/tunables.h"
#include "daemon/record/run_log.h"
#include "drivers/time.h"

namespace lss::record {

// Of the first member that differs.
struct Difference {
  std::string field;  // "telemetry.modules[3].position_rad"
  std::string recorded, computed;
};

// Around each executed cycle.
class Probe {
 public:
  virtual ~Probe() = default;
  virtual void begin() noexcept = 0;
  virtual void end(std::uint64_t frame) noexcept = 0;
};

// A vehicle that executes records.
class Replay {
 public:
  virtual ~Replay() = default;
  struct Frame {
    std::uint64_t frame = 0;
    TimeNs time_ns = 0;
    std::optional<Difference> difference{};
  };
  // Executes the next frame from its inputs and compares its outputs.
  virtual Frame step(std::span<const std::uint8_t> record, Probe* probe = nullptr) = 0;
  // Sets the recorded state of the vehicle between two frames. False: not of this program.
  virtual bool restore(std::span<const std::uint8_t> state) = 0;
};

// The error: which saved parameter this program does not accept.
using MakeReplay =
    std::function<tl::expected<std::unique_ptr<Replay>, std::string>(const config::Config& config)>;

struct VehicleRecords {
  std::function<std::string()> schema;        // schema.h
  std::function<std::string()> state_layout;  // state.h
  ToJson to_json;
  std::span<const TunableInfo> tunables{};  // parameters that can be changed while it runs
  // Reads the vehicle's table of the configuration; errors go to the section.
  std::function<MakeReplay(config::Section& section)> replay;
};

}  // namespace lss::record
