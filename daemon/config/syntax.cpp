#include "daemon/config/syntax.h"

#include <algorithm>
#include <charconv>

namespace lss::config {
namespace {

constexpr std::string_view kDigits = "0123456789";

bool is_letter_or_digit(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9');
}

// 1 to `longest` digits.
bool is_number(std::string_view text, std::size_t longest) {
  return !text.empty() && text.size() <= longest &&
         text.find_first_not_of(kDigits) == std::string_view::npos;
}

// Needs is_number(text).
int number(std::string_view text) {
  int value = 0;
  std::from_chars(text.data(), text.data() + text.size(), value);
  return value;
}

// The text before the separator, which is removed too; all of it when there is none.
std::string_view take_until(std::string_view& rest, char separator) {
  const std::string_view part = rest.substr(0, rest.find(separator));
  rest.remove_prefix(std::min(rest.size(), part.size() + 1));
  return part;
}

}  // namespace

bool is_name(std::string_view text, std::size_t longest, std::string_view also) {
  return !text.empty() && text.size() <= longest && std::ranges::all_of(text, [also](char c) {
    return is_letter_or_digit(c) || also.find(c) != std::string_view::npos;
  });
}

bool is_path(std::string_view text, std::size_t longest) {
  return text.size() >= 2 && text.size() <= longest && text.front() == '/' && text.back() != '/' &&
         text.find_first_of(" \t\n\v\f\r") == std::string_view::npos;
}

bool is_can(std::string_view text) {
  if (text.starts_with('v')) text.remove_prefix(1);
  return text.starts_with("can") && is_number(text.substr(3), 4);
}

std::optional<UdpAddress> udp_address(std::string_view text) {
  constexpr std::string_view kUdp = "udp://";
  if (!text.starts_with(kUdp)) return std::nullopt;
  text.remove_prefix(kUdp.size());
  const std::size_t query = std::min(text.find('?'), text.size());
  UdpAddress address{.host = {}, .port = {}, .rest = text.substr(query)};
  text = text.substr(0, query);
  address.host = take_until(text, ':');
  address.port = text;
  if (address.host.empty() || !is_number(address.port, 5)) return std::nullopt;
  return address;
}

std::optional<std::string> path_fault(std::string_view path) {
  constexpr std::string_view kSimulated = "sim:", kLocal = "?local=";
  if (path.starts_with(kSimulated)) {
    const std::string_view name = path.substr(kSimulated.size());
    if (is_name(name, name.size(), "_.-") && name.front() != '.') return std::nullopt;
  }
  if (is_path(path, path.size()) || is_can(path)) return std::nullopt;
  const std::string no_port =
      "is no port; write sim:NAME, /dev/DEVICE, canN or udp://127.0.0.1:PORT";
  const auto udp = udp_address(path);
  if (!udp) return no_port;
  const bool local = !udp->rest.empty();
  const std::string_view back =
      local ? udp->rest.substr(std::min(kLocal.size(), udp->rest.size())) : std::string_view();
  if (local && (!udp->rest.starts_with(kLocal) || !is_number(back, 5))) return no_port;
  std::string_view host = udp->host;
  bool valid = true;
  for (int i = 0; i < 4; ++i) {
    const std::string_view part = take_until(host, '.');
    if (!is_number(part, 3) || (i < 3 && host.empty())) return no_port;
    valid = valid && number(part) <= 255;
  }
  if (!host.empty() || udp->host.ends_with('.')) return no_port;
  if (!valid) return "has no valid IPv4 address";
  for (const std::string_view port : {udp->port, back}) {
    if (!port.empty() && (number(port) < 1 || number(port) > 65'535))
      return "has a UDP port out of range 1 to 65535";
  }
  return std::nullopt;
}

}  // namespace lss::config
