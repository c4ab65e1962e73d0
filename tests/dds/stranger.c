// A subscriber and commander that knows nothing but the IDL: default QoS, plain C, no header of the
// daemon. What it uses of shared memory and interfaces comes from CYCLONEDDS_URI, as with any DDS
// program.
//
//   dds_stranger telemetry DOMAIN COUNT SECONDS [keep-all]
//     takes COUNT samples of lss/telemetry/zebro; prints "ready shm=S loan=L" when matched, then
//     "received N"
//   dds_stranger command DOMAIN VEHICLE_ID KIND SECONDS
//     sends one command; prints "phase P reason R TEXT" of its first acknowledgement
// Exit code 0 when it received the expected samples, 1 when the time ran out.
#include <stdio.h>
#include <string.h>

#include "dds/ddsc/dds_loan_api.h"
#include "tests/support/plain_dds.h"
#include "zebro.h"

static int telemetry(dds_entity_t participant, char** argv, int argc) {
  const long wanted = atol(argv[3]);
  const dds_time_t until = dds_time() + DDS_SECS(atol(argv[4]));
  dds_qos_t* keep_all = NULL;
  if (argc > 5) {
    keep_all = dds_create_qos();
    dds_qset_history(keep_all, DDS_HISTORY_KEEP_ALL, 0);
  }
  const dds_entity_t reader =
      reader_of(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", keep_all, NULL);
  dds_delete_qos(keep_all);
  if (reader < 0) return 2;
  const dds_entity_t matched = waitset_on(participant, reader, DDS_SUBSCRIPTION_MATCHED_STATUS);
  if (!wait_until(matched, until)) return 1;
  printf("ready shm=%d loan=%d\n", dds_is_shared_memory_available(reader),
         dds_is_loan_available(reader));
  dds_delete(matched);

  const dds_entity_t waitset = waitset_on(participant, reader, DDS_DATA_AVAILABLE_STATUS);
  long received = 0;
  while (received < wanted && wait_until(waitset, until)) {
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
  const dds_entity_t writer = writer_of(participant, &lss_Command_desc, "lss/command", NULL);
  const dds_entity_t reader =
      reader_of(participant, &lss_CommandAck_desc, "lss/command_ack", NULL, NULL);
  if (writer < 0 || reader < 0) return 2;
  if (!wait_for_daemon(participant, writer, reader, until)) return 1;

  const dds_entity_t waitset = waitset_on(participant, reader, DDS_DATA_AVAILABLE_STATUS);
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
    if (!wait_until(waitset, dds_time() + DDS_MSECS(200))) continue;
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
  const dds_entity_t participant = join(argv[2]);
  if (participant < 0) return 2;
  const int result = strcmp(argv[1], "telemetry") == 0 ? telemetry(participant, argv, argc)
                                                       : command(participant, argv);
  dds_delete(participant);
  return result;
}
