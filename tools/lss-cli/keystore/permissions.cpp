#include "tools/lss-cli/keystore/permissions.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <vector>

namespace lss::cli {
namespace {

constexpr const char* kHead =
    "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
    "<dds xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\"\n"
    "     xsi:noNamespaceSchemaLocation=\"http://www.omg.org/spec/DDS-SECURITY/20170901/"
    "omg_shared_ca_{}.xsd\">\n";
constexpr const char* kDomains =
    "<domains><id_range><min>0</min><max>230</max></id_range></domains>";

// Nobody without a certificate; all is encrypted, and only who may write or read a topic can.
constexpr const char* kGovernance = R"(  <domain_access_rules>
    <domain_rule>
      {}
      <allow_unauthenticated_participants>false</allow_unauthenticated_participants>
      <enable_join_access_control>true</enable_join_access_control>
      <discovery_protection_kind>ENCRYPT</discovery_protection_kind>
      <liveliness_protection_kind>ENCRYPT</liveliness_protection_kind>
      <rtps_protection_kind>SIGN</rtps_protection_kind>
      <topic_access_rules>
        <topic_rule>
          <topic_expression>*</topic_expression>
          <enable_discovery_protection>true</enable_discovery_protection>
          <enable_liveliness_protection>true</enable_liveliness_protection>
          <enable_read_access_control>true</enable_read_access_control>
          <enable_write_access_control>true</enable_write_access_control>
          <metadata_protection_kind>ENCRYPT</metadata_protection_kind>
          <data_protection_kind>NONE</data_protection_kind>
        </topic_rule>
      </topic_access_rules>
    </domain_rule>
  </domain_access_rules>
</dds>
)";

constexpr const char* kPermissions = R"(  <permissions>
    <grant name="{role}">
      <subject_name>CN={name}</subject_name>
      <validity>
        <not_before>1970-01-02T00:00:00</not_before>
        <not_after>{until:%Y-%m-%dT%H:%M:%S}</not_after>
      </validity>
      <allow_rule>
        {domains}
{topics}      </allow_rule>
      <default>DENY</default>
    </grant>
  </permissions>
</dds>
)";

// From the daemon (docs/dds.md).
const std::vector<std::string> kReports = {
    "lss/command_ack", "lss/heartbeat",  "lss/status", "lss/event",      "lss/timing_statistics",
    "lss/parameters",  "lss/dictionary", "lss/timing", "lss/telemetry/*"};

// Topics, services and node graph of ROS 2.
const std::vector<std::string> kRos = {"rt/*", "rq/*", "rr/*", "ros_discovery_info"};

struct Topics {
  std::vector<std::string> publish, subscribe;
};

std::vector<std::string> both(std::vector<std::string> a, const std::vector<std::string>& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

Topics topics_of(DdsRole role) {
  const std::vector<std::string> all = {"lss/command", "lss/heartbeat", "lss/stop"};
  const std::vector<std::string> seen = both(kReports, {"lss/command", "lss/stop"});  // to record
  switch (role) {
    case DdsRole::look: return {{}, seen};
    case DdsRole::stop: return {{"lss/stop"}, seen};
    case DdsRole::command: return {all, seen};
    case DdsRole::vehicle: return {kReports, all};
    case DdsRole::ros: return {kRos, kRos};
    case DdsRole::bridge: return {both(all, kRos), both(seen, kRos)};
  }
  return {};
}

}  // namespace

std::string governance_text() {
  return fmt::format(fmt::runtime(kHead), "governance") +
         fmt::format(fmt::runtime(kGovernance), kDomains);
}

std::string permissions_text(const std::string& name, DdsRole role, std::time_t until_s) {
  const Topics topics = topics_of(role);
  std::string rules;
  const auto add = [&](const char* what, const std::vector<std::string>& list) {
    if (list.empty()) return;
    rules += fmt::format("        <{}><topics>\n", what);
    for (const std::string& topic : list)
      rules += fmt::format("          <topic>{}</topic>\n", topic);
    rules += fmt::format("        </topics></{}>\n", what);
  };
  add("publish", topics.publish);
  add("subscribe", topics.subscribe);
  return fmt::format(fmt::runtime(kHead), "permissions") +
         fmt::format(fmt::runtime(kPermissions),
                     fmt::arg("role", kDdsRoles[static_cast<std::size_t>(role)]),
                     fmt::arg("name", name), fmt::arg("until", fmt::gmtime(until_s)),
                     fmt::arg("domains", kDomains), fmt::arg("topics", rules));
}

std::string role_in(const std::string& permissions) {
  for (const char* role : kDdsRoles) {
    if (permissions.find(fmt::format("<grant name=\"{}\">", role)) != std::string::npos)
      return role;
  }
  return "other";
}

}  // namespace lss::cli
