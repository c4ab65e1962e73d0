#pragma once

// What a client may say (docs/ground.md): one JSON object per message. Read strictly: an unknown
// type or key, a missing one, or another kind of value is an error with a sentence. Pure functions.

#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <variant>

namespace lss::ground {

// The first one on each connection.
struct Hello {
  std::string key;
  std::string session;  // chosen by the client; it keeps its name over a lost connection
};
// The heartbeat of a person who looks at the page.
struct Beat {
  std::uint64_t n = 0;  // told back
};
struct Order {
  std::uint64_t id = 0;  // of the client's own, in every answer
  std::string vehicle, command;
  std::map<std::string, double> parameters;  // by the names of the command table, in SI
  bool dry_run = false;                      // only asks
  bool whole = false;  // with what has to be done before it, from where the vehicle is
};
// Emergency stop; only on its own connection.
struct Stop {
  std::uint64_t id = 0;
  std::string vehicle;  // empty: all of them
  bool land = false;    // in flight: down in good order, instead
};
// Timed actuations, in the form of `lss-cli script`.
struct Script {
  std::uint64_t id = 0;
  std::string vehicle, text;
};

using Message = std::variant<Hello, Beat, Order, Stop, Script>;

inline constexpr std::size_t kMaxMessage = 32 * 1024;  // longer ones end the connection
inline constexpr std::size_t kMaxHello = 1024;         // before it is known who it is

tl::expected<Message, std::string> parse_message(std::string_view text);

}  // namespace lss::ground
