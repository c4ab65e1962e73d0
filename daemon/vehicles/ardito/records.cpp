#include "daemon/replay/records.h"

#include "daemon/replay/replay.h"
#include "daemon/vehicles/ardito/tunables.h"
#include "daemon/vehicles/ardito/vehicle.h"

namespace lss {

record::VehicleRecords ardito_records() {
  return record::records_of<ardito::Vehicle>(ardito::logic(), ardito::tuning(),
                                             ardito::read_parameters);
}

}  // namespace lss
