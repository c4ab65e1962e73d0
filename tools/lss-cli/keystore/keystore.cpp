#include "tools/lss-cli/keystore/keystore.h"

#include <fcntl.h>
#include <fmt/chrono.h>
#include <fmt/format.h>
#include <openssl/ec.h>
#include <openssl/pem.h>
#include <openssl/pkcs7.h>
#include <openssl/rand.h>
#include <openssl/x509v3.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <memory>

#include "drivers/file.h"
#include "idl/openssl_handles.h"
#include "idl/security.h"
#include "lss.h"
#include "tools/lss-cli/keystore/permissions.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {
namespace {

namespace fs = std::filesystem;

using openssl::Bio, openssl::Certificate, openssl::Key, openssl::RevocationList, openssl::With;

constexpr mode_t kPublic = 0644, kPrivate = 0600;
constexpr const char* kPermissionsText = "permissions.xml";  // what was signed
constexpr std::size_t kLongestName = 23;  // a source is NAME:PID of at most 31 characters

[[noreturn]] void fail(const fs::path& path, const std::string& what,
                       const std::string& advice = "") {
  throw Failure(ExitCode::usage, fmt::format("{}: {}", path.string(), what), advice);
}

// Of OpenSSL: only without memory or random numbers.
template <class T>
T made(T one) {
  if (!one) throw Failure(ExitCode::internal, "OpenSSL cannot make a key or a certificate");
  return one;
}

void write(const fs::path& path, std::string_view text, mode_t mode) {
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
  const bool written =
      file >= 0 && ::write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  const bool closed = file >= 0 && ::fsync(file) == 0 && ::close(file) == 0;
  if (!written || !closed) fail(path, std::strerror(error));
}

std::string text_of(BIO* bio) {
  char* text = nullptr;
  const long size = BIO_get_mem_data(bio, &text);
  return {text, static_cast<std::size_t>(size)};
}

std::string pem(X509* certificate) {
  const Bio out(made(BIO_new(BIO_s_mem())));
  PEM_write_bio_X509(out.get(), certificate);
  return text_of(out.get());
}

std::string pem(EVP_PKEY* key) {
  const Bio out(made(BIO_new(BIO_s_mem())));
  PEM_write_bio_PrivateKey(out.get(), key, nullptr, nullptr, 0, nullptr, nullptr);
  return text_of(out.get());
}

struct Identity {
  Key key;
  Certificate certificate;
};

// `issuer` nullptr: a CA, signed by itself. Valid from 1970, so that a computer without a clock
// battery can check it.
Identity make_identity(const std::string& name, const Identity* issuer, int days) {
  Identity one{Key(made(EVP_EC_gen("prime256v1"))), Certificate(made(X509_new()))};
  X509* certificate = one.certificate.get();
  X509_set_version(certificate, X509_VERSION_3);
  std::uint64_t serial = 0;
  made(RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial) == 1);
  ASN1_INTEGER_set_uint64(X509_get_serialNumber(certificate), serial >> 1);
  ASN1_TIME_set(X509_getm_notBefore(certificate), 0);
  X509_time_adj_ex(X509_getm_notAfter(certificate), days, 0, nullptr);
  X509_set_pubkey(certificate, one.key.get());
  X509_NAME_add_entry_by_NID(X509_get_subject_name(certificate), NID_commonName, V_ASN1_UTF8STRING,
                             reinterpret_cast<const unsigned char*>(name.data()),
                             static_cast<int>(name.size()), -1, 0);
  const Identity& by = issuer == nullptr ? one : *issuer;
  X509_set_issuer_name(certificate, X509_get_subject_name(by.certificate.get()));
  X509V3_CTX context;
  X509V3_set_ctx(&context, by.certificate.get(), certificate, nullptr, nullptr, 0);
  const auto extend = [&](int kind, const char* value) {
    X509_EXTENSION* extension = made(X509V3_EXT_conf_nid(nullptr, &context, kind, value));
    X509_add_ext(certificate, extension, -1);
    X509_EXTENSION_free(extension);
  };
  extend(NID_subject_key_identifier, "hash");
  extend(NID_authority_key_identifier, "keyid");
  if (issuer == nullptr) {
    extend(NID_basic_constraints, "critical,CA:TRUE,pathlen:0");
    extend(NID_key_usage, "critical,keyCertSign,cRLSign,digitalSignature");
  } else {
    extend(NID_basic_constraints, "critical,CA:FALSE");
    extend(NID_key_usage, "critical,digitalSignature");
  }
  made(X509_sign(certificate, by.key.get(), EVP_sha256()));
  return one;
}

