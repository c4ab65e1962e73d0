// keystore: certificates and permissions for DDS Security. See docs/security.md.

#include <fmt/format.h>

#include "tools/lss-cli/keystore/keystore.h"
#include "tools/lss-cli/verbs/verbs.h"

namespace lss::cli {
namespace {

struct Words {
  std::string what, folder, name, role, certificate;
  int days = 3650;
};

ExitCode list(Context& context, const std::string& folder) {
  nlohmann::json document = {{"enclaves", nlohmann::json::array()}};
  std::string text;
  for (const KeystoreEntry& one : list_keystore(folder)) {
    document["enclaves"].push_back({{"name", one.name},
                                    {"role", one.role},
                                    {"not_after", one.not_after},
                                    {"fault", one.fault}});
    text += one.fault.empty()
                ? fmt::format("{:24} {:8} valid until {}\n", one.name, one.role, one.not_after)
                : fmt::format("{:24} unusable: {}\n", one.name, one.fault);
  }
  context.output.print(text);
  context.output.document(std::move(document));
  return ExitCode::completed;
}

ExitCode run(Context& context, const Words& words) {
  if (words.what == "list") return list(context, words.folder);
  if (words.what == "create") {
    create_keystore(words.folder, words.days);
    context.output.print(
        fmt::format("{0} is made; keep {0}/private on a machine that is no vehicle's\n"
                    "next: lss-cli keystore add {0} NAME --role vehicle\n",
                    words.folder));
    return ExitCode::completed;
  }
  if (words.what == "revoke") {
    revoke_enclave(words.folder, words.name, words.certificate);
    context.output.print(fmt::format(
        "{1} is revoked\n"
        "next: copy {0}/enclaves/NAME/crl.pem to the computer of each NAME, and start its programs "
        "again: until then they accept it\n",
        words.folder, words.name.empty() ? words.certificate : words.name));
    return ExitCode::completed;
  }
  const auto role = std::ranges::find(kDdsRoles, words.role);
  add_enclave(words.folder, words.name, static_cast<DdsRole>(role - std::begin(kDdsRoles)),
              words.days);
  context.output.print(
      fmt::format("{0}/enclaves/{1} is made; copy this folder, and nothing else, "
                  "to the computer of {1}\n",
                  words.folder, words.name));
  return ExitCode::completed;
}

// Before any action.
void check(const Words& words) {
  const bool adds = words.what == "add", revokes = words.what == "revoke";
  if (adds && (words.name.empty() || words.role.empty()))
    throw Failure(ExitCode::usage,
                  "add needs a name and --role look, stop, command, vehicle, ros or bridge");
  if (revokes && words.name.empty() == words.certificate.empty())
    throw Failure(ExitCode::usage, "revoke needs a name, or --certificate FILE");
  if (!adds && !revokes && !words.name.empty())
    throw Failure(ExitCode::usage,
                  words.what + " takes a folder only; a name is for add and revoke");
  if (!adds && !words.role.empty()) throw Failure(ExitCode::usage, "--role is for add");
  if (!revokes && !words.certificate.empty())
    throw Failure(ExitCode::usage, "--certificate is for revoke");
}

}  // namespace

void add_keystore_verb(Grammar& grammar) {
  if (grammar.scope() != Grammar::Scope::program) return;
  CLI::App& sub = grammar.verb("keystore",
                               "certificates and permissions for DDS Security: who may look, stop, "
                               "command, be a vehicle, or take part in ROS 2",
                               R"(
  lss-cli keystore create keys
  lss-cli keystore add keys zebro-1 --role vehicle
  lss-cli keystore add keys pilot --role command
  lss-cli keystore revoke keys pilot
  lss-cli keystore list keys
)");
  auto words = std::make_shared<Words>();
  sub.add_option("what", words->what, "create, add, revoke or list")
      ->required()
      ->check(CLI::IsMember({"create", "add", "revoke", "list"}));
  sub.add_option("folder", words->folder, "the keystore")->required();
  sub.add_option("name", words->name,
                 "of the enclave: a vehicle's vehicle_id, a pilot, a program, a node of ROS 2");
  sub.add_option("--role", words->role, "what it may; ros: a node of ROS 2, bridge: lss-ros")
      ->check(CLI::IsMember(std::vector<std::string>(std::begin(kDdsRoles), std::end(kDdsRoles))));
  sub.add_option("--certificate", words->certificate,
                 "to revoke, of an enclave that is no longer in the keystore");
  sub.add_option("--days", words->days, "until it expires")
      ->check(CLI::Range(1, 36'500))
      ->capture_default_str();
  grammar.values(sub, "", {"create", "add", "revoke", "list"});
  grammar.values(sub, "--role", {kDdsRoles, kDdsRoles + std::size(kDdsRoles)});
  grammar.on(
      sub, [words](Context& context) { return run(context, *words); }, [words] { check(*words); });
}

}  // namespace lss::cli
