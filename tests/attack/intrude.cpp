// A participant that does all that DDS Security lets it: it writes all that clients and daemons
// write, in the name of --source, and reads the status.

#include <cstdio>
#include <cstring>

#include "tests/attack/attack.h"

namespace attack {

int intrude(const Options& o, Counts& counts) {
  using Topic = Wire::Topic;
  constexpr std::pair<Topic, const char*> kTopics[] = {
      {Topic::command, "command"},     {Topic::stop, "stop"},     {Topic::ack, "ack"},
      {Topic::heartbeat, "heartbeat"}, {Topic::status, "status"}, {Topic::event, "event"},
      {Topic::telemetry, "telemetry"}};
  Wire wire(o.domain);
  dds_qos_t* daemon = dds_create_qos();  // it looks like a daemon, before anybody knows its topics
  dds_qset_userdata(daemon, kDaemonSource, std::strlen(kDaemonSource));
  dds_set_qos(wire.participant(), daemon);
  dds_delete_qos(daemon);
  std::vector<std::pair<Topic, dds_entity_t>> writers;
  for (const auto& [topic, name] : kTopics) {
    const dds_entity_t writer = wire.try_writer(topic, true);
    if (writer > 0) writers.emplace_back(topic, writer);
  }
  dds_qos_t* qos = dds_create_qos();
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  const dds_entity_t reader = wire.reader(Topic::status, qos);
  dds_delete_qos(qos);
  std::uint64_t heard = 0;
  const auto intrude_once = [&](std::uint64_t i) -> dds_return_t {
    lss_Status status;
    void* pointer = &status;
    dds_sample_info_t info;
    while (reader > 0 && dds_take(reader, &pointer, &info, 1, 1) > 0)
      if (info.valid_data && heard++ == 0) std::fputs("heard\n", stderr);
    for (const auto& [topic, entity] : writers) {
      const auto send = [&o, writer = entity](auto sample) {
        put_text(sample.vehicle_id, o.vehicle);
        dds_write(writer, &sample);
      };
      switch (topic) {
        case Topic::command:
        case Topic::stop: {
          constexpr std::uint16_t kWalk = 104;
          constexpr std::uint16_t kKinds[] = {kStart, kStop, kWalk, kSolve, kEmergencyStop};
          lss_Command sample = command(o.vehicle, o.source, i + 1, kKinds[i % std::size(kKinds)]);
          sample.lease_ms = 2000;
          send(sample);
          break;
        }
        case Topic::heartbeat: send(heartbeat(o.vehicle, o.source, i)); break;
        case Topic::ack: {
          lss_CommandAck sample{};
          put_text(sample.source, o.source);
          put_text(sample.text, "forged");
          sample.phase = lss_PHASE_COMPLETED;
          send(sample);
          break;
        }
        case Topic::status: {
          lss_Status sample{};
          put_text(sample.vehicle, "zebro");
          put_text(sample.authority, "intruder");
          send(sample);
          break;
        }
        case Topic::event: {
          lss_Event sample{};
          put_text(sample.text, "forged");
          sample.index = i;
          send(sample);
          break;
        }
        case Topic::telemetry: {
          lss_Timing sample{};
          sample.frame = i;
          send(sample);
          break;
        }
      }
    }
    return DDS_RETCODE_OK;
  };
  at_rate(o, counts, intrude_once);
  for (const auto& [topic, name] : kTopics) {
    double matched = -1;  // DDS Security did not make the writer
    for (const auto& [made, writer] : writers) {
      dds_publication_matched_status_t status{};
      if (made == topic && dds_get_publication_matched_status(writer, &status) == DDS_RETCODE_OK)
        matched = static_cast<double>(status.total_count);
    }
    counts.add(std::string("matched_") + name, matched);
  }
  counts.add("heard", static_cast<double>(heard));
  return 0;
}

}  // namespace attack
