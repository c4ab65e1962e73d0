#include "idl/security.h"

#include <dds/security/dds_security_api_defs.h>
#include <dlfcn.h>
#include <openssl/err.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/sha.h>
#include <openssl/x509.h>
#include <openssl/x509_vfy.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>

#include "idl/openssl_handles.h"

namespace lss::dds {
namespace {

namespace fs = std::filesystem;

using openssl::Bio, openssl::Certificate, openssl::Key, openssl::RevocationList, openssl::With;
using Signers =
    std::unique_ptr<STACK_OF(X509), decltype([](STACK_OF(X509) * all) { sk_X509_free(all); })>;

tl::unexpected<std::string> wrong(const fs::path& file, const std::string& what) {
  return tl::unexpected(file.string() + " " + what);
}

// Of a regular file: nothing else can hold up this program.
Bio open(const fs::path& file) {
  std::error_code none;
  return Bio(fs::is_regular_file(file, none) ? BIO_new_file(file.c_str(), "r") : nullptr);
}

tl::expected<Certificate, std::string> read_certificate(const fs::path& file) {
  const Bio in = open(file);
  if (!in) return wrong(file, "cannot be read; make an enclave with: lss-cli keystore add");
  Certificate certificate(PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr));
  if (!certificate) return wrong(file, "is no certificate in PEM");
  return certificate;
}

tl::expected<Key, std::string> read_key(const fs::path& file) {
  struct stat about {};
  if (::stat(file.c_str(), &about) != 0 || ::access(file.c_str(), R_OK) != 0)
    return wrong(file, "cannot be read; give it to the user of this program");
  if ((about.st_mode & S_IRWXO) != 0)
    return wrong(file, "can be read by anybody; chmod 600 " + file.string());
  const Bio in = open(file);
  const auto no_word = [](char*, int, int, void*) { return 0; };  // do not ask on the terminal
  Key key(PEM_read_bio_PrivateKey(in.get(), nullptr, no_word, nullptr));
  if (!key) return wrong(file, "is no private key in PEM without a password");
  return key;
}

// The list in `folder`, of that CA and without the certificate; nullptr: there is none.
tl::expected<RevocationList, std::string> read_revoked(const fs::path& folder, EVP_PKEY* ca,
                                                       X509* certificate) {
  const fs::path file = folder / kRevoked;
  const std::string again = ": take the file from the keystore again";
  std::error_code none;
  if (!fs::exists(fs::symlink_status(file, none))) return RevocationList();
  const Bio in = open(file);
  if (!in) return wrong(file, "cannot be read" + again);
  RevocationList list(PEM_read_bio_X509_CRL(in.get(), nullptr, nullptr, nullptr));
  if (!list) return wrong(file, "is no list of revoked certificates in PEM" + again);
  if (X509_CRL_verify(list.get(), ca) != 1)
    return wrong(file, "is not signed by " + std::string(kIdentityCa) + again);
  X509_REVOKED* entry = nullptr;
  if (X509_CRL_get0_by_cert(list.get(), &entry, certificate) == 1)
    return wrong(folder / kCertificate,
                 "is revoked: make a new enclave with: lss-cli keystore add");
  return list;
}

std::int64_t utc_s(const ASN1_TIME* time) {
  std::tm parts{};
  ASN1_TIME_to_tm(time, &parts);
  return ::timegm(&parts);
}

std::string day(std::int64_t utc_s) {
  const std::time_t time = utc_s;
  char text[32];
  std::tm parts{};
  std::strftime(text, sizeof text, "%Y-%m-%d", ::gmtime_r(&time, &parts));
  return text;
}

// The text of an S/MIME document that exactly `signer` has signed.
tl::expected<std::string, std::string> read_signed(const fs::path& file, X509* signer) {
  const Bio in = open(file);
  if (!in) return wrong(file, "cannot be read");
  BIO* content = nullptr;
  const std::unique_ptr<PKCS7, With<PKCS7_free>> document(SMIME_read_PKCS7(in.get(), &content));
  const Bio owned(content);
  if (!document || content == nullptr) return wrong(file, "is no signed document (S/MIME)");
  const std::unique_ptr<X509_STORE, With<X509_STORE_free>> store(X509_STORE_new());
  X509_STORE_add_cert(store.get(), signer);
  const Signers signers(sk_X509_new_null());
  sk_X509_push(signers.get(), signer);
  const Bio out(BIO_new(BIO_s_mem()));
  // PKCS7_NOINTERN: certificates in the document are not looked at.
  if (PKCS7_verify(document.get(), signers.get(), store.get(), content, out.get(),
                   PKCS7_TEXT | PKCS7_NOINTERN) != 1) {
    char why[160];
    ERR_error_string_n(ERR_peek_last_error(), why, sizeof why);
    return wrong(file, "is not signed by " + file.parent_path().string() + "/" + kPermissionsCa +
                           " itself (" + why +
                           "): it was altered, or somebody else signed it; take the files "
                           "from the keystore again");
  }
  char* text = nullptr;
  const long size = BIO_get_mem_data(out.get(), &text);
  return std::string(text, static_cast<std::size_t>(size));
}

// For all verifications of this process, those of the plugins included.
void check_no_dates() {
  X509_VERIFY_PARAM* rules = X509_VERIFY_PARAM_new();
  X509_VERIFY_PARAM_set1_name(rules, "default");
  X509_VERIFY_PARAM_set_flags(rules, X509_V_FLAG_NO_CHECK_TIME | X509_V_FLAG_TRUSTED_FIRST);
  X509_VERIFY_PARAM_set_depth(rules,
                              100);  // as in OpenSSL's own; without it no chain is short enough
  X509_VERIFY_PARAM_add0_table(rules);
}

// The folder of libddsc, or Debian's folder for its plugins below it.
std::optional<fs::path> plugin(const std::string& file) {
  Dl_info about{};
  if (::dladdr(reinterpret_cast<const void*>(&dds_create_participant), &about) == 0) return {};
  std::error_code none;
  const fs::path library = fs::canonical(about.dli_fname, none);
  for (const fs::path& folder : {library.parent_path(), library.parent_path() / "libddsc0debian"}) {
    if (fs::exists(folder / file, none)) return folder / file;
  }
  return {};
}

void put(dds_qos_t* qos, const std::string& name, const std::string& value) {
  dds_qset_prop(qos, name.c_str(), value.c_str());
}

}  // namespace

