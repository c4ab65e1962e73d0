#include "tools/lss-cli/session/wire.h"

#include <chrono>

namespace lss::cli {
namespace {

std::uint64_t wall_clock_us() {
  using namespace std::chrono;
  return static_cast<std::uint64_t>(
      duration_cast<microseconds>(system_clock::now().time_since_epoch()).count());
}

}  // namespace

std::uint64_t Sequence::next() {
  return last_ = counts_ ? last_ + 1 : std::max(last_ + 1, wall_clock_us());
}

lss_Command to_dds(const Invocation& command, const Address& address) {
  lss_Command sample{};
  put(sample.vehicle_id, address.vehicle_id);
  put(sample.source, address.source);
  sample.seq = address.seq;
  sample.kind = command.info->kind;
  sample.flags = address.flags;
  sample.lease_ms = command.info->leased ? address.lease_ms : 0;
  std::ranges::copy(command.parameter, sample.parameter);
  put(sample.name, command.name);
  return sample;
}

lss_Heartbeat heartbeat_to_dds(std::string_view vehicle_id, std::string_view source,
                               std::uint64_t counter) {
  lss_Heartbeat sample{};
  put(sample.vehicle_id, vehicle_id);
  put(sample.source, source);
  sample.counter = counter;
  return sample;
}

}  // namespace lss::cli
