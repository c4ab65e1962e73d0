#pragma once

// The common fields of commands and samples, for all clients. No thread of its own.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/session/commands.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli {

// The value. Throws a Failure with the error.
template <class T>
T checked(dds::Result<T> result) {
  if (!result) throw Failure(ExitCode::internal, result.error());
  return std::move(*result);
}

template <class T>
T checked(tl::expected<T, Refusal> result) {
  if (!result) throw Failure(ExitCode::internal, result.error().text);
  return std::move(*result);
}

template <std::size_t N>
std::string_view text(const char (&field)[N]) {
  const std::string_view all(field, N);
  return all.substr(0, all.find('\0'));
}

template <std::size_t N>
void put(char (&field)[N], std::string_view text) {
  const std::size_t size = std::min(text.size(), N - 1);
  text.copy(field, size);
  field[size] = '\0';
}

// Of one start of one daemon.
inline bool is_same(const lss_Instance& a, const lss_Instance& b) {
  return a.boot == b.boot && a.started_utc_ns == b.started_utc_ns && a.pid == b.pid &&
         text(a.host) == text(b.host);
}

// Sequence numbers from the clock, so that they increase across programs that use one name one
// after the other.
class Sequence {
 public:
  std::uint64_t next();
  // In simulated time: 1, 2, 3 and so on.
  void from_one() { last_ = 0, counts_ = true; }

 private:
  std::uint64_t last_ = 0;
  bool counts_ = false;
};

struct Address {
  std::string_view vehicle_id, source;
  std::uint64_t seq = 0;
  std::uint16_t flags = 0;
  std::uint32_t lease_ms = 0;  // of commands that have one
};

lss_Command to_dds(const Invocation& command, const Address& address);
lss_Heartbeat heartbeat_to_dds(std::string_view vehicle_id, std::string_view source,
                               std::uint64_t counter);

}  // namespace lss::cli
