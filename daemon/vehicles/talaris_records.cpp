#include "daemon/record/replay.h"
#include "daemon/vehicles/records.h"
#include "daemon/vehicles/talaris_record.h"
#include "daemon/vehicles/talaris_tunables.h"

namespace lss {

record::VehicleRecords talaris_records() {
  return record::records_of<talaris::Vehicle>(talaris::logic(), talaris::tuning(),
                                              talaris::read_parameters, talaris::with_frame);
}

}  // namespace lss