std::string common_name(const X509* certificate) {
  char text[256] = "";
  X509_NAME_get_text_by_NID(X509_get_subject_name(certificate), NID_commonName, text, sizeof text);
  return text;
}

tl::expected<Enclave, std::string> read_enclave(const fs::path& folder,
                                                std::chrono::days clock_slack,
                                                bool* clock_may_cure) {
  std::error_code none;
  Enclave enclave;
  enclave.folder = fs::absolute(folder, none);
  const fs::path& all = enclave.folder;
  if (!fs::is_directory(all, none))
    return wrong(all, "is no enclave folder; make one with: lss-cli keystore add");
  const auto identity_ca = read_certificate(all / kIdentityCa);
  if (!identity_ca) return tl::unexpected(identity_ca.error());
  const auto permissions_ca = read_certificate(all / kPermissionsCa);
  if (!permissions_ca) return tl::unexpected(permissions_ca.error());
  const auto certificate = read_certificate(all / kCertificate);
  if (!certificate) return tl::unexpected(certificate.error());
  const auto key = read_key(all / kKey);
  if (!key) return tl::unexpected(key.error());

  enclave.name = common_name(certificate->get());
  if (enclave.name.empty()) return wrong(all / kCertificate, "has no common name (CN)");
  if (X509_check_private_key(certificate->get(), key->get()) != 1)
    return wrong(all / kKey, "is not the key of " + std::string(kCertificate));
  const Key ca_key(X509_get_pubkey(identity_ca->get()));
  if (X509_verify(certificate->get(), ca_key.get()) != 1)
    return wrong(all / kCertificate, "is not signed by " + std::string(kIdentityCa));
  const auto revokes = read_revoked(all, ca_key.get(), certificate->get());
  if (!revokes) return tl::unexpected(revokes.error());
  enclave.revokes = *revokes != nullptr;
  const std::uint32_t usage = X509_get_key_usage(identity_ca->get());
  if (!enclave.revokes && usage != UINT32_MAX && (usage & KU_CRL_SIGN) != 0)
    enclave.warnings.push_back((all / kRevoked).string() +
                               " is missing: revoked certificates are accepted; take the file from "
                               "the keystore");

  const std::int64_t now_s = std::time(nullptr);
  std::int64_t begins_s = INT64_MIN;
  enclave.not_after_utc_s = INT64_MAX;
  for (const auto* one : {&identity_ca, &permissions_ca, &certificate}) {
    begins_s = std::max(begins_s, utc_s(X509_get0_notBefore((*one)->get())));
    enclave.not_after_utc_s =
        std::min(enclave.not_after_utc_s, utc_s(X509_get0_notAfter((*one)->get())));
  }
  if (enclave.revokes) {
    begins_s = std::max(begins_s, utc_s(X509_CRL_get0_lastUpdate(revokes->get())));
    if (const ASN1_TIME* next = X509_CRL_get0_nextUpdate(revokes->get()))
      enclave.not_after_utc_s = std::min(enclave.not_after_utc_s, utc_s(next));
  }
  if (now_s < begins_s) {
    const std::string clock =
        "is valid from " + day(begins_s) + ", but the clock says " + day(now_s) + ": set the clock";
    if (clock_may_cure != nullptr) *clock_may_cure = true;
    if (begins_s - now_s > std::chrono::seconds(clock_slack).count())
      return wrong(all, clock + ", or allow this difference by dds.security.clock_slack_days");
    enclave.warnings.push_back(all.string() + " " + clock +
                               "; until the next start expired certificates are accepted");
    check_no_dates();
  }
  if (now_s > enclave.not_after_utc_s) {
    if (clock_may_cure != nullptr) *clock_may_cure = true;
    return wrong(all, "expired on " + day(enclave.not_after_utc_s) + ", and the clock says " +
                          day(now_s) + ": make a new one, or set the clock");
  }
  constexpr std::int64_t kSoon_s = 30 * 86'400;
  if (now_s > enclave.not_after_utc_s - kSoon_s)
    enclave.warnings.push_back(all.string() + " expires on " + day(enclave.not_after_utc_s) +
                               ": make a new one");
  if (X509_cmp(identity_ca->get(), permissions_ca->get()) == 0)
    enclave.warnings.push_back(
        all.string() +
        " has one CA for identities and permissions (as keystores of ROS 2): everyone with a "
        "certificate can sign its own permissions (CVE-2023-24011); use: lss-cli keystore");

  if (const auto read = read_signed(all / kGovernance, permissions_ca->get()); !read)
    return tl::unexpected(read.error());
  auto permissions = read_signed(all / kPermissions, permissions_ca->get());
  if (!permissions) return tl::unexpected(permissions.error());
  enclave.permissions = std::move(*permissions);
  return enclave;
}

