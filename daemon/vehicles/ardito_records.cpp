#include "daemon/record/replay.h"
#include "daemon/vehicles/ardito_record.h"
#include "daemon/vehicles/ardito_tunables.h"
#include "daemon/vehicles/records.h"

namespace lss {

record::VehicleRecords ardito_records() {
  return record::records_of<ardito::Vehicle>(ardito::logic(), ardito::tuning(),
                                             ardito::read_parameters);
}

}  // namespace lss
