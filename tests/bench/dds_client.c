// The least a program can do to have a command answered: joins, finds the other end, sends, waits
// for the acknowledgement, leaves.
//
//   bench-dds-client DOMAIN VEHICLE_ID KIND FLAGS
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "dds/dds.h"
#include "lss.h"

static bool wait_for(dds_entity_t participant, dds_entity_t entity, uint32_t mask,
                     dds_duration_t limit) {
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_set_status_mask(entity, mask);
  dds_waitset_attach(waitset, entity, 0);
  dds_attach_t triggered;
  const bool came = dds_waitset_wait(waitset, &triggered, 1, limit) > 0;
  dds_delete(waitset);
  return came;
}

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const dds_entity_t participant =
      dds_create_participant((dds_domainid_t)atoi(argv[1]), NULL, NULL);
  dds_qos_t* reliable = dds_create_qos();
  dds_qset_reliability(reliable, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  const dds_entity_t reader = dds_create_reader(
      participant,
      dds_create_topic(participant, &lss_CommandAck_desc, "lss/command_ack", NULL, NULL), reliable,
      NULL);
  const dds_entity_t writer = dds_create_writer(
      participant, dds_create_topic(participant, &lss_Command_desc, "lss/command", NULL, NULL),
      reliable, NULL);
  if (reader < 0 || writer < 0) return 2;
  if (!wait_for(participant, writer, DDS_PUBLICATION_MATCHED_STATUS, DDS_SECS(10)) ||
      !wait_for(participant, reader, DDS_SUBSCRIPTION_MATCHED_STATUS, DDS_SECS(10)))
    return 1;
  lss_Command sample;
  memset(&sample, 0, sizeof sample);
  strncpy(sample.vehicle_id, argv[2], sizeof sample.vehicle_id - 1);
  dds_guid_t guid;  // sequence numbers are kept for each source: this run is one of its own
  dds_get_guid(participant, &guid);
  memcpy(sample.source, "bench-", 6);
  for (int i = 0; i < 12; ++i) sample.source[6 + i] = (char)('a' + guid.v[i] % 26);
  sample.kind = (uint16_t)atoi(argv[3]);
  sample.flags = (uint16_t)atoi(argv[4]);
  // The other end may not know our reader yet, so an unanswered message is sent again.
  for (int i = 0; i < 100; ++i) {
    ++sample.seq;
    if (dds_write(writer, &sample) != DDS_RETCODE_OK) return 2;
    if (!wait_for(participant, reader, DDS_DATA_AVAILABLE_STATUS, DDS_MSECS(20))) continue;
    static lss_CommandAck ack;
    void* pointer = &ack;
    dds_sample_info_t info;
    if (dds_take(reader, &pointer, &info, 1, 1) < 1) continue;
    dds_delete(participant);
    return 0;
  }
  return 1;
}
