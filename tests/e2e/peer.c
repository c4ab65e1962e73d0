// The other end of the DDS face for the end-to-end tests: built from the IDL alone, default QoS,
// plain C, no header of the daemon. Interfaces and shared memory come from CYCLONEDDS_URI, as with
// any DDS program.
//
//   e2e_peer commander DOMAIN VEHICLE_ID [SOURCE]
//     says "ready" when the daemon answers it as SOURCE, then obeys lines on its standard input
//     until it ends:
//       command SOURCE SEQ KIND FLAGS LEASE_MS P0 .. P7    (SOURCE "-": 32 characters without a
//       NUL) heartbeat SOURCE COUNTER
//     and prints a line for each received acknowledgement:
//       ack SOURCE SEQ KIND PHASE REASON TIME_NS
//   e2e_peer telemetry DOMAIN COUNT SECONDS
//     takes COUNT samples as loans and COUNT as they came, and says
//       reader shm=B loan=B        capabilities of the reader
//       loaned N                   samples taken as loans, frames growing
//       chunks N                   samples that came as chunks of shared memory
// Exit code 0 when it received the expected samples, 1 when the time ran out, 2 when DDS refused.
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "dds/ddsc/dds_loan_api.h"
#include "dds/ddsi/ddsi_serdata.h"
#include "tests/support/plain_dds.h"
#include "zebro.h"

static void put_text(char* field, size_t size, const char* text) {
  memset(field, 0, size);
  strncpy(field, text, size - 1);
}

// --- telemetry

typedef struct {
  unsigned long long frame;  // of the last sample
  long count;
  bool growing;
} Series;

static void add(Series* series, const lss_ZebroTelemetry* sample) {
  if (series->count > 0 && sample->frame <= series->frame) series->growing = false;
  series->frame = sample->frame;
  ++series->count;
}

static void take_loans(dds_entity_t reader, Series* series) {
  void* samples[8] = {NULL};
  dds_sample_info_t infos[8];
  const dds_return_t count = dds_take(reader, samples, infos, 8, 8);
  for (dds_return_t i = 0; i < count; ++i) {
    if (infos[i].valid_data) add(series, samples[i]);
  }
  if (count > 0) dds_return_loan(reader, samples, count);
}

static void take_chunks(dds_entity_t reader, long* chunks, long* others) {
  struct ddsi_serdata* data[8];
  dds_sample_info_t infos[8];
  const dds_return_t count = dds_takecdr(reader, data, 8, infos, DDS_ANY_STATE);
  for (dds_return_t i = 0; i < count; ++i) {
    if (infos[i].valid_data) ++*(data[i]->iox_chunk != NULL ? chunks : others);
    ddsi_serdata_unref(data[i]);
  }
}

static int telemetry(dds_entity_t participant, long wanted, dds_time_t until) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_BEST_EFFORT, 0);
  const dds_entity_t reader =
      reader_of(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", qos, NULL);
  dds_delete_qos(qos);
  if (reader < 0) return 2;
  printf("reader shm=%d loan=%d\n", dds_is_shared_memory_available(reader),
         dds_is_loan_available(reader));

  const dds_entity_t waitset = waitset_on(participant, reader, DDS_DATA_AVAILABLE_STATUS);
  Series loaned = {0, 0, true};
  while (loaned.count < wanted && wait_until(waitset, until)) take_loans(reader, &loaned);
  printf("loaned %ld\n", loaned.count);
  long chunks = 0, others = 0;
  while (chunks + others < wanted && wait_until(waitset, until))
    take_chunks(reader, &chunks, &others);
  printf("chunks %ld\n", chunks);
  if (!loaned.growing) printf("frames went back\n");
  return loaned.growing && loaned.count >= wanted && chunks + others >= wanted ? 0 : 1;
}

// --- commander

typedef struct {
  const char* vehicle_id;
  dds_entity_t command, heartbeat, ack;
} Commander;

static bool send_command(const Commander* c, char* words) {
  lss_Command sample;
  memset(&sample, 0, sizeof sample);
  put_text(sample.vehicle_id, sizeof sample.vehicle_id, c->vehicle_id);
  const char* source = strtok_r(NULL, " \n", &words);
  if (source == NULL) return false;
  if (strcmp(source, "-") == 0) {
    memset(sample.source, 'x', sizeof sample.source);
  } else {
    put_text(sample.source, sizeof sample.source, source);
  }
  double number[4 + 8] = {0};  // seq kind flags lease_ms p0..p7
  for (size_t i = 0; i < 12; ++i) {
    const char* word = strtok_r(NULL, " \n", &words);
    if (word == NULL) break;
    number[i] = strtod(word, NULL);
  }
  sample.seq = (unsigned long long)number[0];
  sample.kind = (uint16_t)number[1];
  sample.flags = (uint16_t)number[2];
  sample.lease_ms = (uint32_t)number[3];
  memcpy(sample.parameter, number + 4, sizeof sample.parameter);
  const char* name = strtok_r(NULL, " \n", &words);  // "-": all letters, no terminator
  if (name != NULL && strcmp(name, "-") == 0) {
    memset(sample.name, 'x', sizeof sample.name);
  } else if (name != NULL) {
    put_text(sample.name, sizeof sample.name, name);
  }
  return dds_write(c->command, &sample) == DDS_RETCODE_OK;
}

