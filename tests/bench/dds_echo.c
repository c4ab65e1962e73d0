// The least a DDS program can do to answer commands: a listener that takes them and writes an
// acknowledgement. It also reads and discards telemetry, so that a writer has a reader.
//
//   bench-dds-echo DOMAIN
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "tests/support/plain_dds.h"
#include "zebro.h"

static dds_entity_t ack_writer;

static void on_command(dds_entity_t reader, void* argument) {
  (void)argument;
  static lss_Command sample;
  static lss_CommandAck ack;
  void* pointer = &sample;
  dds_sample_info_t info;
  while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
    if (!info.valid_data) continue;
    memcpy(ack.vehicle_id, sample.vehicle_id, sizeof ack.vehicle_id);
    memcpy(ack.source, sample.source, sizeof ack.source);
    ack.seq = sample.seq;
    ack.kind = sample.kind;
    ack.phase = lss_PHASE_ACCEPTED;
    dds_write(ack_writer, &ack);
  }
}

static void on_telemetry(dds_entity_t reader, void* argument) {
  (void)argument;
  static lss_ZebroTelemetry sample;
  drain(reader, &sample);
}

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  const dds_entity_t participant = join(argv[1]);
  dds_qos_t* reliable = reliable_qos();
  dds_qset_deadline(reliable, DDS_SECS(10));
  ack_writer = writer_of(participant, &lss_CommandAck_desc, "lss/command_ack", reliable);
  dds_qset_deadline(reliable, DDS_INFINITY);
  dds_listener_t* listener = dds_create_listener(NULL);
  dds_lset_data_available(listener, on_command);
  const dds_entity_t commands =
      reader_of(participant, &lss_Command_desc, "lss/command", reliable, listener);
  dds_lset_data_available(listener, on_telemetry);
  const dds_entity_t telemetry =
      reader_of(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", NULL, listener);
  if (ack_writer < 0 || commands < 0 || telemetry < 0) return 2;
  printf("ready\n");
  fflush(stdout);
  for (;;) pause();
}
