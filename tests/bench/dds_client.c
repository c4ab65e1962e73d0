// The least a program can do to have a command answered: joins, finds the other end, sends, waits
// for the acknowledgement, leaves.
//
//   bench-dds-client DOMAIN VEHICLE_ID KIND FLAGS
#include <string.h>

#include "tests/support/plain_dds.h"

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  const dds_entity_t participant = join(argv[1]);
  dds_qos_t* reliable = reliable_qos();
  const dds_entity_t reader =
      reader_of(participant, &lss_CommandAck_desc, "lss/command_ack", reliable, NULL);
  const dds_entity_t writer = writer_of(participant, &lss_Command_desc, "lss/command", reliable);
  if (reader < 0 || writer < 0) return 2;
  if (!wait_for_daemon(participant, writer, reader, dds_time() + DDS_SECS(10))) return 1;
  const dds_entity_t answered = waitset_on(participant, reader, DDS_DATA_AVAILABLE_STATUS);
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
    if (!wait_until(answered, dds_time() + DDS_MSECS(20))) continue;
    static lss_CommandAck ack;
    void* pointer = &ack;
    dds_sample_info_t info;
    if (dds_take(reader, &pointer, &info, 1, 1) < 1) continue;
    dds_delete(participant);
    return 0;
  }
  return 1;
}