static bool send_heartbeat(const Commander* c, char* words) {
  lss_Heartbeat sample;
  memset(&sample, 0, sizeof sample);
  const char* source = strtok_r(NULL, " \n", &words);
  const char* counter = strtok_r(NULL, " \n", &words);
  if (source == NULL || counter == NULL) return false;
  put_text(sample.vehicle_id, sizeof sample.vehicle_id, c->vehicle_id);
  put_text(sample.source, sizeof sample.source, source);
  sample.counter = strtoull(counter, NULL, 10);
  return dds_write(c->heartbeat, &sample) == DDS_RETCODE_OK;
}

static bool obey(const Commander* c, char* line) {
  char* rest = NULL;
  const char* verb = strtok_r(line, " \n", &rest);
  if (verb == NULL) return true;
  if (strcmp(verb, "command") == 0) return send_command(c, rest);
  if (strcmp(verb, "heartbeat") == 0) return send_heartbeat(c, rest);
  return false;
}

// The daemon's end may not know the reader of acknowledgements yet when ours knows the daemon's,
// and they are not sent twice: asks for nothing, by a writer of its own, until that is answered.
static const char* probe = "e2e-peer-probe";  // its source

static bool wait_for_answer(const Commander* c, dds_entity_t participant, dds_time_t until) {
  const dds_entity_t writer = writer_of(participant, &lss_Command_desc, "lss/command", NULL);
  const dds_entity_t waitset = waitset_on(participant, c->ack, DDS_DATA_AVAILABLE_STATUS);
  lss_Command sample;
  memset(&sample, 0, sizeof sample);
  put_text(sample.vehicle_id, sizeof sample.vehicle_id, c->vehicle_id);
  put_text(sample.source, sizeof sample.source, probe);
  sample.kind = 6;   // data
  sample.flags = 1;  // dry run
  bool answered = false;
  while (!answered && dds_time() < until) {
    ++sample.seq;
    if (dds_write(writer, &sample) != DDS_RETCODE_OK) break;
    if (!wait_until(waitset, dds_time() + DDS_MSECS(100))) continue;
    static lss_CommandAck ack;
    void* pointer = &ack;
    dds_sample_info_t info;
    answered = dds_take(c->ack, &pointer, &info, 1, 1) == 1 && info.valid_data &&
               strcmp(ack.source, probe) == 0;
  }
  dds_delete(waitset);
  dds_delete(writer);
  return answered;
}

static void report_acks(const Commander* c) {
  void* samples[16] = {NULL};
  dds_sample_info_t infos[16];
  const dds_return_t count = dds_take(c->ack, samples, infos, 16, 16);
  for (dds_return_t i = 0; i < count; ++i) {
    const lss_CommandAck* ack = samples[i];
    if (!infos[i].valid_data || strcmp(ack->source, probe) == 0) continue;
    printf("ack %.32s %llu %u %d %u %lld\n", ack->source[0] != 0 ? ack->source : "-",
           (unsigned long long)ack->seq, ack->kind, (int)ack->phase, ack->reason,
           (long long)ack->time_ns);
  }
  if (count > 0) dds_return_loan(c->ack, samples, count);
}

static int commander(dds_entity_t participant, const char* vehicle_id) {
  dds_qos_t* keep_all = reliable_qos();  // acknowledgements in a row are all wanted
  dds_qset_history(keep_all, DDS_HISTORY_KEEP_ALL, 0);
  const Commander c = {
      vehicle_id, writer_of(participant, &lss_Command_desc, "lss/command", NULL),
      writer_of(participant, &lss_Heartbeat_desc, "lss/heartbeat", NULL),
      reader_of(participant, &lss_CommandAck_desc, "lss/command_ack", keep_all, NULL)};
  dds_delete_qos(keep_all);
  if (c.command < 0 || c.heartbeat < 0 || c.ack < 0) return 2;
  const dds_time_t until = dds_time() + DDS_SECS(20);
  if (!wait_for_daemon(participant, c.command, c.ack, until) ||
      !wait_until(waitset_on(participant, c.heartbeat, DDS_PUBLICATION_MATCHED_STATUS), until) ||
      !wait_for_answer(&c, participant, until)) {
    return 1;
  }
  printf("ready\n");

  char line[1024];
  struct pollfd input = {STDIN_FILENO, POLLIN, 0};
  for (;;) {
    if (poll(&input, 1, 1) > 0) {  // every millisecond the acknowledgements
      if (fgets(line, sizeof line, stdin) == NULL) return 0;
      if (!obey(&c, line)) return 2;
    }
    report_acks(&c);
  }
}

int main(int argc, char** argv) {
  if (argc < 4) return 2;
  setvbuf(stdout, NULL, _IOLBF, 0);
  setvbuf(stdin, NULL, _IONBF, 0);  // poll() shall see every line
  const dds_entity_t participant = join(argv[2]);
  if (participant < 0) return 2;
  if (argc > 4 && strcmp(argv[1], "commander") == 0) probe = argv[4];
  const int result =
      strcmp(argv[1], "commander") == 0
          ? commander(participant, argv[3])
          : telemetry(participant, atol(argv[3]), dds_time() + DDS_SECS(atol(argv[4])));
  dds_delete(participant);
  return result;
}
