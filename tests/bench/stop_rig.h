#pragma once

// Rows iii and xiii: a client that stops a vehicle, the real daemon with its simulated vehicle and
// a line between them, the echo, and the load on either.

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "idl/topics.h"
#include "tests/bench/programs.h"
#include "tests/bench/stop_line.h"

namespace lss::bench {

// The vehicle's data for row xiii.
struct Stoppable {
  const char* name;           // as in lss-sim and config/NAME.toml
  std::vector<double> start;  // its parameters
  const char* mode;           // where it leads
  // There, when needed for a stop to be something else than what was before; 0: not needed.
  std::uint16_t then;
  std::vector<double> parameters;
  std::vector<std::pair<std::string, std::string>> config;  // key, value: other than in the file
  CanStopLine::IsStop is_stop;  // nullptr: the line is a pseudo-terminal
  TimeNs frame_ns;
  const char* echoed;  // the stop as it is on the line, hexadecimal
  std::string held_back{};
};

Stoppable lunar_zebro();

// A participant of its own that commands one vehicle.
class StopClient {
 public:
  StopClient(int domain, const std::string& vehicle_id);
  ~StopClient();
  StopClient(const StopClient&) = delete;
  StopClient& operator=(const StopClient&) = delete;

  static constexpr const char* kSource = "lss-bench";

  void wait_for_reader();  // of commands
  // Until it is executing; otherwise the daemon's answer, except "busy".
  std::string order(std::uint16_t kind, const std::vector<double>& parameters = {});
  // An emergency stop, again every 0.1 s; when it was sent first. `done` is asked every 0.1 ms.
  TimeNs stop(const std::function<bool()>& done);
  bool completed(std::uint64_t since_seq) const;
  std::uint64_t next_seq() const { return command_.seq + 1; }
  const lss_Status& status();       // the newest received
  const lss_Status& next_status();  // waits for it

 private:
  void send(std::uint16_t kind, const std::vector<double>& parameters);
  void heard(dds_entity_t reader);

  dds::Participant participant_;
  dds_listener_t* listener_;
  dds::Entity writer_, acks_, statuses_;
  lss_Command command_{};
  lss_Status status_{};
  mutable std::mutex mutex_;
  std::vector<lss_CommandAck> answers_;  // to messages since the last order
};

// Heartbeats and commands in the name of the client, at 20,000 a second.
class Load {
 public:
  Load(int domain, const std::string& vehicle_id);
  ~Load();

 private:
  Folder folder_;
  std::vector<std::unique_ptr<Process>> programs_;
};

class StopSubject {
 public:
  virtual ~StopSubject() = default;
  // From sending to the first byte of the stop on the line, us.
  virtual Samples stops_us(int count) = 0;
};

// lss-sim, line and lssd.
class StopDaemon : public StopSubject {
 public:
  StopDaemon(const Stoppable& vehicle, int domain);
  Samples stops_us(int count) override;
  // Stops by a program, from exec to the first byte of the stop on the line.
  Samples calls_ms(const std::vector<std::string>& words, int count);
  // Since the last call.
  struct Late {
    std::uint64_t frames = 0, late = 0;
    Late& operator+=(const Late& other) {
      frames += other.frames;
      late += other.late;
      return *this;
    }
  };
  Late late();

 private:
  void start_simulator();
  void start_daemon(int domain);
  void begin_motion();
  TimeNs moving();
  void expect_stopped();

  const Stoppable& vehicle_;
  Folder folder_;
  std::optional<Process> simulator_;
  std::unique_ptr<StopLine> line_;
  std::optional<Process> daemon_;
  std::optional<StopClient> client_;
  int stops_ = 0;
  std::uint64_t frames_ = 0, late_ = 0;
};

class StopEcho : public StopSubject {
 public:
  StopEcho(const Stoppable& vehicle, int domain);
  Samples stops_us(int count) override;

 private:
  Folder folder_;
  std::unique_ptr<StopLine> line_;
  std::optional<Process> echo_;
  std::optional<StopClient> client_;
};

}  // namespace lss::bench