tl::expected<void, std::string> use_enclave(dds_qos_t* qos, const Enclave& enclave) {
  const auto file = [&](const char* name) { return "file:" + (enclave.folder / name).string(); };
  put(qos, "dds.sec.auth.identity_ca", file(kIdentityCa));
  put(qos, "dds.sec.auth.identity_certificate", file(kCertificate));
  put(qos, "dds.sec.auth.private_key", file(kKey));
  if (enclave.revokes) put(qos, ORG_ECLIPSE_CYCLONEDDS_SEC_AUTH_CRL, file(kRevoked));
  put(qos, "dds.sec.access.permissions_ca", file(kPermissionsCa));
  put(qos, "dds.sec.access.governance", file(kGovernance));
  put(qos, "dds.sec.access.permissions", file(kPermissions));
  struct Plugin {
    const char *property, *file, *suffix;
  };
  constexpr Plugin kPlugins[] = {{"auth", "libdds_security_auth.so", "authentication"},
                                 {"crypto", "libdds_security_crypto.so", "crypto"},
                                 {"access", "libdds_security_ac.so", "access_control"}};
  for (const Plugin& one : kPlugins) {
    const auto path = plugin(one.file);
    if (!path) {
      return tl::unexpected(std::string("cannot find ") + one.file +
                            " beside libddsc: is Cyclone DDS built with security?");
    }
    const std::string library = std::string("dds.sec.") + one.property + ".library.";
    put(qos, library + "path", path->string());
    put(qos, library + "init", std::string("init_") + one.suffix);
    put(qos, library + "finalize", std::string("finalize_") + one.suffix);
  }
  return {};
}

std::string_view name_of_source(std::string_view source) {
  return source.substr(0, source.find(':'));
}

bool is_of_vehicle(std::string_view name, std::string_view vehicle_id) {
  if (name.starts_with('/')) name.remove_prefix(1);
  return name == vehicle_id;
}

bool is_name_of(std::string_view name, const std::array<std::uint8_t, 16>& guid) {
  constexpr std::size_t kHashed = 6;
  for (const int kind : {V_ASN1_UTF8STRING, V_ASN1_PRINTABLESTRING}) {
    const std::unique_ptr<X509_NAME, With<X509_NAME_free>> subject(X509_NAME_new());
    X509_NAME_add_entry_by_NID(subject.get(), NID_commonName, kind,
                               reinterpret_cast<const unsigned char*>(name.data()),
                               static_cast<int>(name.size()), -1, 0);
    unsigned char* der = nullptr;
    const int size = i2d_X509_NAME(subject.get(), &der);
    if (size <= 0) continue;
    std::array<unsigned char, SHA256_DIGEST_LENGTH> hash{};
    SHA256(der, static_cast<std::size_t>(size), hash.data());
    OPENSSL_free(der);
    std::array<std::uint8_t, kHashed> expected{};  // a one, then the first 47 bits of the hash
    for (std::size_t i = 0; i < kHashed; ++i) {
      const unsigned carried = i == 0 ? 1 : hash[i - 1] & 1u;
      expected[i] = static_cast<std::uint8_t>(carried << 7 | hash[i] >> 1);
    }
    if (std::equal(expected.begin(), expected.end(), guid.begin())) return true;
  }
  return false;
}

}  // namespace lss::dds
