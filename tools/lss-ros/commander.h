#pragma once

// Sends commands and heartbeats to one daemon under any source, and hears all its answers. One
// thread.

#include <optional>
#include <string>

#include "idl/topics.h"
#include "lss.h"
#include "tools/lss-cli/session/commands.h"
#include "tools/lss-cli/session/wire.h"

namespace lss::ros {

class Commander {
 public:
  // The participant must outlive it. Throws a Failure.
  Commander(const dds::Participant& participant, std::string vehicle_id, std::uint32_t lease_ms);

  // Returns the sequence number.
  std::uint64_t send(const cli::Invocation& command, std::string_view source,
                     std::uint16_t flags = 0);
  void heartbeat(std::string_view source);
  std::optional<lss_CommandAck> next_ack();

 private:
  const dds::Participant& participant_;
  std::string vehicle_id_;
  std::uint32_t lease_ms_;
  dds::Entity command_writer_, heartbeat_writer_, ack_reader_;
  cli::Sequence sequence_;
  std::uint64_t heartbeats_ = 0;
};

}  // namespace lss::ros
