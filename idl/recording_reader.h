#pragma once

// The reader for programs that record samples. Ordinary threads; may allocate and block.

#include "idl/topics.h"

namespace lss::dds {

// Receives all samples of a topic, in a participant without shared memory, and keeps the last 4096
// of each key until they are taken. The listener must outlive only the call.
Result<Entity> create_recording_reader(dds_entity_t participant, const Topic& topic,
                                       const dds_listener_t* listener);

}  // namespace lss::dds
