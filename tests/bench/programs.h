#pragma once

// Programs that rows start: the daemon, the simulator, the references, cyclictest. All are ended by
// the end of their object, and end with lss-bench.

#include <sched.h>
#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <optional>
#include <string>
#include <tl/expected.hpp>
#include <vector>

#include "drivers/time.h"
#include "idl/refusal.h"
#include "tests/bench/bench.h"
#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"
#include "tests/support/temp_folder.h"

namespace lss::bench {

template <class T>
T value(tl::expected<T, std::string> result) {
  if (!result) throw NotHere(result.error());
  return std::move(*result);
}
template <class T>
T value(tl::expected<T, Refusal> result) {
  if (!result) throw NotHere(result.error().text);
  return std::move(*result);
}

using testing_support::eventually;
using testing_support::RoudiLock;
using Folder = testing_support::TempFolder;

// Programs of this build, which stand beside lss-bench; references are made for it alone.
std::string program(const std::string& name);

// config/VEHICLE.toml.
std::string shipped_config(const std::string& vehicle);
// With `key = to` instead of what the text has; throws when it has no such key.
std::string edited(std::string text, const std::string& key, const std::string& to);

class Process {
 public:
  using Environment = std::vector<std::pair<std::string, std::string>>;

  // Output goes to the file, which is replaced. Throws NotHere when the program cannot be run.
  Process(const std::vector<std::string>& words, const std::filesystem::path& output,
          const Environment& environment = {});
  ~Process();  // kill -9 when it still runs
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t pid() const { return pid_; }
  TimeNs started_ns() const { return started_ns_; }  // just before the fork
  bool said(const std::string& text) const;
  bool running();
  void signal(int number) const;
  // Exit code, or -signal. Throws when it does not end in time.
  int wait(std::chrono::seconds limit = std::chrono::seconds(30));
  double peak_mb() const { return peak_mb_; }  // resident memory, at the last look of wait()

 private:
  std::string name_;
  std::filesystem::path output_;
  pid_t pid_ = -1;
  TimeNs started_ns_ = 0;
  std::optional<int> exit_;
  double peak_mb_ = 0;
};

std::string read_file(const std::filesystem::path& path);
double rss_mb(pid_t pid);

// CPU time that everybody else, and the host, took between construction and share().
class Others {
 public:
  Others();
  double share() const;  // of all CPUs; what is below a few percent is the kernel's for us

 private:
  TimeNs begin_ns_;
  double begin_s_;
};

// During its lifetime the calling thread and its children run on that CPU.
class OnCpu {
 public:
  explicit OnCpu(int cpu);
  ~OnCpu();
  OnCpu(const OnCpu&) = delete;
  OnCpu& operator=(const OnCpu&) = delete;

 private:
  cpu_set_t before_;
};

// Where services say READY=1 (sd_notify).
class ReadySocket {
 public:
  explicit ReadySocket(const std::filesystem::path& folder);
  ~ReadySocket();
  ReadySocket(const ReadySocket&) = delete;
  ReadySocket& operator=(const ReadySocket&) = delete;

  std::pair<std::string, std::string> variable() const { return {"NOTIFY_SOCKET", path_}; }
  // The time of reception; throws after the time limit.
  TimeNs wait(std::chrono::seconds limit = std::chrono::seconds(20));

 private:
  std::string path_;
  int fd_ = -1;
};

// DDS on loopback for programs that are configured by their environment.
std::pair<std::string, std::string> loopback(bool shared_memory = false);
// Domains of this run: 0, 1, ... are different, and different from other runs at the same time.
inline int domain(int index) { return testing_support::own_domain(index); }

// A program that says READY=1; it has when the constructor of the derived class returns.
class Service {
 public:
  pid_t pid() const { return process_->pid(); }
  TimeNs exec_to_ready_ns() const { return ready_ns_ - process_->started_ns(); }

 protected:
  Service() = default;
  void start(const std::vector<std::string>& words, Process::Environment environment);

  Folder folder_;

 private:
  std::optional<Process> process_;
  TimeNs ready_ns_ = 0;
};

// lssd with config/zebro.toml, and no hardware at its port.
class Daemon : public Service {
 public:
  // `enclave`: of DDS Security; empty: none.
  Daemon(int domain, bool shared_memory, const std::filesystem::path& enclave = {},
         const std::string& vehicle_id = "zebro-1");
};

// cyclictest at a priority on a CPU; ends by itself.
class Cyclictest {
 public:
  // Finer than it is long: in nanoseconds latencies above 1 ms are distinguished only by their
  // maximum.
  enum class Unit { nanoseconds, microseconds };
  // In a machine that counts instructions, all of which cost time of the host: idle CPUs sleep, as
  // they do without cyclictest, and the histogram that it prints is short.
  static inline bool counts_instructions = false;
  Cyclictest(int priority, TimeNs period_ns, int cycles, int cpu, Unit unit = Unit::nanoseconds);
  // Latencies in microseconds, when it has ended. In order of size, not of time.
  Samples latencies();

 private:
  Folder folder_;
  int cycles_;
  double unit_us_;
  std::optional<Process> process_;
};

// A RouDi of our own with the configuration of the project.
class Roudi {
 public:
  Roudi();

 private:
  Folder folder_;
  std::optional<Process> process_;
};

}  // namespace lss::bench
