// Makes a simulated Lunar Zebro walk for 15 s, by DDS (docs/tutorial-client.md).

#include <chrono>
#include <cstdlib>
#include <cstring>
#include <iostream>
#include <string>
#include <thread>

#include "dds/dds.h"
#include "lss.h"

namespace {

constexpr const char* kVehicle = "zebro-1";
constexpr const char* kSource = "tutorial";
constexpr std::uint16_t kStart = 1, kStop = 2;

template <std::size_t N>
void put(char (&field)[N], const char* text) {
  std::strncpy(field, text, N - 1);
}

struct Client {
  dds_entity_t participant, commands, heartbeats, acks;
  unsigned long long seq = 0, beats = 0;

  explicit Client(dds_domainid_t domain)
      : participant(dds_create_participant(domain, nullptr, nullptr)) {
    dds_qos_t* reliable = dds_create_qos();
    dds_qset_reliability(reliable, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
    commands =
        dds_create_writer(participant, topic(&lss_Command_desc, "lss/command"), reliable, nullptr);
    heartbeats = dds_create_writer(participant, topic(&lss_Heartbeat_desc, "lss/heartbeat"),
                                   nullptr, nullptr);
    acks = dds_create_reader(participant, topic(&lss_CommandAck_desc, "lss/command_ack"), reliable,
                             nullptr);
    dds_delete_qos(reliable);
    // A command that is sent before both ends are matched is lost.
    dds_publication_matched_status_t ends{};
    for (int i = 0; i < 1000 && ends.current_count == 0; ++i) {
      dds_get_publication_matched_status(commands, &ends);
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }
  dds_entity_t topic(const dds_topic_descriptor_t* type, const char* name) const {
    return dds_create_topic(participant, type, name, nullptr, nullptr);
  }
  void beat() {
    lss_Heartbeat heartbeat{};
    put(heartbeat.vehicle_id, kVehicle);
    put(heartbeat.source, kSource);
    heartbeat.counter = ++beats;
    dds_write(heartbeats, &heartbeat);
  }
  void stay(std::chrono::seconds time) {
    const auto end = std::chrono::steady_clock::now() + time;
    while (std::chrono::steady_clock::now() < end) {
      beat();
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
  }
  // Sends a command and waits until it ended, with heartbeats. True: completed.
  bool run(std::uint16_t kind, std::initializer_list<double> parameters,
           std::chrono::seconds limit) {
    lss_Command command{};
    put(command.vehicle_id, kVehicle);
    put(command.source, kSource);
    command.seq = ++seq;
    command.kind = kind;
    command.lease_ms = 1000;
    std::size_t i = 0;
    for (const double value : parameters) command.parameter[i++] = value;
    dds_write(commands, &command);
    const auto end = std::chrono::steady_clock::now() + limit;
    while (std::chrono::steady_clock::now() < end) {
      beat();
      lss_CommandAck ack{};
      void* samples[1] = {&ack};
      dds_sample_info_t info{};
      while (dds_take(acks, samples, &info, 1, 1) == 1) {
        if (!info.valid_data || std::string(ack.source) != kSource || ack.seq != seq) continue;
        std::cout << ack.text << std::endl;
        if (ack.phase == lss_PHASE_COMPLETED) return true;
        if (ack.phase == lss_PHASE_REJECTED || ack.phase == lss_PHASE_FAILED) return false;
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(200));
    }
    std::cout << "no end within " << limit.count() << " s" << std::endl;
    return false;
  }
};

}  // namespace

int main() {
  const char* domain = std::getenv("LSS_DOMAIN");
  Client client(domain != nullptr ? static_cast<dds_domainid_t>(std::atoi(domain)) : 0);
  // Start, then walk (2), forward (1), heading 0, at high speed (3). It is completed when the
  // vehicle walks.
  if (!client.run(kStart, {2, 1, 0, 3}, std::chrono::seconds(60))) return 1;
  client.stay(std::chrono::seconds(15));
  return client.run(kStop, {1}, std::chrono::seconds(60)) ? 0 : 1;
}
