// What DDS needs: interfaces, socket buffers, its own configuration, and RouDi for shared memory.

#include <fmt/format.h>
#include <linux/if.h>

#include <cstdlib>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

constexpr std::int64_t kCycloneBuffer = 1'048'576;  // the request of Cyclone 0.10

}  // namespace

Finding check_roudi(const System& system, const config::Config* config) {
  const bool wanted = config == nullptr || config->shared_memory;
  Finding finding{
      .name = "roudi", .found = "RouDi runs", .meaning = "telemetry goes by shared memory"};
  if (system.find_roudi()) {
    if (wanted) return finding;
    finding.result = Result::note;
    finding.meaning = "nobody needs it: dds.shared_memory is false";
    return finding;
  }
  const std::vector<Process> running = processes_named(system, "iox-roudi");
  if (!wanted) {
    finding.found = "RouDi is not needed";
    finding.meaning = "dds.shared_memory is false: telemetry goes by the network";
  } else if (!running.empty()) {
    finding.result = Result::note;
    finding.found = fmt::format("{} runs, but cannot be reached from here", spoken(running));
    finding.meaning =
        "the units give it a /tmp of their own, where lssd@ reaches it; or it serves "
        "another group";
  } else {
    finding.result = Result::warning;
    finding.found = "RouDi does not run";
    finding.meaning = "nothing is lost: telemetry goes by the network, which costs more";
    finding.remedy =
        "systemctl start iox-roudi (by hand: iox-roudi -c /etc/lss/roudi.toml), and lssd "
        "after it; or dds.shared_memory = false";
  }
  return finding;
}

Finding check_dds_uri() {
  const char* uri = std::getenv("CYCLONEDDS_URI");
  if (uri == nullptr || *uri == '\0') {
    return {.name = "dds_uri",
            .found = "CYCLONEDDS_URI is not set",
            .meaning = "DDS uses our own configuration: the interfaces of dds.interfaces"};
  }
  return {.name = "dds_uri",
          .result = Result::note,
          .found = fmt::format("CYCLONEDDS_URI={}", uri),
          .meaning =
              "it is read after our own configuration and wins, for this user's programs; the "
              "interfaces that it names are added"};
}

Finding check_interface(const System& system, const std::string& interface) {
  Finding finding{.name = "dds_interface/" + interface, .result = Result::problem};
  const std::optional<std::int64_t> flags =
      read_number(system.sys / "class/net" / interface / "flags");
  if (!flags) {
    finding.found = fmt::format("there is no interface {}", interface);
    finding.meaning =
        "lssd starts without it, and starts again when it is up and the vehicle is Idle";
    finding.remedy = "name one that ip link shows in dds.interfaces";
    return finding;
  }
  if ((*flags & IFF_UP) == 0) {
    finding.found = interface + " is down";
    finding.meaning = "no participant is reachable through it; lssd starts without it";
    finding.remedy = fmt::format("ip link set {} up", interface);
    return finding;
  }
  const bool loopback = (*flags & IFF_LOOPBACK) != 0;
  const bool multicast = (*flags & IFF_MULTICAST) != 0;
  finding.result = loopback ? Result::good : Result::note;
  finding.found =
      fmt::format("{} is up, {} the multicast flag", interface, multicast ? "with" : "without");
  finding.meaning =
      "nothing leaves this machine; DDS is configured for multicast on loopback, "
      "regardless of its flag";
  if (loopback) return finding;
  finding.meaning =
      "every host on this network can command the vehicle, unless dds.security.enclave is set: "
      "else DDS neither authenticates nor encrypts";
  if (!multicast) {
    finding.result = Result::warning;
    finding.meaning = "programs find one another by multicast, and here there is none";
    finding.remedy = fmt::format("ip link set {} multicast on", interface);
  }
  return finding;
}

Finding check_buffers(const System& system) {
  const std::optional<std::int64_t> bytes = read_number(system.proc / "sys/net/core/rmem_max");
  Finding finding{.name = "dds_buffers",
                  .found = fmt::format("net.core.rmem_max {}", bytes.value_or(-1)),
                  .meaning = "DDS gets the receive buffer that it asks for"};
  if (!bytes) {
    finding.found = "net.core.rmem_max is hidden";
    finding.meaning = "usual in a container: its host decides";
  }
  if (!bytes || *bytes >= kCycloneBuffer) return finding;
  finding.result = Result::note;
  finding.meaning =
      "less than the 1 MB that DDS asks for; enough for commands and status, while bursts of "
      "telemetry may be lost in slow subscribers";
  finding.remedy = "sysctl net.core.rmem_max=1048576, and in /etc/sysctl.d/ for every boot";
  return finding;
}

}  // namespace lss::cli::doctor
