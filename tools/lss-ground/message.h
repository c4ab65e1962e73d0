#pragma once

// Messages from clients (docs/ground.md): one JSON object per message. Strict: an unknown type or
// key, a missing key, or a value of another type is an error with a sentence. Pure functions.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

namespace lss::ground {

inline constexpr std::uint32_t kMinLease_ms = 300, kMaxLease_ms = 60'000;

// The first one on each connection.
struct Hello {
  std::string key;
  std::string session;  // chosen by the client; it keeps its name over a lost connection
};
// The heartbeat of a person who looks at the page.
struct Beat {
  std::uint64_t n = 0;  // sent back
};
struct Order {
  std::uint64_t id = 0;  // of the client's own, in every answer
  std::string vehicle, command;
  std::map<std::string, double> parameters;  // by the names of the command table, in SI
  std::string name;                          // of a parameter, of set-parameter
  bool dry_run = false;                      // dry run
  bool whole = false;  // with the commands that must precede it in the present state
  std::uint32_t lease_ms = kMaxLease_ms;  // of a motion, where it is shorter than the gateway's
};
// Emergency stop; only on its own connection.
struct Stop {
  std::uint64_t id = 0;
  std::string vehicle;  // empty: all of them
  bool land = false;    // in flight: a landing instead
};
// Timed actuations, in the form of `lss-cli script`.
struct Script {
  std::uint64_t id = 0;
  std::string vehicle, text;
};

using Message = std::variant<Hello, Beat, Order, Stop, Script>;

inline constexpr std::size_t kMaxMessage = 32 * 1024;  // longer ones end the connection
inline constexpr std::size_t kMaxHello = 1024;         // before authentication

tl::expected<Message, std::string> parse_message(std::string_view text);

}  // namespace lss::ground
