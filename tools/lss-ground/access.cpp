#include "tools/lss-ground/access.h"

#include <fmt/format.h>
#include <openssl/pem.h>
#include <openssl/sha.h>
#include <openssl/x509.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <fstream>
#include <iterator>
#include <memory>
#include <random>
#include <sstream>

namespace lss::ground {
namespace {

constexpr std::size_t kShortestKey = 16, kLongestKey = 128;
constexpr std::size_t kSourceBytes = 12;  // the size of lss::Command::source
constexpr Role kRoles[] = {Role::look, Role::stop, Role::command};

bool same(std::string_view a, std::string_view b) {
  if (a.size() != b.size()) return false;
  unsigned difference = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    difference |= static_cast<unsigned>(static_cast<unsigned char>(a[i] ^ b[i]));
  return difference == 0;
}

bool is_local_name(std::string_view host) {
  const bool v6 = host.starts_with('[');
  const std::size_t end = v6 ? host.find(']') : host.find(':');
  const std::string_view name = host.substr(0, v6 && end != host.npos ? end + 1 : end);
  const bool v4 = name.starts_with("127.") && name.find_first_not_of("0123456789.") == name.npos;
  return name == "localhost" || name == "[::1]" || v4;
}

tl::expected<std::string, std::string> read_file(const std::string& path) {
  std::ifstream file(path);
  try {
    if (file) return std::string(std::istreambuf_iterator<char>(file), {});
  } catch (const std::ios_base::failure&) {  // a folder, for example
  }
  return tl::unexpected("cannot read " + path +
                        ": is it a file that exists, and may this user read it?");
}

// Permission bits that let others read the file.
tl::expected<std::string, std::string> read_secret(const std::string& path) {
  auto text = read_file(path);
  struct stat info {};
  if (text && ::stat(path.c_str(), &info) == 0 && (info.st_mode & S_IRWXO) != 0)
    return tl::unexpected(fmt::format("others may read {0}: chmod o= {0}", path));
  return text;
}

using Bio = std::unique_ptr<BIO, decltype([](BIO* bio) { BIO_free(bio); })>;
Bio bytes_of(const std::string& text) {
  return Bio(BIO_new_mem_buf(text.data(), static_cast<int>(text.size())));
}

}  // namespace

const char* role_name(Role role) {
  static constexpr const char* kNames[] = {"none", "look", "stop", "command"};
  return kNames[static_cast<unsigned>(role)];
}

tl::expected<Door, std::string> Door::parse(std::string_view text, const std::string& name) {
  Door door;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line.substr(0, line.find('#')));
    const std::vector<std::string> all{std::istream_iterator<std::string>(words), {}};
    if (all.empty()) continue;
    const auto wrong = [&](const std::string& why) {
      return tl::unexpected(fmt::format("{}:{}: {}", name, number, why));
    };
    const auto* role =
        std::ranges::find_if(kRoles, [&](Role r) { return all.front() == role_name(r); });
    if (all.size() != 2 || role == std::end(kRoles))
      return wrong("a line is: look KEY, stop KEY, or command KEY");
    if (all[1].size() < kShortestKey || all[1].size() > kLongestKey) {
      return wrong(fmt::format("a key has {} to {} characters; make one with: openssl rand -hex 16",
                               kShortestKey, kLongestKey));
    }
    if (std::ranges::any_of(door.keys_, [&](const Key& k) { return k.text == all[1]; }))
      return wrong("this key was given before: each needs its own");
    door.keys_.push_back({*role, all[1]});
  }
  if (door.keys_.empty()) return tl::unexpected(name + " has no key: add a line: command KEY");
  return door;
}

tl::expected<Door, std::string> Door::read(const std::string& path) {
  const auto text = read_secret(path);
  if (!text) return tl::unexpected(text.error());
  return parse(*text, path);
}

tl::expected<void, std::string> check_tls(const std::string& certificate, const std::string& key) {
  const auto certificate_text = read_file(certificate), key_text = read_secret(key);
  if (!certificate_text) return tl::unexpected(certificate_text.error());
  if (!key_text) return tl::unexpected(key_text.error());
  const std::unique_ptr<X509, decltype([](X509* x) { X509_free(x); })> theirs(
      PEM_read_bio_X509(bytes_of(*certificate_text).get(), nullptr, nullptr, nullptr));
  if (!theirs) return tl::unexpected(certificate + " is no certificate in PEM");
  const auto no_password = [](char*, int, int, void*) {
    return -1;
  };  // otherwise OpenSSL asks on the terminal
  const std::unique_ptr<EVP_PKEY, decltype([](EVP_PKEY* k) { EVP_PKEY_free(k); })> ours(
      PEM_read_bio_PrivateKey(bytes_of(*key_text).get(), nullptr, no_password, nullptr));
  if (!ours) return tl::unexpected(key + " is no private key in PEM without a password");
  if (X509_check_private_key(theirs.get(), ours.get()) != 1)
    return tl::unexpected(fmt::format("{} is not the key of {}", key, certificate));
  return {};
}

Role Door::admit(std::string_view key) const {
  if (keys_.empty()) return Role::command;
  Role role = Role::none;
  for (const Key& k : keys_) {
    if (same(k.text, key)) role = k.role;
  }
  return role;
}

bool Listen::loopback() const { return address.starts_with("127.") || address == "::1"; }

tl::expected<Listen, std::string> parse_listen(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  std::string_view address = colon == text.npos ? "127.0.0.1" : text.substr(0, colon);
  const std::string_view port = colon == text.npos ? text : text.substr(colon + 1);
  const auto wrong = [&] {
    return tl::unexpected(fmt::format("'{}' is no address: ADDRESS:PORT, 127.0.0.1:8470", text));
  };
  Listen listen;
  const auto [end, error] = std::from_chars(port.data(), port.data() + port.size(), listen.port);
  if (error != std::errc{} || end != port.data() + port.size() || listen.port < 0 ||
      listen.port > 65535)
    return wrong();
  if (address.starts_with('[')) {
    if (!address.ends_with(']')) return wrong();
    address = address.substr(1, address.size() - 2);
  }
  listen.address = address == "localhost" ? "127.0.0.1" : std::string(address);
  if (listen.address.find_first_not_of("0123456789abcdefABCDEF.:") != std::string::npos)
    return wrong();
  return listen;
}

std::string source_of(std::string_view session, std::string_view name) {
  std::string secret(session);
  if (secret.size() < kShortestKey) {
    std::random_device device;
    for (int i = 0; i < 4; ++i) secret += fmt::format("{:08x}", device());
  }
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(secret.data()), secret.size(), digest.data());
  constexpr std::size_t kLongest = 31;  // of lss::Command::source
  return fmt::format("{}:{:02x}", name.empty() ? "ground" : name,
                     fmt::join(std::span(digest).first<kSourceBytes>(), ""))
      .substr(0, kLongest);
}

bool good_origin(std::string_view origin, std::string_view host, bool loopback, bool tls,
                 std::span<const std::string> more) {
  if (loopback && !is_local_name(host) && std::ranges::find(more, origin) == more.end())
    return false;
  if (origin.empty()) return true;
  if (std::ranges::find(more, origin) != more.end()) return true;
  for (const std::string_view scheme : {"https://", "http://"}) {
    if (origin.starts_with(scheme)) return origin.substr(scheme.size()) == host;
    if (tls) break;
  }
  return false;
}

}  // namespace lss::ground
