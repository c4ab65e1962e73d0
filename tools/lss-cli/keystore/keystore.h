#pragma once

// Makes the certificates and signed documents of DDS Security: a keystore in the layout of SROS2,
//   public/    certificates of the two CAs
//   private/   their keys, which no vehicle gets
//   enclaves/NAME/   all that one participant needs (idl/security.h)
//   revoked/NAME-SERIAL/   enclaves that nobody accepts any more, or their certificates only
// with separate CAs for identities and permissions. Throws Failure; nothing is overwritten but the
// list of revoked certificates (public/crl.pem, a copy in each enclave), which only grows.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lss::cli {

// What a participant may (docs/security.md).
enum class DdsRole : std::uint8_t { look, stop, command, vehicle, ros, bridge };
inline constexpr const char* kDdsRoles[] = {"look", "stop", "command", "vehicle", "ros", "bridge"};

void create_keystore(const std::filesystem::path& folder, int days);

void add_enclave(const std::filesystem::path& keystore, const std::string& name, DdsRole role,
                 int days);

// Puts the certificate of the enclave on the list and moves the enclave to revoked/; or, with
// `certificate`, a file, puts that one on the list and a copy of it into revoked/. Participants
// refuse it once they have the list and are started again.
void revoke_enclave(const std::filesystem::path& keystore, const std::string& name,
                    const std::filesystem::path& certificate = {});

struct KeystoreEntry {
  std::string name, role;
  std::string not_after;  // YYYY-MM-DD
  std::string fault;      // a sentence, when it cannot be used
};
std::vector<KeystoreEntry> list_keystore(const std::filesystem::path& keystore);

}  // namespace lss::cli
