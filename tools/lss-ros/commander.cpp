#include "tools/lss-ros/commander.h"

namespace lss::ros {

using cli::checked;

Commander::Commander(const dds::Participant& participant, std::string vehicle_id,
                     std::uint32_t lease_ms)
    : participant_(participant),
      vehicle_id_(std::move(vehicle_id)),
      lease_ms_(lease_ms),
      command_writer_(
          checked(dds::create_writer(participant.get(), dds::common_topic(dds::Kind::command)))),
      heartbeat_writer_(
          checked(dds::create_writer(participant.get(), dds::common_topic(dds::Kind::heartbeat)))),
      ack_reader_(checked(
          dds::create_reader(participant.get(), dds::common_topic(dds::Kind::command_ack)))) {}

std::uint64_t Commander::send(const cli::Invocation& command, std::string_view source,
                              std::uint16_t flags) {
  const lss_Command sample =
      cli::to_dds(command, {vehicle_id_, source, sequence_.next(), flags, lease_ms_});
  dds_write(command_writer_.get(), &sample);
  return sample.seq;
}

void Commander::heartbeat(std::string_view source) {
  const lss_Heartbeat sample = cli::heartbeat_to_dds(vehicle_id_, source, ++heartbeats_);
  dds_write(heartbeat_writer_.get(), &sample);
}

std::optional<lss_CommandAck> Commander::next_ack() {
  lss_CommandAck sample{};
  void* samples[1] = {&sample};
  dds_sample_info_t info{};
  while (dds_take(ack_reader_.get(), samples, &info, 1, 1) == 1) {
    if (info.valid_data && cli::text(sample.vehicle_id) == vehicle_id_ &&
        participant_.is_by_vehicle(vehicle_id_, ack_reader_.get(), info))
      return sample;
  }
  return std::nullopt;
}

}  // namespace lss::ros
