// The wiring of TALARIS: two sensor lines and a CAN bus (buses.h); the IMU's packets begin
// the frames, the actuate thread writes the edges of the valves.

#include "daemon/kit/declare.h"
#include "daemon/vehicles/talaris/buses.h"
#include "daemon/vehicles/talaris/tunables.h"
#include "daemon/vehicles/talaris/vehicle.h"
#include "daemon/vehicles/talaris/words.h"

namespace lss::talaris {
namespace {

// The buses as the runtime asks for them.
class Wiring final : public Buses {
 public:
  using Parameters = talaris::Parameters;

  Wiring(const config::Config& config, const Parameters& parameters)
      : Buses(config, parameters.buses) {}

  void collect(lss::Inputs<Vehicle>& in) noexcept {
    in.sample_count =
        static_cast<std::uint32_t>(Buses::collect(in.time_ns, std::span(in.samples), in.bus));
    if (take_memory_lost()) in.memory = MemoryCheck::lost;
  }
};

}  // namespace
}  // namespace lss::talaris

namespace lss {

record::VehicleRecords talaris_records();

Port talaris_port() {
  return kit::port<talaris::Vehicle, talaris::Wiring>(talaris::read_parameters, talaris::tuning(),
                                                      talaris::logic(), talaris::vocabulary(),
                                                      talaris_records, talaris::with_frame);
}

}  // namespace lss
