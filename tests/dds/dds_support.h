#pragma once

// Common part of the DDS tests: a domain of their own, bounded waits on conditions, child
// processes, a client that stands for lss-cli.

#include <sys/types.h>

#include <chrono>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "daemon/publish/face.h"
#include "idl/topics.h"
#include "tests/support/eventually.h"

namespace lss::testing_support {

// Every test process has its own, so that tests that run side by side do not meet. Not 0, where a
// real daemon may run; the ports of domains up to 100 lie below the ephemeral ones.
int test_domain();

// A child process, killed at the end when it still runs, also when the test is killed.
class Child {
 public:
  // `uri` is its CYCLONEDDS_URI; empty: none. Its standard output can be read, its standard error
  // is ours.
  explicit Child(const std::vector<std::string>& command, const std::string& uri = "");
  ~Child();
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  void signal(int number) const;
  void halt() const;  // SIGSTOP; returns when all its threads stand still
  // False when no such line came before the end of the output or the limit.
  bool wait_for_line(std::string_view part, std::chrono::seconds limit = testing_support::kHung);
  // Exit code, -signal, or nothing when it did not end in time.
  std::optional<int> wait_for_exit(std::chrono::seconds limit = testing_support::kHung);
  const std::string& output() const { return output_; }

 private:
  bool read_more(std::chrono::milliseconds limit);

  pid_t pid_ = -1;
  int pipe_ = -1;
  std::string output_;
  std::optional<int> exit_;
};

// How a stranger's DDS is configured for these tests.
std::string loopback_uri(bool shared_memory);

// Requests that a face handed to its sink; the sink may come from any thread.
class Requests {
 public:
  RequestSink sink();
  std::vector<Request> all() const;
  std::vector<std::uint64_t> writers() const;  // of each of them
  std::vector<Request> commands() const;       // without heartbeats
  std::vector<Request> heartbeats() const;

 private:
  mutable std::mutex mutex_;
  std::vector<Request> requests_;
  std::vector<std::uint64_t> writers_;
};

// The other end of the control plane, with the QoS of idl/topics.h as lss-cli has it.
class Client {
 public:
  Client(int domain, const std::string& vehicle_id, const std::string& source = "client");

  bool connected() const;                         // its writers and readers know the daemon's
  lss_Command command(std::uint16_t kind) const;  // filled in but for parameters
  bool send(const lss_Command& command);
  bool send(const lss_Heartbeat& heartbeat);
  // Everything taken so far.
  const std::vector<lss_CommandAck>& acks() { return take(ack_, acks_); }
  const std::vector<lss_Event>& events() { return take(event_, events_); }
  const std::vector<lss_Status>& statuses() { return take(status_, statuses_); }
  const std::vector<lss_Heartbeat>& heartbeats() { return take(heartbeat_, heartbeats_); }

 private:
  template <class Sample>
  static const std::vector<Sample>& take(const dds::Entity& reader, std::vector<Sample>& into);

  std::string vehicle_id_, source_;
  mutable std::uint64_t sequence_ = 0;
  dds::Participant participant_;
  dds::Entity command_, heartbeat_out_, ack_, event_, status_, heartbeat_;
  std::vector<lss_CommandAck> acks_;
  std::vector<lss_Event> events_;
  std::vector<lss_Status> statuses_;
  std::vector<lss_Heartbeat> heartbeats_;
};

template <class Sample>
const std::vector<Sample>& Client::take(const dds::Entity& reader, std::vector<Sample>& into) {
  Sample sample;
  void* pointer = &sample;
  dds_sample_info_t info;
  while (dds_take(reader.get(), &pointer, &info, 1, 1) > 0) {
    if (info.valid_data) into.push_back(sample);
  }
  return into;
}

FaceParameters face_parameters(const std::string& vehicle_id, bool shared_memory = false);

// Value of an expected that must be one.
template <class T>
T value(tl::expected<T, std::string> result) {
  if (!result) throw std::runtime_error(result.error());
  return std::move(*result);
}
template <class T>
T value(tl::expected<T, Refusal> result) {
  if (!result) throw std::runtime_error(result.error().text);
  return std::move(*result);
}

}  // namespace lss::testing_support
