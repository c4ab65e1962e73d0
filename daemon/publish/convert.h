#pragma once

// Conversion between the daemon's plain structs and the DDS types of idl/lss.idl, and the sentences
// in acknowledgements and events. Pure functions but for the wall clock; any thread that is not a
// real-time one.

#include <algorithm>
#include <cstddef>
#include <cstring>
#include <optional>
#include <string>
#include <string_view>

#include "daemon/cycle/messages.h"
#include "lss.h"

namespace lss::dds {

// Into a char array of the IDL: truncated where it does not fit, terminated, and zeroed to the end,
// since key fields are compared whole.
template <std::size_t N>
void copy_text(std::string_view from, char (&to)[N]) {
  const std::size_t length = std::min(from.size(), N - 1);
  std::memcpy(to, from.data(), length);
  std::memset(to + length, 0, N - length);
}

// Empty optional: not terminated within its field.
template <std::size_t N>
std::optional<std::string_view> read_text(const char (&from)[N]) {
  const std::size_t length = ::strnlen(from, N);
  if (length == N) return {};
  return std::string_view(from, length);
}

// A source that is not terminated becomes the empty one, which the armour rejects. The name of a
// parameter is taken as it came.
Request to_request(const lss_Command& command, TimeNs arrival_ns);
Request to_request(const lss_Heartbeat& heartbeat, TimeNs arrival_ns);

// Names of subjects: modules[n - 1], or the name of a parameter, of the vehicle or of the command.
struct Subjects {
  std::span<const char* const> modules{};
  std::span<const TunableInfo> tunables{};
  std::span<const CommandInfo> commands{};  // the vehicle's own
  std::string_view name{};                  // of a parameter, in the command
};

lss_CommandAck to_dds(const Ack& ack, std::string_view vehicle_id, const Subjects& subjects = {});
lss_Event to_dds(const EventRecord& record, std::string_view text, std::string_view vehicle_id,
                 std::uint64_t index);
// Fields of the face (version, vehicle, shared memory) stay empty.
lss_Status to_dds(const StatusReport& report, std::string_view vehicle_id);
void to_dds(const TimingPoints& points, std::string_view vehicle_id, lss_Timing& to);
void to_dds(const TimingStatistics& statistics, std::string_view vehicle_id,
            lss_TimingStatistics& to);
void to_dds(const ParameterReport& report, std::string_view vehicle_id, lss_Parameters& to);

// "rejected: module 3 (LM) does not answer (measured 5000, allowed 200); check its power and the
// bus, ..."; "rejected: limits.current_A: 12 A is out of range, allowed 0.05 to 1.7 A; ...";
// "rejected: parameter speed is out of range (measured 7, allowed 3); ..."
std::string ack_text(const Ack& ack, const Subjects& subjects = {});

}  // namespace lss::dds
