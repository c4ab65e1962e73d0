// Modes that listen: replay of received messages, and readers that never take samples.

#include <algorithm>
#include <cstdlib>

#include "tests/attack/attack.h"

namespace attack {
namespace {

using Topic = Wire::Topic;

constexpr std::size_t kRecorded = 4096;  // of each; then the oldest are kept
constexpr int kDeafReaders = 4;          // of each topic

dds_qos_t* reliable() {
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  return qos;
}

template <class T>
class Recording {
 public:
  Recording(dds_entity_t reader, dds_entity_t writer) : reader_(reader), writer_(writer) {}

  void take() {
    T sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    while (dds_take(reader_, &pointer, &info, 1, 1) > 0) {
      // A stop that is sent again stops, as from anyone: that is no attack on the daemon.
      if (!info.valid_data || sample.kind == kStop || sample.kind == kEmergencyStop) continue;
      if (heard_.size() < kRecorded) heard_.push_back(sample);
    }
  }
  dds_return_t again(std::uint64_t i) {
    return heard_.empty() ? DDS_RETCODE_NO_DATA : dds_write(writer_, &heard_[i % heard_.size()]);
  }
  std::size_t size() const { return heard_.size(); }

 private:
  dds_entity_t reader_, writer_;
  std::vector<T> heard_;
};

}  // namespace

int replay(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  dds_qos_t* qos = reliable();
  dds_qset_history(qos, DDS_HISTORY_KEEP_LAST, 1024);
  dds_qset_ignorelocal(qos, DDS_IGNORELOCAL_PARTICIPANT);
  Recording<lss_Command> commands(wire.reader(Topic::command, qos), wire.writer(Topic::command));
  Recording<lss_CommandAck> acks(wire.reader(Topic::ack, qos), wire.writer(Topic::ack, false));
  dds_delete_qos(qos);
  at_rate(o, counts, [&](std::uint64_t i) {
    commands.take();
    acks.take();
    return i % 2 == 0 ? commands.again(i / 2) : acks.again(i / 2);
  });
  counts.add("commands", static_cast<double>(commands.size()));
  counts.add("acks", static_cast<double>(acks.size()));
  return 0;
}

// Reliable readers that have room for one sample and never take it: a writer that waits for them
// waits for ever. So does Cyclone's own thread that receives, as soon as a sample does not fit, so
// that those which were not matched by then never are.
int deaf_reader(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  std::vector<dds_entity_t> readers;
  for (const Topic topic : {Topic::ack, Topic::status, Topic::event}) {
    dds_qos_t* qos = reliable();
    dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
    dds_qset_resource_limits(qos, 1, 1, 1);
    if (topic != Topic::ack) dds_qset_durability(qos, DDS_DURABILITY_TRANSIENT_LOCAL);
    for (int i = 0; i < kDeafReaders; ++i) readers.push_back(wire.reader(topic, qos));
    dds_delete_qos(qos);
  }
  const auto matched = [&] {
    return std::ranges::count_if(readers, [](dds_entity_t reader) {
      dds_subscription_matched_status_t status{};
      return dds_get_subscription_matched_status(reader, &status) == DDS_RETCODE_OK &&
             status.total_count > 0;
    });
  };
  const std::int64_t begin_ns = now_ns();
  while (matched() == 0 && now_ns() - begin_ns < DDS_SECS(20)) dds_sleepfor(DDS_MSECS(10));
  say_ready();
  const std::int64_t end_ns = now_ns() + static_cast<std::int64_t>(o.seconds * 1e9);
  while (!ended() && now_ns() < end_ns) dds_sleepfor(DDS_MSECS(20));
  counts.add("readers", static_cast<double>(matched()));
  counts.put_out();
  std::_Exit(matched() > 0 ? 0 : 1);  // to delete them would wait for that thread
}

int watch(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  dds_qos_t* qos = reliable();
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);  // of all daemons of that name
  const dds_entity_t reader = wire.reader(Topic::status, qos);
  dds_delete_qos(qos);
  say_ready();
  int heard = 0;
  const std::int64_t end_ns = now_ns() + static_cast<std::int64_t>(o.seconds * 1e9);
  while (!ended() && now_ns() < end_ns) {
    static lss_Status sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
      if (!info.valid_data || o.vehicle != sample.vehicle_id) continue;
      ++heard;
      std::string faults;
      for (std::size_t i = 0; i < std::min<std::size_t>(sample.fault_count, 16); ++i)
        faults += (i == 0 ? "" : ", ") + std::to_string(sample.faults[i].id);
      std::printf(
          "{\"time_ns\": %lld, \"pid\": %d, \"state\": %d, \"mode\": \"%.16s\", "
          "\"faults\": [%s], \"frames\": %llu, \"overruns\": %llu, \"rejected\": %llu, "
          "\"dropped\": %llu}\n",
          static_cast<long long>(now_ns()), static_cast<int>(sample.instance.pid),
          static_cast<int>(sample.state), sample.mode_name, faults.c_str(),
          static_cast<unsigned long long>(sample.frame_index),
          static_cast<unsigned long long>(sample.overruns),
          static_cast<unsigned long long>(sample.commands_rejected),
          static_cast<unsigned long long>(sample.telemetry_dropped));
      std::fflush(stdout);
    }
    dds_sleepfor(DDS_MSECS(20));
  }
  counts.add("heard", heard);
  return 0;
}

}  // namespace attack
