#pragma once

// Flight recordings of chains in virtual time: frames are written down as the daemon's frame thread
// does (daemon/app/runtime.h), and put into files by its own recorder. What the vehicle remembers
// is asked for where a file ends, so that every file but the first begins in the middle of a run.
// One thread.
//
//   chain.tape = testing_support::tape<zebro::Vehicle>(folder, chain.config());
//   ...
//   chain.tape = {};  // the last file is ended

#include <filesystem>
#include <functional>
#include <memory>
#include <stdexcept>
#include <vector>

#include "daemon/cycle/cycle.h"
#include "daemon/record/frame_record.h"
#include "daemon/record/recorder.h"
#include "daemon/record/state.h"
#include "daemon/replay/records.h"

namespace lss::testing_support {

template <class Vehicle>
using Tape = std::function<void(const Inputs<Vehicle>& in, const Outputs<Vehicle>& out,
                                Supervisor& supervisor, Vehicle& vehicle)>;

template <class Vehicle>
class TapeRecorder {
 public:
  explicit TapeRecorder(record::RecorderSettings settings)
      : recorder_(std::move(settings), [](EventId) {
          throw std::runtime_error("the disk does not take what is recorded");
        }) {
    recorder_.begin();
  }

  void frame(const Inputs<Vehicle>& in, const Outputs<Vehicle>& out, Supervisor& supervisor,
             Vehicle& vehicle) {
    const TimingPoints timing{.frame = in.frame, .boundary_ns = in.time_ns};
    record::Writer writer(scratch_);
    fields(writer,
           record::FrameView<Vehicle>{in, out.command, supervisor.outbox(), supervisor.state(),
                                      out.telemetry, out.data_requested, timing});
    if (!writer.fits()) throw std::runtime_error("a record is larger than its structs");
    recorder_.put_frame(std::span(scratch_).first(writer.size()), in.time_ns, 0, in.time_ns);
    if (recorder_.wants_state()) {
      record::StateWriter state(scratch_);
      typename Vehicle::Telemetry telemetry = out.telemetry;
      record::keep(state, vehicle, supervisor, telemetry);
      if (!state.fits()) throw std::runtime_error("a state is larger than its structs");
      recorder_.put_state(std::span(scratch_).first(state.size()), 0, in.time_ns);
    }
    recorder_.turn(in.time_ns);
  }

 private:
  record::Recorder recorder_;
  std::vector<std::uint8_t> scratch_ = std::vector<std::uint8_t>(
      std::max(sizeof(record::FrameRecord<Vehicle>),
               sizeof(Vehicle) + sizeof(Supervisor) + sizeof(typename Vehicle::Telemetry)));
};

template <class Vehicle>
Tape<Vehicle> tape(const std::filesystem::path& folder, config::Config config) {
  config.log_folder = folder;
  config.recorder.file_bytes = 1'000'000;
  config.recorder.total_bytes = 4'000'000'000;  // none is dropped
  config.recorder.sync = false;
  const auto records = vehicle_records(config.vehicle);
  auto recorder = std::make_shared<TapeRecorder<Vehicle>>(
      record::recorder_settings(config, "test", records->schema(), records->state_layout()));
  return [recorder](const Inputs<Vehicle>& in, const Outputs<Vehicle>& out, Supervisor& supervisor,
                    Vehicle& vehicle) { recorder->frame(in, out, supervisor, vehicle); };
}

}  // namespace lss::testing_support