std::string signed_text(const std::string& text, const Identity& by) {
  constexpr int kFlags = PKCS7_TEXT | PKCS7_DETACHED;
  const auto in = [&] {
    return Bio(made(BIO_new_mem_buf(text.data(), static_cast<int>(text.size()))));
  };
  const std::unique_ptr<PKCS7, With<PKCS7_free>> document(
      made(PKCS7_sign(by.certificate.get(), by.key.get(), nullptr, in().get(), kFlags)));
  const Bio out(made(BIO_new(BIO_s_mem())));
  made(SMIME_write_PKCS7(out.get(), document.get(), in().get(), kFlags) == 1);
  return text_of(out.get());
}

Identity read_identity(const fs::path& keystore, const char* ca) {
  const fs::path certificate = keystore / "public" / (std::string(ca) + ".cert.pem");
  const fs::path key = keystore / "private" / (std::string(ca) + ".key.pem");
  const auto open = [&](const fs::path& path) {
    Bio bio(BIO_new_file(path.c_str(), "r"));
    if (!bio)
      fail(path, "cannot be read",
           "is this a keystore? Make one with: lss-cli keystore create FOLDER");
    return bio;
  };
  Identity one{Key(PEM_read_bio_PrivateKey(open(key).get(), nullptr, nullptr, nullptr)),
               Certificate(PEM_read_bio_X509(open(certificate).get(), nullptr, nullptr, nullptr))};
  if (!one.key || !one.certificate ||
      X509_check_private_key(one.certificate.get(), one.key.get()) != 1)
    fail(key, "is not the key of " + certificate.string());
  return one;
}

