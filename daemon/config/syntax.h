#pragma once

// Syntax of names and addresses in a configuration. Time is linear in the length of the text; no
// memory. Pure functions.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace lss::config {

// 1 to `longest` letters, digits, and characters of `also`.
bool is_name(std::string_view text, std::size_t longest, std::string_view also);
// Absolute, without blanks, and no folder: "/dev/ttyS1".
bool is_path(std::string_view text, std::size_t longest);
// canN or vcanN.
bool is_can(std::string_view text);

// "udp://HOST:PORT", optionally followed by "?...".
struct UdpAddress {
  std::string_view host, port, rest;
};
std::optional<UdpAddress> udp_address(std::string_view text);

// Error in the path of a port and its correction; nothing when it is well-formed.
std::optional<std::string> path_fault(std::string_view path);

}  // namespace lss::config
