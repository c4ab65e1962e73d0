#pragma once

// Enclaves: the certificates with which a participant shows who it is, and the signed documents
// that say what it may (OMG DDS Security 1.1), in the file names of ROS 2 (SROS2). Start-up code of
// ordinary threads, except is_name_of(). See docs/security.md.

#include <dds/dds.h>

#include <array>
#include <chrono>
#include <filesystem>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

struct x509_st;  // X509 of OpenSSL

namespace lss::dds {

// The files of an enclave.
inline constexpr const char* kIdentityCa = "identity_ca.cert.pem";
inline constexpr const char* kPermissionsCa = "permissions_ca.cert.pem";
inline constexpr const char* kCertificate = "cert.pem";
inline constexpr const char* kKey = "key.pem";
inline constexpr const char* kGovernance = "governance.p7s";
inline constexpr const char* kPermissions = "permissions.p7s";
inline constexpr const char* kRevoked = "crl.pem";  // of the identity CA; optional

struct Enclave {
  std::filesystem::path folder;
  std::string name;                   // common name of its certificate
  std::string permissions;            // the signed text
  std::int64_t not_after_utc_s = 0;   // the first of its certificates to expire
  bool revokes = false;               // it has a list of revoked certificates
  std::vector<std::string> warnings;  // sentences that say what to do
};

// Reads and checks it: the certificate belongs to the key and to the identity CA, which has not
// revoked it, and both documents were signed by the permissions CA itself. (The plugin of Cyclone
// 0.10.2 accepts any signer with a certificate of that CA, CVE-2023-24011.) `clock_slack`: how far
// the clock may be before the beginning of a certificate, as on a computer without a clock battery;
// then this process checks no dates of certificates. `clock_may_cure`: set when the clock is before
// that beginning or behind the end, by however much.
tl::expected<Enclave, std::string> read_enclave(const std::filesystem::path& folder,
                                                std::chrono::days clock_slack = {},
                                                bool* clock_may_cure = nullptr);

// CN of the subject; empty: it has none.
std::string common_name(const x509_st* certificate);

// Lets a participant with this QoS use the enclave. The error says which plugin is missing.
tl::expected<void, std::string> use_enclave(dds_qos_t* qos, const Enclave& enclave);

// The part of a source before the first ':'; it must be the name of the enclave.
std::string_view name_of_source(std::string_view source);

// Whether an authenticated participant with this GUID has a certificate of that name: its first 47
// bits are a hash of the subject (DDS Security 1.1, 9.3.2.1), which the plugin checks. Thread-safe;
// some microseconds.
bool is_name_of(std::string_view name, const std::array<std::uint8_t, 16>& guid);
// Whether the enclave is that of the vehicle: names of ROS 2 have a '/' in front.
bool is_of_vehicle(std::string_view name, std::string_view vehicle_id);

}  // namespace lss::dds
