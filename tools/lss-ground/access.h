#pragma once

// Who gets in and what for. Without keys everybody who reaches the address may do everything, which
// is why it is then the machine's own (main.cpp sees to it). Pure functions but for reading the
// file; a key is never logged.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace lss::ground {

// Each may do what the one before it may.
enum class Role : std::uint8_t {
  none,     // not yet told who it is, or nobody
  look,     // see everything
  stop,     // and stop any vehicle at once
  command,  // and command
};
const char* role_name(Role role);

class Door {
 public:
  // A line each: look|stop|command KEY; # begins a comment. Errors are sentences with the line.
  static tl::expected<Door, std::string> parse(std::string_view text, const std::string& name);
  // The same from a file that others must not be able to read.
  static tl::expected<Door, std::string> read(const std::string& path);

  bool locked() const { return !keys_.empty(); }
  // Takes as long for a wrong key as for a right one of the same length.
  Role admit(std::string_view key) const;

 private:
  struct Key {
    Role role;
    std::string text;
  };
  std::vector<Key> keys_;
};

// The files of TLS, before the server takes them; an error is a sentence about one of them.
tl::expected<void, std::string> check_tls(const std::string& certificate, const std::string& key);

// "127.0.0.1:8470", "[::1]:8470", "localhost:8470", ":8470" (every interface), "8470" (loopback).
struct Listen {
  std::string address;  // a number; empty: every interface
  int port = 0;         // 0: any that is free

  bool loopback() const;
};
tl::expected<Listen, std::string> parse_listen(std::string_view text);

// The name that a client commands under, "ground:" and 96 bits, from what only it knows: who sees
// the name cannot take it, nor find a session that has the same one. Another one each time without
// a session.
std::string source_of(std::string_view session);

// Browsers tell which page opened a connection: only ours may, under the name that it was asked for
// by, so that a page from elsewhere commands nothing with the browser of somebody who may. Empty
// origin: no browser. On loopback the name has to be one of this machine: a foreign name that leads
// here is somebody's trick. With TLS a page that came without it, forged on the way, is not ours.
// `more`: origins besides, of a proxy.
bool good_origin(std::string_view origin, std::string_view host, bool loopback, bool tls,
                 std::span<const std::string> more);

}  // namespace lss::ground
