#pragma once

// RouDi processes of the tests' own, and a face that publishes meanwhile. There can be one RouDi on
// a machine, so a test that starts one takes a lock that all test processes share.

#include <atomic>
#include <csignal>
#include <optional>
#include <string>
#include <thread>

#include "daemon/publish/face.h"
#include "tests/dds/dds_support.h"

namespace lss::testing_support {

// No RouDi but ours on this machine while it exists.
class Alone {
 public:
  Alone();

 private:
  RoudiLock lock_;
};

class Roudi {
 public:
  Roudi();   // returns when it runs
  ~Roudi();  // kill -9: RouDi would terminate its clients when asked to end
  Roudi(const Roudi&) = delete;
  Roudi& operator=(const Roudi&) = delete;

  void kill();  // returns when it is gone
  void halt() const { process_->halt(); }
  void go_on() const { process_->signal(SIGCONT); }
  const std::string& log_file() const { return log_file_; }

 private:
  std::string log_file_;
  std::optional<Child> process_;
};

// A face that publishes telemetry every few milliseconds and looks after RouDi, as the publish
// thread does.
class Publisher {
 public:
  explicit Publisher(Face& face);
  ~Publisher();

  // Stops the whole process, between two samples. Inside of one it could not be survived, see
  // docs/dds.md.
  void stop_process() { stops_process_ = true; }

  // UDP datagrams that its thread sent so far.
  std::uint64_t datagrams() const { return datagrams_; }
  std::uint64_t samples() const { return samples_; }
  std::uint64_t changes() const { return changes_; }  // how often watch_shared_memory() said true

 private:
  Face& face_;
  std::atomic<std::uint64_t> datagrams_{0}, samples_{0}, changes_{0};
  std::atomic<bool> stops_process_{false};
  std::jthread thread_;
};

// A scenario runs in a process of its own, since iceoryx has one life per process, and ends by
// exit(0), because the exit is part of the test. Any error ends it at once.
void require(bool truth, const std::string& what);

}  // namespace lss::testing_support
