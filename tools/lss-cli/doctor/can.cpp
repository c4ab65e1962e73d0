// A CAN interface: in the kernel, up, and on the bus.

#include <fmt/format.h>
#include <linux/can/netlink.h>
#include <linux/if.h>
#include <linux/if_arp.h>

#include <cstring>
#include <iterator>

#include "tools/lss-cli/doctor/checks.h"

namespace lss::cli::doctor {
namespace {

const char* state_name(std::uint32_t state) {
  static constexpr const char* kNames[] = {"error-active", "error-warning", "error-passive",
                                           "bus-off",      "stopped",       "sleeping"};
  return state < std::size(kNames) ? kNames[state] : "in an unknown state";
}

void judge_state(Finding& finding, const std::string& interface, const CanLink& link) {
  finding.found =
      fmt::format("{}: up, {}, {} bit/s", interface, state_name(*link.state), link.bitrate);
  switch (*link.state) {
    case CAN_STATE_ERROR_ACTIVE: finding.meaning = "the interface takes part in the bus"; return;
    case CAN_STATE_ERROR_WARNING:
    case CAN_STATE_ERROR_PASSIVE:
      finding.result = Result::warning;
      finding.meaning = "many frames go wrong";
      finding.remedy =
          "check bit rate, termination (60 ohm between the wires) and that another node is on";
      return;
    default:
      finding.result = Result::problem;
      finding.meaning = "the interface is off the bus: it sends and receives nothing";
      finding.remedy = fmt::format(
          "check bit rate, termination and wires; then: ip link set {} down; "
          "ip link set {} up type can restart-ms 100",
          interface, interface);
  }
}

}  // namespace

Finding check_can(const System& system, const std::string& interface) {
  Finding finding{.name = interface, .result = Result::problem};
  if (const int error = system.ask_can_socket(); error != 0) {
    finding.found = fmt::format("no raw CAN socket: {}", std::strerror(error));
    finding.meaning = "this kernel has no SocketCAN, or its module is not loaded";
    finding.remedy =
        "modprobe can_raw; in a machine without it, write path = \"udp://127.0.0.1:PORT\"";
    return finding;
  }
  const auto folder = system.sys / "class/net" / interface;
  const std::optional<std::int64_t> type = read_number(folder / "type");
  if (!type) {
    finding.found = fmt::format("there is no interface {}", interface);
    finding.meaning = "lssd receives and sends nothing on this bus";
    finding.remedy =
        interface.starts_with("v")
            ? fmt::format("ip link add {} type vcan; ip link set {} up", interface, interface)
            : "ip link shows those that are there; load the controller's driver";
    return finding;
  }
  if (*type != ARPHRD_CAN) {
    finding.found = fmt::format("{} is no CAN interface", interface);
    finding.meaning = "lssd refuses it";
    finding.remedy = "name a CAN interface in [[port]] path: ip link show type can";
    return finding;
  }
  if ((read_number(folder / "flags").value_or(0) & IFF_UP) == 0) {
    finding.found = fmt::format("{} is down", interface);
    finding.meaning = "lssd receives and sends nothing on this bus";
    finding.remedy =
        fmt::format("ip link set {} up{}", interface,
                    interface.starts_with("v")
                        ? ""
                        : " type can bitrate RATE restart-ms 100, at the RATE of the bus");
    return finding;
  }
  finding.result = Result::good;
  const std::optional<CanLink> link = system.ask_can_link(interface);
  if (link && link->state) {
    judge_state(finding, interface, *link);
  } else {
    finding.found = fmt::format("{}: up{}", interface,
                                link && link->kind == "vcan" ? ", virtual" : ", state unknown");
    finding.meaning = "a virtual bus has no bit rate and no errors";
    if (!link || link->kind != "vcan")
      finding.meaning = "its driver does not report the state of the bus";
  }
  if (finding.result == Result::good && link && link->state && link->restart_ms == 0) {
    finding.result = Result::note;
    finding.meaning += ", but after a bus-off it stays off";
    finding.remedy = fmt::format("ip link set {} down; ip link set {} up type can restart-ms 100",
                                 interface, interface);
  }
  return finding;
}

}  // namespace lss::cli::doctor
