// A subscriber and commander that knows nothing but the IDL: default QoS, plain C, no header of
// ours. What it uses of shared memory and interfaces comes from CYCLONEDDS_URI, as with any DDS
// program.
//
//   dds_stranger telemetry DOMAIN COUNT SECONDS [keep-all]
//     takes COUNT samples of lss/telemetry/zebro; prints "ready shm=S loan=L" when matched, then
//     "received N"
//   dds_stranger command DOMAIN VEHICLE_ID KIND SECONDS
//     sends one command; prints "phase P reason R TEXT" of its first acknowledgement
// Exit code 0 when it received the expected samples, 1 when the time ran out.
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "dds/dds.h"
#include "dds/ddsc/dds_loan_api.h"
#include "lss.h"
#include "zebro.h"

// Waits until the condition of the waitset triggers; false when the time is over.
static bool wait_for(dds_entity_t waitset, dds_time_t until) {
  dds_attach_t triggered;
  return dds_waitset_wait_until(waitset, &triggered, 1, until) > 0;
}

static dds_entity_t status_waitset(dds_entity_t participant, dds_entity_t entity, uint32_t mask) {
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_set_status_mask(entity, mask);
  dds_waitset_attach(waitset, entity, 0);
  return waitset;
}

static int telemetry(dds_entity_t participant, char** argv, int argc) {
  const long wanted = atol(argv[3]);
  const dds_time_t until = dds_time() + DDS_SECS(atol(argv[4]));
  dds_qos_t* keep_all = NULL;
  if (argc > 5) {
    keep_all = dds_create_qos();
    dds_qset_history(keep_all, DDS_HISTORY_KEEP_ALL, 0);
  }
  const dds_entity_t topic =
      dds_create_topic(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, topic, keep_all, NULL);
  dds_delete_qos(keep_all);
  if (reader < 0) return 2;
  const dds_entity_t matched = status_waitset(participant, reader, DDS_SUBSCRIPTION_MATCHED_STATUS);
  if (!wait_for(matched, until)) return 1;
  printf("ready shm=%d loan=%d\n", dds_is_shared_memory_available(reader),
         dds_is_loan_available(reader));
  dds_delete(matched);

  const dds_entity_t waitset = status_waitset(participant, reader, DDS_DATA_AVAILABLE_STATUS);
  long received = 0;
  while (received < wanted && wait_for(waitset, until)) {
    void* samples[8] = {NULL};
    dds_sample_info_t infos[8];
    const dds_return_t count = dds_take(reader, samples, infos, 8, 8);
    for (dds_return_t i = 0; i < count; ++i) received += infos[i].valid_data;
    if (count > 0) dds_return_loan(reader, samples, count);
  }
  printf("received %ld\n", received);
  return received >= wanted ? 0 : 1;
}

static int command(dds_entity_t participant, char** argv) {
  const dds_time_t until = dds_time() + DDS_SECS(atol(argv[5]));
  const dds_entity_t command_topic =
      dds_create_topic(participant, &lss_Command_desc, "lss/command", NULL, NULL);
  const dds_entity_t ack_topic =
      dds_create_topic(participant, &lss_CommandAck_desc, "lss/command_ack", NULL, NULL);
  const dds_entity_t writer = dds_create_writer(participant, command_topic, NULL, NULL);
  const dds_entity_t reader = dds_create_reader(participant, ack_topic, NULL, NULL);
  if (writer < 0 || reader < 0) return 2;
  // Both ends have to know each other before a volatile command is worth sending.
  if (!wait_for(status_waitset(participant, writer, DDS_PUBLICATION_MATCHED_STATUS), until) ||
      !wait_for(status_waitset(participant, reader, DDS_SUBSCRIPTION_MATCHED_STATUS), until)) {
    return 1;
  }

  const dds_entity_t waitset = status_waitset(participant, reader, DDS_DATA_AVAILABLE_STATUS);
  lss_Command sample;
  memset(&sample, 0, sizeof sample);
  strncpy(sample.vehicle_id, argv[3], sizeof sample.vehicle_id - 1);
  strcpy(sample.source, "stranger");
  sample.kind = (uint16_t)atoi(argv[4]);
  // The acknowledgement is written before the daemon's end may know of this best-effort reader, so
  // a stranger repeats, with growing sequence numbers, until it is answered.
  while (dds_time() < until) {
    ++sample.seq;
    if (dds_write(writer, &sample) != DDS_RETCODE_OK) return 2;
    if (!wait_for(waitset, dds_time() + DDS_MSECS(200))) continue;
    void* samples[1] = {NULL};
    dds_sample_info_t info;
    const dds_return_t count = dds_take(reader, samples, &info, 1, 1);
    if (count < 1 || !info.valid_data) continue;
    const lss_CommandAck* ack = samples[0];
    printf("phase %d reason %d %s\n", (int)ack->phase, ack->reason, ack->text);
    dds_return_loan(reader, samples, count);
    return 0;
  }
  return 1;
}

int main(int argc, char** argv) {
  if (argc < 5) return 2;
  setvbuf(stdout, NULL, _IOLBF, 0);
  const dds_entity_t participant =
      dds_create_participant((dds_domainid_t)atoi(argv[2]), NULL, NULL);
  if (participant < 0) return 2;
  const int result = strcmp(argv[1], "telemetry") == 0 ? telemetry(participant, argv, argc)
                                                       : command(participant, argv);
  dds_delete(participant);
  return result;
}
