// Shows how far Lunar Zebro has walked, by DDS (docs/tutorial-client.md).

#include <stdio.h>
#include <stdlib.h>

#include "dds/dds.h"
#include "zebro.h"

int main(void) {
  const char* domain = getenv("LSS_DOMAIN");
  dds_entity_t participant =
      dds_create_participant(domain != NULL ? (dds_domainid_t)atoi(domain) : 0, NULL, NULL);
  dds_entity_t topic =
      dds_create_topic(participant, &lss_ZebroTelemetry_desc, "lss/telemetry/zebro", NULL, NULL);
  dds_entity_t reader = dds_create_reader(participant, topic, NULL, NULL);
  if (reader < 0) {
    fprintf(stderr, "DDS: %s\n", dds_strretcode(reader));
    return 1;
  }
  dds_entity_t wait = dds_create_waitset(participant);
  dds_waitset_attach(wait, dds_create_readcondition(reader, DDS_ANY_STATE), 0);
  for (int count = 0; count < 20;) {
    if (dds_waitset_wait(wait, NULL, 0, DDS_SECS(10)) <= 0) {
      fprintf(stderr, "nothing for 10 s: is lssd on this DDS domain and this network interface?\n");
      return 1;
    }
    void* samples[1] = {NULL};
    dds_sample_info_t info;
    if (dds_take(reader, samples, &info, 1, 1) < 1) continue;
    const lss_ZebroTelemetry* t = samples[0];
    if (info.valid_data && ++count % 10 == 0)
      printf("frame %llu: %.3f m\n", (unsigned long long)t->frame, t->distance_m);
    dds_return_loan(reader, samples, 1);
  }
  dds_delete(participant);
  return 0;
}
