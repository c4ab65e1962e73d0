#pragma once

// The reader of those who put samples into files. Ordinary threads; may allocate and block.

#include "idl/topics.h"

namespace lss::dds {

// Hears whatever is written, in a participant without shared memory, and keeps the last 4096
// samples of each key until they are taken. The listener must outlive the call only.
Result<Entity> create_recording_reader(dds_entity_t participant, const Topic& topic,
                                       const dds_listener_t* listener);

}  // namespace lss::dds
