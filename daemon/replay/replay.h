#pragma once

// Executes frames from records again, with the cycle and the vehicle of this program, and compares
// every output bit with the record. Ordinary thread; time comes from the record.
//
// Per vehicle: record::records_of<Vehicle>(...) in daemon/vehicles/NAME/records.cpp makes the
// VehicleRecords that programs find by the vehicle's name (daemon/replay/records.h).

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/parameters/start.h"
#include "daemon/record/compare.h"
#include "daemon/record/frame_record.h"
#include "daemon/record/json.h"
#include "daemon/record/limits.h"
#include "daemon/record/schema.h"
#include "daemon/record/state.h"
#include "daemon/record/vehicle_records.h"

namespace lss::record {

template <class Vehicle>
class VehicleReplay final : public Replay {
 public:
  template <class Parameters>
  VehicleReplay(const Parameters& parameters, const Logic& logic, TimeNs obc_timeout_ns)
      : vehicle_(parameters), supervisor_(logic, {.obc_timeout_ns = obc_timeout_ns}) {}

  bool restore(std::span<const std::uint8_t> state) override {
    StateReader reader(state);
    keep(reader, vehicle_, supervisor_, out_->telemetry);
    return reader.good();
  }

  Frame step(std::span<const std::uint8_t> record, Probe* probe = nullptr) override {
    Reader reader(record);
    fields(reader, *in_);
    if (!reader.good() || !most::is_time(in_->time_ns))
      return {.difference = Difference{"in", "no inputs of a frame", "-"}};
    const std::span<const std::uint8_t> recorded = record.subspan(reader.at());
    if (probe != nullptr) probe->begin();
    cycle(vehicle_, supervisor_, *in_, *out_, [](Stage) {});
    if (probe != nullptr) probe->end(in_->frame);
    const Outputs computed{out_->command, supervisor_.outbox(), supervisor_.state(),
                           out_->telemetry, out_->data_requested};
    Writer writer(scratch_);
    outputs(writer, computed);
    Frame frame{.frame = in_->frame, .time_ns = in_->time_ns};
    const bool equal = writer.size() + kTiming == recorded.size() &&
                       std::memcmp(scratch_.data(), recorded.data(), writer.size()) == 0;
    if (equal) return frame;
    Compare compare(recorded);
    outputs(compare, computed);
    frame.difference = compare.difference();
    if (!frame.difference)
      frame.difference = Difference{"timing", fmt::format("{} bytes", recorded.size()),
                                    fmt::format("{} bytes", writer.size() + kTiming)};
    return frame;
  }

 private:
  struct Outputs {
    const typename Vehicle::Command& command;
    const Supervisor::Outbox& outbox;
    const SupervisorState& state;
    const typename Vehicle::Telemetry& telemetry;
    const bool& data_requested;
  };
  static std::size_t timing_size() {
    const TimingPoints timing;
    Writer writer(std::span<std::uint8_t>{});
    record::visit(writer, timing);
    return writer.size();
  }

  const std::size_t kTiming = timing_size();
  Vehicle vehicle_;
  Supervisor supervisor_;
  std::unique_ptr<Inputs<Vehicle>> in_ = std::make_unique<Inputs<Vehicle>>();
  std::unique_ptr<lss::Outputs<Vehicle>> out_ = std::make_unique<lss::Outputs<Vehicle>>();
  std::vector<std::uint8_t> scratch_ = std::vector<std::uint8_t>(sizeof(FrameRecord<Vehicle>));
};

template <class Vehicle>
std::string schema_of() {
  const auto frame = std::make_unique<FrameRecord<Vehicle>>();
  Schema schema;
  fields(schema, *frame);
  return schema.text();
}

template <class Vehicle>
nlohmann::ordered_json record_json(std::span<const std::uint8_t> bytes) {
  const auto frame = std::make_unique<FrameRecord<Vehicle>>();
  Reader reader(bytes);
  fields(reader, *frame);
  return to_json(*frame);
}

// read: the vehicle's table of the configuration; complete: what it takes from other tables.
template <class Vehicle, class Parameters>
VehicleRecords records_of(const Logic& logic, const Tuning<Parameters>& tuning,
                          Parameters (*read)(config::Section&),
                          Parameters (*complete)(Parameters, const config::Config&) = nullptr) {
  const auto layout = [&logic] {
    Vehicle vehicle{Parameters{}};
    Supervisor supervisor(logic, {});
    const auto telemetry = std::make_unique<typename Vehicle::Telemetry>();
    StateLayout all;
    keep(all, vehicle, supervisor, *telemetry);
    return all.text();
  };
  const auto replay = [&logic, &tuning, read, complete](config::Section& section) -> MakeReplay {
    own_codes = logic.codes;
    return [&logic, &tuning, complete, parameters = read(section)](
               const config::Config& config) -> tl::expected<std::unique_ptr<Replay>, std::string> {
      Parameters with = complete != nullptr ? complete(parameters, config) : parameters;
      const TakenParameters taken = take_saved(tuning, config.saved, with);
      if (!taken.refused.empty()) return tl::unexpected(taken.refused.front());
      return std::make_unique<VehicleReplay<Vehicle>>(with, logic, config.obc_timeout_ns);
    };
  };
  return {.schema = schema_of<Vehicle>,
          .state_layout = layout,
          .to_json = record_json<Vehicle>,
          .tunables = tuning.infos,
          .replay = replay};
}

}  // namespace lss::record
