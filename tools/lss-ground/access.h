#pragma once

// Access and roles of clients. Without keys, every client that reaches the address may do
// everything, so the address is then loopback (main.cpp checks this). Pure functions except for
// reading the file; a key is never logged.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace lss::ground {

// Each role includes the rights of the one before it.
enum class Role : std::uint8_t {
  none,     // not yet authenticated, or unknown
  look,     // see everything
  stop,     // and stop any vehicle at once
  command,  // and command
};
const char* role_name(Role role);

class Door {
 public:
  // One line for each key: look|stop|command KEY; # begins a comment. Errors are sentences with the
  // line.
  static tl::expected<Door, std::string> parse(std::string_view text, const std::string& name);
  // The same from a file; it must not be readable by others.
  static tl::expected<Door, std::string> read(const std::string& path);

  bool locked() const { return !keys_.empty(); }
  // Takes the same time for a wrong key as for a right one of the same length.
  Role admit(std::string_view key) const;

 private:
  struct Key {
    Role role;
    std::string text;
  };
  std::vector<Key> keys_;
};

// Checks the TLS files before the server uses them; an error is a sentence about one of them.
tl::expected<void, std::string> check_tls(const std::string& certificate, const std::string& key);

// "127.0.0.1:8470", "[::1]:8470", "localhost:8470", ":8470" (every interface), "8470" (loopback).
struct Listen {
  std::string address;  // a number; empty: every interface
  int port = 0;         // 0: any free port

  bool loopback() const;
};
tl::expected<Listen, std::string> parse_listen(std::string_view text);

// The source name of a client: "ground:" and 96 bits, derived from its secret session. A reader of
// the name can neither use it nor find a session with the same name. Without a session the name is
// new each time.
// `name`: with DDS Security that of the certificate, instead of "ground"; the digits that do not
// fit are left out.
std::string source_of(std::string_view session, std::string_view name = {});

// A browser sends the origin of the page that opens a connection. Only our own page is accepted,
// under the host name of the request, so that a foreign page cannot send commands through an
// authorised browser. Empty origin: not a browser. On loopback the name must be one of this
// machine: a foreign name that resolves to loopback is an attack (DNS rebinding). With TLS, a page
// that was loaded without TLS is not accepted. `more`: additional origins, for a proxy.
bool good_origin(std::string_view origin, std::string_view host, bool loopback, bool tls,
                 std::span<const std::string> more);

}  // namespace lss::ground
