#include "daemon/record/replay.h"
#include "daemon/vehicles/records.h"
#include "daemon/vehicles/zebro_record.h"
#include "daemon/vehicles/zebro_tunables.h"

namespace lss {

record::VehicleRecords zebro_records() {
  return record::records_of<zebro::Vehicle>(zebro::logic(), zebro::tuning(),
                                            zebro::read_parameters);
}

}  // namespace lss
