// lss-ros: a vehicle as a ROS 2 node. See docs/ros2.md.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <memory>
#include <optional>
#include <utility>

#include "idl/refusal.h"
#include "tools/lss-cli/session/enclave_watch.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-ros/bridge.h"

namespace {

using namespace lss;
using namespace lss::ros;

struct Wanted {
  cli::Options link;
  BridgeOptions bridge;
  std::optional<int> ros_domain;
};

void add_options(CLI::App& app, Wanted& wanted) {
  app.add_option("--domain", wanted.link.domain, "DDS domain of the vehicle")
      ->envname("LSS_DOMAIN")
      ->check(CLI::Range(0, 230))
      ->capture_default_str();
  app.add_option("--vehicle", wanted.link.vehicle_id, "id of the vehicle; without it the only one")
      ->envname("LSS_VEHICLE");
  app.add_option("--enclave", wanted.link.enclave,
                 "folder of certificates for DDS Security (lss-cli keystore), on both domains")
      ->envname("LSS_ENCLAVE");
  app.add_option("--ros-domain", wanted.ros_domain,
                 "DDS domain of ROS; without it that of the vehicle")
      ->envname("ROS_DOMAIN_ID")
      ->check(CLI::Range(0, 230));
  app.add_option("--interface", wanted.bridge.interfaces,
                 "network interface to ROS, may be repeated; without it this machine only");
  const std::map<std::string, Distro> distros = {{"humble", Distro::humble},
                                                 {"iron", Distro::iron},
                                                 {"jazzy", Distro::iron},
                                                 {"kilted", Distro::iron}};
  app.add_option("--distro", wanted.bridge.distro,
                 "of the nodes on the domain: humble, iron, jazzy or kilted")
      ->transform(CLI::CheckedTransformer(distros).description(""))
      ->transform(CLI::IsMember(distros).description(""))  // the last one comes first
      ->default_str("iron");
  app.add_flag("--stamped", wanted.bridge.stamped, "cmd_vel is a TwistStamped, not a Twist");
  app.add_flag("--cmd-vel-starts", wanted.bridge.cmd_vel_starts,
               "cmd_vel starts the vehicle; without it, it is refused outside Operational");
  app.add_option("--lease-ms", wanted.bridge.lease_ms,
                 "a vehicle stops safely this long after the last cmd_vel")
      ->check(CLI::Range(100, 60000))
      ->capture_default_str();
}

using Participant = std::shared_ptr<const dds::Participant>;

Participant participant(const dds::ParticipantParameters& parameters) {
  auto created = dds::Participant::create(parameters);
  if (!created && created.error().cure == Cure::change)
    throw cli::Failure(cli::ExitCode::usage, created.error().text);
  return std::make_shared<const dds::Participant>(cli::checked(std::move(created)));
}

// User data of a participant of ROS 2.
std::string ros_enclave(const dds::Participant& participant) {
  std::string name = participant.enclave() ? participant.enclave()->name : "/";
  if (!name.starts_with('/')) name.insert(0, "/");
  return "enclave=" + name + ";";
}

// True: Ctrl-C.
bool serve(const Wanted& wanted, dds_entity_t ros, const Participant& ours,
           cli::EnclaveWatch& enclave) {
  cli::Link link(wanted.link, ours);
  for (bool said = false;; said = true) {
    enclave.look();
    try {
      link.find_vehicle();
      break;
    } catch (const cli::Failure& e) {
      if (e.code() != cli::ExitCode::unreachable && e.code() != cli::ExitCode::unknown_name) throw;
      if (!said) fmt::print(stderr, "lss-ros: {}; waiting for it\n", e.what());
    }
  }
  Bridge bridge(link, ros, *ours, wanted.bridge);
  fmt::print("/{} on ROS domain {}\n", ros_name(cli::text(link.status().vehicle_id)),
             wanted.bridge.ros_domain);
  std::fflush(stdout);
  return bridge.run([&] { enclave.look(); });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"A vehicle as a ROS 2 node. Topics and services: docs/ros2.md"};
  app.set_version_flag("--version", "lss-ros " LSS_VERSION);
  Wanted wanted;
  add_options(app, wanted);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    return app.exit(e) == 0 ? 0 : static_cast<int>(cli::ExitCode::usage);
  }
  wanted.bridge.ros_domain = wanted.ros_domain.value_or(wanted.link.domain);
  wanted.link.lease_ms = wanted.bridge.lease_ms;
  try {
    // The first participant configures its domain in this process.
    const Participant ros = participant({.domain = wanted.bridge.ros_domain,
                                         .interfaces = wanted.bridge.interfaces,
                                         .enclave = wanted.link.enclave});
    cli::EnclaveWatch enclave("lss-ros", *ros);
    const std::string user_data = ros_enclave(*ros);
    dds_qos_t* qos = dds_create_qos();
    dds_qset_userdata(qos, user_data.data(), user_data.size());
    dds_set_qos(ros->get(), qos);
    dds_delete_qos(qos);
    // With DDS Security one participant for a domain: Cyclone 0.10.2 crashes in a process with
    // several when one of Fast DDS joins.
    const bool one = !wanted.link.enclave.empty() && wanted.bridge.ros_domain == wanted.link.domain;
    const Participant ours = one ? ros
                                 : participant({.domain = wanted.link.domain,
                                                .short_lived = true,
                                                .enclave = wanted.link.enclave});
    while (!serve(wanted, ros->get(), ours, enclave)) {
    }
  } catch (const cli::Interrupted&) {
    return 0;
  } catch (const cli::Failure& e) {
    fmt::print(stderr, "lss-ros: {}{}{}\n", e.what(), e.advice().empty() ? "" : "; ", e.advice());
    return static_cast<int>(e.code());
  }
  return 0;
}
