// No attack: an emergency stop as a plain client that is known to the daemon sends it, again and
// again until it is completed; and stops of what answers nothing, with their times.

#include <algorithm>
#include <random>
#include <string>

#include "tests/attack/attack.h"

namespace attack {
namespace {

constexpr dds_duration_t kRepeat_ns = DDS_MSECS(100);
constexpr std::uint32_t kReaders = 2;  // a daemon, and an echo beside it
constexpr dds_duration_t kPoll_ns = DDS_MSECS(5);
constexpr std::int64_t kFrame_ns = 200'000'000;  // the longest: a stop is at any moment of a frame

}  // namespace

int stop(const Options& o, Counts& counts) {
  using Topic = Wire::Topic;
  Wire wire(o.domain);
  dds_qos_t* qos = dds_create_qos();
  dds_qset_reliability(qos, DDS_RELIABILITY_RELIABLE, DDS_SECS(1));
  dds_qset_history(qos, DDS_HISTORY_KEEP_ALL, 0);
  const dds_entity_t acks = wire.reader(Topic::ack, qos);
  dds_delete_qos(qos);
  const dds_entity_t commands = wire.writer(Topic::command);
  wait_for(wire.participant(), acks, DDS_SUBSCRIPTION_MATCHED_STATUS, "no daemon answers");

  const dds_entity_t waitset = dds_create_waitset(wire.participant());
  dds_set_status_mask(acks, DDS_DATA_AVAILABLE_STATUS);
  dds_waitset_attach(waitset, acks, 0);

  std::int64_t sent_ns = 0, accepted_ns = 0, executing_ns = 0, completed_ns = 0;
  // Dry runs until one is answered, so that the stop is not the first contact.
  std::uint64_t dry_runs = 0, tries = 0;
  bool known = false;
  int refused = 0, last_reason = 0;  // answers that were neither accepted, executing nor completed
  say_ready();
  const std::int64_t end_ns = now_ns() + static_cast<std::int64_t>(o.seconds * 1e9);
  for (std::int64_t due_ns = now_ns(); completed_ns == 0 && now_ns() < end_ns && !ended();) {
    if (now_ns() >= due_ns) {
      ++(known ? tries : dry_runs);
      const lss_Command sample =
          command(o.vehicle, o.source, dry_runs + tries, kEmergencyStop, known ? 0 : kDryRun);
      if (known && sent_ns == 0) sent_ns = now_ns();
      dds_write(commands, &sample);
      due_ns += kRepeat_ns;
    }
    dds_attach_t triggered;
    dds_waitset_wait(waitset, &triggered, 1, std::max<std::int64_t>(0, due_ns - now_ns()));
    lss_CommandAck ack;
    void* pointer = &ack;
    dds_sample_info_t info;
    while (dds_take(acks, &pointer, &info, 1, 1) > 0) {
      if (!info.valid_data || ack.kind != kEmergencyStop || o.source != ack.source) continue;
      if (ack.seq <= dry_runs) {
        if (!known) due_ns = now_ns() + std::random_device{}() % kFrame_ns;
        known = true;
        continue;
      }
      std::int64_t ignored = 0;
      std::int64_t& heard_ns = ack.phase == lss_PHASE_ACCEPTED    ? accepted_ns
                               : ack.phase == lss_PHASE_EXECUTING ? executing_ns
                               : ack.phase == lss_PHASE_COMPLETED ? completed_ns
                                                                  : ignored;
      if (&heard_ns == &ignored) {
        ++refused;
        last_reason = ack.reason;
      }
      if (heard_ns == 0) heard_ns = now_ns();
    }
  }
  counts.add("tries", static_cast<double>(tries));
  counts.add("refused", refused);
  counts.add("reason", last_reason);
  counts.add_ns("sent_ns", sent_ns);
  counts.add_ns("accepted_ns", accepted_ns);
  counts.add_ns("executing_ns", executing_ns);
  counts.add_ns("completed_ns", completed_ns);
  return completed_ns != 0 ? 0 : 1;
}

int stops(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t commands = wire.writer(Wire::Topic::command);
  for (dds_publication_matched_status_t all{}; all.current_count < kReaders && !ended();) {
    dds_get_publication_matched_status(commands, &all);
    dds_sleepfor(kPoll_ns);
  }
  at_rate(o, counts, [&](std::uint64_t i) {
    const lss_Command sample = command(o.vehicle, o.source, i + 1, kEmergencyStop);
    counts.add_ns("stop_" + std::to_string(i + 1) + "_ns", now_ns());
    return dds_write(commands, &sample);
  });
  dds_wait_for_acks(commands, DDS_SECS(1));
  return 0;
}

}  // namespace attack