// What was renamed in it is on the disk.
void sync_folder(const fs::path& folder) {
  const File file(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (file) ::fsync(file.get());
}

// The old file or the new one, whole, also after a power cut.
void replace(const fs::path& path, std::string_view text) {
  fs::path next = path;
  next += ".new";
  std::error_code none;
  fs::remove(next, none);  // half written, before a power cut
  write(next, text, kPublic);
  if (::rename(next.c_str(), path.c_str()) != 0) fail(path, std::strerror(errno));
  sync_folder(path.parent_path());
}

// Locks the keystore until the File is closed.
File lock_of(const fs::path& keystore) {
  File folder(::open(keystore.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (!folder)
    fail(keystore, std::string("cannot be read: ") + std::strerror(errno),
         "make one with: lss-cli keystore create FOLDER");
  ::flock(folder.get(), LOCK_EX);
  return folder;
}

Certificate certificate_in(const fs::path& file) {
  const Bio in(BIO_new_file(file.c_str(), "r"));
  return Certificate(in ? PEM_read_bio_X509(in.get(), nullptr, nullptr, nullptr) : nullptr);
}

RevocationList list_in(const fs::path& file) {
  const Bio in(BIO_new_file(file.c_str(), "r"));
  return RevocationList(in ? PEM_read_bio_X509_CRL(in.get(), nullptr, nullptr, nullptr) : nullptr);
}

// Each participant has one folder with its certificate, in ROS 2 also deeper.
std::vector<fs::path> enclaves_in(const fs::path& folder) {
  std::vector<fs::path> all;
  std::error_code error;
  for (fs::recursive_directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    std::error_code none;
    if (entry->is_directory(none) && fs::exists(entry->path() / dds::kCertificate, none))
      all.push_back(entry->path());
  }
  std::ranges::sort(all);
  return all;
}

// A list of revoked certificates, valid from 1970 like certificates.
class Revoked {
 public:
  explicit Revoked(const Identity& ca) : ca_(ca), list_(made(X509_CRL_new())) {
    X509_CRL_set_version(list_.get(), 1);  // the second, which has extensions
    X509_CRL_set_issuer_name(list_.get(), X509_get_subject_name(ca.certificate.get()));
    const std::unique_ptr<ASN1_TIME, With<ASN1_TIME_free>> begin(made(ASN1_TIME_set(nullptr, 0)));
    made(X509_CRL_set1_lastUpdate(list_.get(), begin.get()) == 1);
    made(X509_CRL_set1_nextUpdate(list_.get(), X509_get0_notAfter(ca.certificate.get())) == 1);
  }

  void add(const ASN1_INTEGER* serial) {
    X509_REVOKED* there = nullptr;
    std::unique_ptr<ASN1_INTEGER, With<ASN1_INTEGER_free>> number(made(ASN1_INTEGER_dup(serial)));
    if (X509_CRL_get0_by_serial(list_.get(), &there, number.get()) == 1) return;
    std::unique_ptr<X509_REVOKED, With<X509_REVOKED_free>> one(made(X509_REVOKED_new()));
    made(X509_REVOKED_set_serialNumber(one.get(), number.get()) == 1);
    const std::unique_ptr<ASN1_TIME, With<ASN1_TIME_free>> now(
        made(ASN1_TIME_set(nullptr, std::time(nullptr))));
    made(X509_REVOKED_set_revocationDate(one.get(), now.get()) == 1);
    made(X509_CRL_add0_revoked(list_.get(), one.get()) == 1);
    one.release();  // the list owns it
    ++count_;
  }
  // All of a list of this CA; false: it is none.
  bool add_all(const fs::path& file) {
    const RevocationList list = list_in(file);
    if (!list || X509_CRL_verify(list.get(), ca_.key.get()) != 1) return false;
    STACK_OF(X509_REVOKED)* const all = X509_CRL_get_REVOKED(list.get());
    for (int i = 0; i < sk_X509_REVOKED_num(all); ++i)
      add(X509_REVOKED_get0_serialNumber(sk_X509_REVOKED_value(all, i)));
    return true;
  }
  // Numbered by its length, which only grows.
  std::string text() {
    const std::unique_ptr<ASN1_INTEGER, With<ASN1_INTEGER_free>> number(made(ASN1_INTEGER_new()));
    made(ASN1_INTEGER_set_int64(number.get(), count_) == 1);
    made(X509_CRL_add1_ext_i2d(list_.get(), NID_crl_number, number.get(), 0, 0) == 1);
    X509V3_CTX context;
    X509V3_set_ctx(&context, ca_.certificate.get(), nullptr, nullptr, list_.get(), 0);
    X509_EXTENSION* const issuer =
        made(X509V3_EXT_conf_nid(nullptr, &context, NID_authority_key_identifier, "keyid:always"));
    made(X509_CRL_add_ext(list_.get(), issuer, -1) == 1);
    X509_EXTENSION_free(issuer);
    X509_CRL_sort(list_.get());
    made(X509_CRL_sign(list_.get(), ca_.key.get(), EVP_sha256()));
    const Bio out(made(BIO_new(BIO_s_mem())));
    made(PEM_write_bio_X509_CRL(out.get(), list_.get()) == 1);
    return text_of(out.get());
  }

 private:
  const Identity& ca_;
  RevocationList list_;
  std::int64_t count_ = 0;
};

// Everything that the keystore knows to be revoked, so that a list from an old copy forgets
// nothing.
void collect_revoked(const fs::path& keystore, Revoked& list) {
  const fs::path file = keystore / "public" / dds::kRevoked;
  std::error_code none;
  if (fs::exists(fs::symlink_status(file, none)) && !list.add_all(file))
    fail(file, "is no list of revoked certificates of this keystore, or cannot be read",
         "restore it from a copy, or delete it: what is in revoked/ and in the lists of the "
         "enclaves is kept");
  for (const fs::path& one : enclaves_in(keystore / "enclaves")) list.add_all(one / dds::kRevoked);
  for (const fs::path& one : enclaves_in(keystore / "revoked")) {
    if (const Certificate gone = certificate_in(one / dds::kCertificate))
      list.add(X509_get0_serialNumber(gone.get()));
  }
}

std::string serial_of(X509* certificate) {
  const std::unique_ptr<BIGNUM, With<BN_free>> number(
      made(ASN1_INTEGER_to_BN(X509_get0_serialNumber(certificate), nullptr)));
  char* const text = made(BN_bn2hex(number.get()));
  const std::string serial = text;
  OPENSSL_free(text);
  return serial;
}

bool can_revoke(const Identity& ca) {
  return (X509_get_key_usage(ca.certificate.get()) & KU_CRL_SIGN) != 0;
}

// Fills a folder beside `folder` and gives it the name at last, so that it is whole or not there.
template <class Fill>
void make_folder(const fs::path& folder, Fill fill) {
  std::string text = folder.string() + ".XXXXXX";
  if (::mkdtemp(text.data()) == nullptr) fail(folder, std::strerror(errno));
  const fs::path unfinished(text);
  std::error_code error;
  try {
    fill(unfinished);
    // Fails where there is something already.
    if (::rename(unfinished.c_str(), folder.c_str()) != 0) fail(folder, std::strerror(errno));
  } catch (...) {
    fs::remove_all(unfinished, error);
    throw;
  }
}

std::string day(std::int64_t utc_s) { return fmt::format("{:%Y-%m-%d}", fmt::gmtime(utc_s)); }

std::string content_of(const fs::path& file) {
  const Bio in(BIO_new_file(file.c_str(), "r"));
  std::string text;
  std::array<char, 4096> piece{};
  for (int got; in && (got = BIO_read(in.get(), piece.data(), piece.size())) > 0;)
    text.append(piece.data(), static_cast<std::size_t>(got));
  return text;
}

// What is left of an enclave: the certificate, and its permissions when they are beside the file.
void keep_revoked(const fs::path& to, const fs::path& file, X509* certificate) {
  const std::string permissions = content_of(file.parent_path() / kPermissionsText);
  const bool its =
      permissions.find(fmt::format("<subject_name>CN={}</subject_name>",
                                   dds::common_name(certificate))) != std::string::npos;
  make_folder(to, [&](const fs::path& root) {
    write(root / dds::kCertificate, pem(certificate), kPublic);
    if (its) write(root / kPermissionsText, permissions, kPublic);
  });
  sync_folder(to.parent_path());
}

}  // namespace

void create_keystore(const fs::path& folder, int days) {
  std::error_code none;
  if (fs::exists(folder, none) && !fs::is_empty(folder, none))
    fail(folder, "is there already and not empty",
         "name a new folder, or add to this keystore: lss-cli keystore add");
  const Identity identity_ca = make_identity("lss identity CA", nullptr, days);
  const Identity permissions_ca = make_identity("lss permissions CA", nullptr, days);
  make_folder(folder.has_filename() ? folder : folder.parent_path(), [&](const fs::path& root) {
    for (const char* name : {"public", "private", "enclaves"}) fs::create_directory(root / name);
    for (const auto& [name, one] :
         {std::pair{"identity_ca", &identity_ca}, std::pair{"permissions_ca", &permissions_ca}}) {
      write(root / "public" / (std::string(name) + ".cert.pem"), pem(one->certificate.get()),
            kPublic);
      write(root / "private" / (std::string(name) + ".key.pem"), pem(one->key.get()), kPrivate);
    }
    write(root / "public" / dds::kRevoked, Revoked(identity_ca).text(), kPublic);
    fs::permissions(root / "private", fs::perms::owner_all);
    const std::string governance = governance_text();
    write(root / "enclaves" / "governance.xml", governance, kPublic);
    write(root / "enclaves" / dds::kGovernance, signed_text(governance, permissions_ca), kPublic);
  });
}

void add_enclave(const fs::path& keystore, const std::string& name, DdsRole role, int days) {
  const bool good = std::ranges::all_of(name, [](unsigned char c) {
    return c < 128 && (std::isalnum(c) != 0 || c == '-' || c == '_');
  });
  if (name.empty() || name.size() > kLongestName || !good)
    throw Failure(ExitCode::usage,
                  fmt::format("'{}' must be 1 to {} letters, digits, - or _", name, kLongestName));
  if (name.starts_with('-'))
    throw Failure(ExitCode::usage, fmt::format("'{}' begins with -", name), "take another name");
  if (role == DdsRole::vehicle && name.size() >= sizeof lss_Status::vehicle_id)
    throw Failure(ExitCode::usage,
                  fmt::format("'{}' is longer than a vehicle_id, {} characters", name,
                              sizeof lss_Status::vehicle_id - 1),
                  "name the enclave of a vehicle as its vehicle_id");
  if (role == DdsRole::ros &&
      (name.find('-') != name.npos || std::isdigit(static_cast<unsigned char>(name.front())) != 0))
    throw Failure(ExitCode::usage,
                  fmt::format("'{}' is no name in ROS 2: letters, digits, _", name),
                  "take another name");
  const File lock = lock_of(keystore);
  std::error_code none;
  const fs::path folder = keystore / "enclaves" / name;
  if (fs::exists(folder, none))
    fail(folder, "is there already",
         "take another name, or first: lss-cli keystore revoke " + keystore.string() + " " + name);
  const Identity identity_ca = read_identity(keystore, "identity_ca");
  const Identity permissions_ca = read_identity(keystore, "permissions_ca");
  if (X509_cmp(identity_ca.certificate.get(), permissions_ca.certificate.get()) == 0)
    fail(keystore, "has one CA for identities and permissions",
         "make a keystore with two: lss-cli keystore create FOLDER");
  // Permissions are of a name, not of a certificate: those of before stay valid.
  for (const fs::path& one : enclaves_in(keystore / "revoked")) {
    const Certificate before = certificate_in(one / dds::kCertificate);
    if (!before || dds::common_name(before.get()) != name) continue;
    const std::string had = role_in(content_of(one / kPermissionsText));
    if (had == kDdsRoles[static_cast<std::size_t>(role)]) continue;
    const bool known = std::ranges::find(kDdsRoles, had) != std::end(kDdsRoles);
    throw Failure(
        ExitCode::usage,
        fmt::format("a revoked {} had {}, and its signed permissions fit any certificate of that "
                    "name",
                    name, known ? "the role " + had : "a role that this keystore does not know"),
        known ? "take another name, or --role " + had : "take another name");
  }
  Revoked revoked(identity_ca);
  const bool lists = can_revoke(identity_ca);
  if (lists) collect_revoked(keystore, revoked);
  const Identity own = make_identity(name, &identity_ca, days);
  const std::string permissions =
      permissions_text(name, role, std::time(nullptr) + std::time_t{days} * 86'400);
  make_folder(folder, [&](const fs::path& root) {
    for (const char* file : {dds::kIdentityCa, dds::kPermissionsCa})
      fs::copy_file(keystore / "public" / file, root / file);
    fs::copy_file(keystore / "enclaves" / dds::kGovernance, root / dds::kGovernance);
    write(root / dds::kCertificate, pem(own.certificate.get()), kPublic);
    write(root / dds::kKey, pem(own.key.get()), kPrivate);
    if (lists) write(root / dds::kRevoked, revoked.text(), kPublic);
    write(root / kPermissionsText, permissions, kPublic);
    write(root / dds::kPermissions, signed_text(permissions, permissions_ca), kPublic);
  });
}

void revoke_enclave(const fs::path& keystore, const std::string& name,
                    const fs::path& certificate_file) {
  const File lock = lock_of(keystore);
  const Identity ca = read_identity(keystore, "identity_ca");
  if (!can_revoke(ca))
    fail(keystore, "has an identity CA that may not sign a list of revoked certificates",
         "make a new keystore: lss-cli keystore create FOLDER");
  std::error_code error;
  const fs::path folder = keystore / "enclaves" / name;
  const bool is_name = !name.empty() && fs::path(name).filename() == name && name[0] != '.';
  if (certificate_file.empty() && (!is_name || !fs::is_directory(folder, error)))
    fail(folder, "is no enclave",
         "see them with: lss-cli keystore list " + keystore.string() +
             ", or give its certificate by --certificate");
  const fs::path file = certificate_file.empty() ? folder / dds::kCertificate : certificate_file;
  const Certificate certificate = certificate_in(file);
  if (!certificate)
    fail(file, "is no certificate in PEM, or cannot be read", "give a copy of it by --certificate");
  if (X509_verify(certificate.get(), ca.key.get()) != 1)
    fail(file, "is of another keystore, where it can be revoked");

  Revoked list(ca);
  collect_revoked(keystore, list);
  list.add(X509_get0_serialNumber(certificate.get()));
  const std::string text = list.text();
  replace(keystore / "public" / dds::kRevoked, text);
  std::string without;
  for (const fs::path& other : enclaves_in(keystore / "enclaves")) {
    if (certificate_file.empty() && other == folder) continue;
    try {
      replace(other / dds::kRevoked, text);
    } catch (const Failure& failure) {
      without += std::string(without.empty() ? "" : "; ") + failure.what();
    }
  }
  const fs::path away = keystore / "revoked";
  fs::create_directory(away, error);
  if (error) fail(away, error.message());
  fs::permissions(away, fs::perms::owner_all, error);
  const fs::path of = certificate_file.empty()
                          ? fs::path(name)
                          : fs::path(dds::common_name(certificate.get())).filename();
  const fs::path to = away / (of.string() + "-" + serial_of(certificate.get()));
  if (!certificate_file.empty()) {
    if (!fs::exists(to, error)) keep_revoked(to, file, certificate.get());
  } else {
    fs::remove_all(to, error);  // its certificate was revoked by a copy
    if (::rename(folder.c_str(), to.c_str()) != 0) fail(to, std::strerror(errno));
    sync_folder(away);
    sync_folder(folder.parent_path());
  }
  if (!without.empty())
    throw Failure(ExitCode::failed, "it is revoked, but not all enclaves have the list: " + without,
                  "copy " + (keystore / "public" / dds::kRevoked).string() + " there");
}

std::vector<KeystoreEntry> list_keystore(const fs::path& keystore) {
  std::error_code error;
  std::vector<KeystoreEntry> list;
  fs::directory_iterator all(keystore / "enclaves", error);
  if (error)
    fail(keystore, "is no keystore: " + error.message(),
         "make one with: lss-cli keystore create FOLDER");
  for (const fs::directory_entry& entry : all) {
    if (!entry.is_directory()) continue;
    KeystoreEntry one;
    one.name = entry.path().filename().string();
    if (const auto read = dds::read_enclave(entry.path())) {
      one.role = role_in(read->permissions);
      one.not_after = day(read->not_after_utc_s);
    } else {
      one.fault = read.error();
    }
    list.push_back(std::move(one));
  }
  std::ranges::sort(list, {}, &KeystoreEntry::name);
  return list;
}

}  // namespace lss::cli
