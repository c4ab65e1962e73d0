// lss-attack MODE DOMAIN VEHICLE_ID [--source NAME] [--rate N] [--seconds S]
//
// Says "ready" on the error output when it begins, and what it did as JSON at its end, which is
// after the seconds or at SIGTERM. `stop`: for how long at most.

#include <cstdlib>
#include <cstring>

#include "tests/attack/attack.h"

namespace {

using attack::Counts;
using attack::Options;

struct Mode {
  const char* name;
  const char* what;
  int (*run)(const Options&, Counts&);
};
constexpr Mode kModes[] = {
    {"flood-heartbeats", "heartbeats in the name of --source", attack::flood_heartbeats},
    {"flood-commands", "valid and invalid commands, in that name and in others",
     attack::flood_commands},
    {"flood-estop-dry-run", "emergency stops that are none", attack::flood_estop_dry_run},
    {"invent-sources", "every message has a source of its own, every second a vehicle_id",
     attack::invent_sources},
    {"max-sequence", "`data` in the name of --source with the largest number there is",
     attack::max_sequence},
    {"many-names", "32 invented names, each `data` once a second", attack::many_names},
    {"replay", "commands, except stops, and acknowledgements of others again", attack::replay},
    {"twin", "heartbeats of another daemon of this vehicle_id", attack::twin},
    {"deaf-reader", "reliable readers that never take", attack::deaf_reader},
    {"intrude", "writes every topic, as far as DDS Security lets it, and reads the status",
     attack::intrude},
    {"watch", "no attack: a line of JSON for each lss/status", attack::watch},
    {"stop", "no attack: one emergency stop, sent every 0.1 s until it is completed", attack::stop},
    {"stops", "no attack: --rate emergency stops a second, and when each was sent", attack::stops},
};

int usage() {
  std::fprintf(
      stderr,
      "usage: lss-attack MODE DOMAIN VEHICLE_ID [--source NAME] [--rate N] [--seconds S]\n");
  for (const Mode& mode : kModes) std::fprintf(stderr, "  %-20s %s\n", mode.name, mode.what);
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4 || argc % 2 != 0) return usage();
  Options options;
  options.domain = static_cast<dds_domainid_t>(std::atoi(argv[2]));
  options.vehicle = argv[3];
  for (int i = 4; i < argc; i += 2) {
    if (std::strcmp(argv[i], "--source") == 0) {
      options.source = argv[i + 1];
    } else if (std::strcmp(argv[i], "--rate") == 0) {
      options.rate = std::atof(argv[i + 1]);
    } else if (std::strcmp(argv[i], "--seconds") == 0) {
      options.seconds = std::atof(argv[i + 1]);
    } else {
      return usage();
    }
  }
  if (!(options.rate > 0 && options.rate <= 1e6) || !(options.seconds > 0)) return usage();
  attack::ended();  // receives signals from here on
  for (const Mode& mode : kModes) {
    if (std::strcmp(mode.name, argv[1]) != 0) continue;
    Counts counts(mode.name);
    const int code = mode.run(options, counts);
    counts.put_out();
    return code;
  }
  return usage();
}
