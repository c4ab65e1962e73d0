#include "daemon/replay/records.h"

#include "daemon/replay/replay.h"
#include "daemon/vehicles/zebro/tunables.h"
#include "daemon/vehicles/zebro/vehicle.h"

namespace lss {

record::VehicleRecords zebro_records() {
  return record::records_of<zebro::Vehicle>(zebro::logic(), zebro::tuning(), zebro::read_parameters,
                                            zebro::with_link);
}

}  // namespace lss
