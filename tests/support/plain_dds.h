// What plain C programs of tests and benchmarks need to talk to the daemon: DDS and the IDL, no
// header of the daemon. Entities live as long as the program.
#pragma once

#include <stdbool.h>
#include <stdlib.h>

#include "dds/dds.h"
#include "lss.h"

// `domain`: a word of the command line.
static inline dds_entity_t join(const char* domain) {
  return dds_create_participant((dds_domainid_t)atoi(domain), NULL, NULL);
}

static inline dds_entity_t reader_of(dds_entity_t participant, const dds_topic_descriptor_t* type,
                                     const char* topic, const dds_qos_t* qos,
                                     const dds_listener_t* listener) {
  return dds_create_reader(participant, dds_create_topic(participant, type, topic, NULL, NULL), qos,
                           listener);
}

static inline dds_entity_t writer_of(dds_entity_t participant, const dds_topic_descriptor_t* type,
                                     const char* topic, const dds_qos_t* qos) {
  return dds_create_writer(participant, dds_create_topic(participant, type, topic, NULL, NULL), qos,
                           NULL);
}

static inline dds_qos_t* reliable_qos(void) {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  return qos;
}

// A waitset that triggers on the status of the entity.
static inline dds_entity_t waitset_on(dds_entity_t participant, dds_entity_t entity,
                                      uint32_t status) {
  const dds_entity_t waitset = dds_create_waitset(participant);
  dds_set_status_mask(entity, status);
  dds_waitset_attach(waitset, entity, 0);
  return waitset;
}

// False when the time is over.
static inline bool wait_until(dds_entity_t waitset, dds_time_t until) {
  dds_attach_t triggered;
  return dds_waitset_wait_until(waitset, &triggered, 1, until) > 0;
}

// Commands and acknowledgements are volatile: both ends have to know each other first.
static inline bool wait_for_daemon(dds_entity_t participant, dds_entity_t command_writer,
                                   dds_entity_t ack_reader, dds_time_t until) {
  return wait_until(waitset_on(participant, command_writer, DDS_PUBLICATION_MATCHED_STATUS),
                    until) &&
         wait_until(waitset_on(participant, ack_reader, DDS_SUBSCRIPTION_MATCHED_STATUS), until);
}

// Takes all samples and looks at none.
static inline void drain(dds_entity_t reader, void* sample) {
  dds_sample_info_t info;
  while (dds_take(reader, &sample, &info, 1, 1) > 0) {
  }
}
