#include "daemon/replay/records.h"

#include "daemon/replay/replay.h"
#include "daemon/vehicles/talaris/tunables.h"
#include "daemon/vehicles/talaris/vehicle.h"

namespace lss {

record::VehicleRecords talaris_records() {
  return record::records_of<talaris::Vehicle>(talaris::logic(), talaris::tuning(),
                                              talaris::read_parameters, talaris::with_frame);
}

}  // namespace lss
