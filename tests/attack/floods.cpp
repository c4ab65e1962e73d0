// Modes that only send.

#include <algorithm>
#include <limits>
#include <random>

#include "tests/attack/attack.h"

namespace attack {
namespace {

using Topic = Wire::Topic;

constexpr int kNames = 32;

dds_return_t write(dds_entity_t writer, const lss_Command& sample) {
  return dds_write(writer, &sample);
}
dds_return_t write(dds_entity_t writer, const lss_Heartbeat& sample) {
  return dds_write(writer, &sample);
}

std::string numbered(const char* prefix, std::uint64_t number) {
  return prefix + std::to_string(number);
}

}  // namespace

int flood_heartbeats(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::heartbeat);
  at_rate(o, counts,
          [&](std::uint64_t i) { return write(writer, heartbeat(o.vehicle, o.source, i + 1)); });
  return 0;
}

// None of it moves or stops a vehicle: valid messages are `data` or dry runs.
int flood_commands(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::command);
  std::mt19937_64 random(1);
  at_rate(o, counts, [&](std::uint64_t i) {
    const bool as_pilot = i % 2 == 0;
    const std::string source = as_pilot ? o.source : numbered("any-", random());
    const std::uint64_t seq = random() % 4 == 0 ? random() : i + 1;
    lss_Command sample = command(o.vehicle, source, seq, kData);
    switch (random() % 10) {
      case 0:
      case 1: break;
      case 2:
        sample.kind = kStop;
        sample.flags = kDryRun;
        break;
      case 3:
        sample.kind = kSolve;
        sample.flags = kDryRun;
        break;
      case 4: sample.kind = static_cast<std::uint16_t>(400 + random() % 60'000); break;
      case 5:
        sample.kind = kStart;
        sample.parameter[0] = std::numeric_limits<double>::quiet_NaN();
        break;
      case 6:
        sample.kind = kStart;
        sample.lease_ms = 0xFFFFFFFF;
        sample.parameter[7] = 1e300;
        std::fill(std::begin(sample.name), std::end(sample.name), '\xFF');
        break;
      case 7:
        sample.flags = 0xFFFE;
        sample.parameter[3] = std::numeric_limits<double>::infinity();
        break;
      case 8: std::fill(std::begin(sample.source), std::end(sample.source), '\xFF'); break;
      default: sample.source[0] = '\0';
    }
    return write(writer, sample);
  });
  return 0;
}

int flood_estop_dry_run(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::command);
  at_rate(o, counts, [&](std::uint64_t i) {
    const std::string source = i % 2 == 0 ? o.source : numbered("dry-", i % 64);
    return write(writer, command(o.vehicle, source, i + 1, kEmergencyStop, kDryRun));
  });
  return 0;
}

int invent_sources(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t beats = wire.writer(Topic::heartbeat), commands = wire.writer(Topic::command);
  at_rate(o, counts, [&](std::uint64_t i) {
    const std::string source = numbered("new-", i);
    const std::string vehicle = i % 2 == 0 ? o.vehicle : numbered("v", i % 100'000'000'000'000);
    if (i % 4 < 2) return write(beats, heartbeat(vehicle, source, 1));
    return write(commands, command(vehicle, source, 1, kData));
  });
  return 0;
}

int max_sequence(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::command);
  at_rate(o, counts, [&](std::uint64_t) {
    return write(writer,
                 command(o.vehicle, o.source, std::numeric_limits<std::uint64_t>::max(), kData));
  });
  return 0;
}

int many_names(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::command);
  Options each = o;
  each.rate = kNames;  // each of them once a second
  at_rate(each, counts, [&](std::uint64_t i) {
    return write(writer, command(o.vehicle, numbered("invented-", i % kNames), i + 1, kData));
  });
  return 0;
}

int twin(const Options& o, Counts& counts) {
  Wire wire(o.domain);
  const dds_entity_t writer = wire.writer(Topic::heartbeat);
  at_rate(o, counts, [&](std::uint64_t i) {
    lss_Heartbeat sample = heartbeat(o.vehicle, kDaemonSource, i + 1);
    sample.state = lss_STATE_OPERATIONAL;
    sample.instance.boot = 0x7717;
    sample.instance.started_utc_ns = 1'700'000'000'000'000'000;
    sample.instance.pid = 4242;
    put_text(sample.instance.host, "elsewhere");
    return write(writer, sample);
  });
  return 0;
}

}  // namespace attack
