#pragma once

// Clients of the daemon that several rows measure: one that sends commands as fast as they are
// acknowledged, whole calls of programs, and the keystore for DDS Security.

#include <atomic>
#include <filesystem>
#include <semaphore>
#include <string>
#include <vector>

#include "idl/topics.h"
#include "tests/bench/programs.h"

namespace lss::bench {

// Sends a command from within the listener as soon as the one before is acknowledged.
class Pinger {
 public:
  explicit Pinger(int domain, const std::filesystem::path& enclave = {});
  ~Pinger();
  Pinger(const Pinger&) = delete;
  Pinger& operator=(const Pinger&) = delete;

  Samples times_us(int count);

 private:
  void send();
  void heard(dds_entity_t reader);

  dds::Participant participant_;
  dds_listener_t* listener_;
  dds::Entity writer_, reader_;
  lss_Command command_{};
  lss_CommandAck ack_{};
  TimeNs sent_ns_ = 0;
  std::atomic<int> left_{0};
  Samples times_us_;
  std::binary_semaphore over_{0};
};

// From exec to the end, of each of so many calls.
Samples call_ms(const std::vector<std::string>& words,
                const std::pair<std::string, std::string>& variable, int count);

// The words of a call of lss-cli that has a command of Lunar Zebro acknowledged and moves nothing.
std::vector<std::string> stop_dry_run(int domain);

// The newest status of the daemon of that domain, when it has run for so many frames.
lss_Status status_after(int domain, std::uint64_t frames);

// By lss-cli keystore, in that folder. Returns its enclaves/: zebro-1, and kPilot.
inline constexpr const char* kPilot = "lss-bench";
std::filesystem::path make_keystore(const std::filesystem::path& folder);

}  // namespace lss::bench
