// Row iii: a command from a client to its acknowledgement by the daemon, against an echo in plain C
// on the same topics with the same client, and against ddsperf; and a whole call of lss-cli against
// the least client in C. Over loopback UDP, as the control plane always goes.

#include <atomic>
#include <cstdlib>
#include <cstring>
#include <semaphore>

#include "daemon/runtime/clock.h"
#include "idl/commands.h"
#include "idl/topics.h"
#include "tests/bench/programs.h"
#include "tests/bench/realtime.h"

namespace lss::bench {
namespace {

constexpr auto kKind = static_cast<std::uint16_t>(CommandKind::request_data);

// Sends a command from within the listener as soon as the one before is acknowledged.
class Pinger {
 public:
  explicit Pinger(int domain, const std::filesystem::path& enclave = {})
      : participant_(value(dds::Participant::create({.domain = domain, .enclave = enclave}))),
        listener_(dds_create_listener(this)),
        writer_(
            value(dds::create_writer(participant_.get(), dds::common_topic(dds::Kind::command)))) {
    dds_lset_data_available(listener_, [](dds_entity_t reader, void* self) {
      static_cast<Pinger*>(self)->heard(reader);
    });
    reader_ =
        value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::command_ack),
                                 dds::Transport::best, listener_));
    std::strcpy(command_.vehicle_id, "zebro-1");
    std::strcpy(command_.source, "lss-bench");
    command_.kind = kKind;
    command_.flags = kFlagDryRun;
    // Messages sent before both ends are matched are not answered.
    if (!eventually([this] { return !times_us(1).empty(); }))
      throw NotHere("nobody acknowledges commands: is loopback up, and multicast allowed on it?");
  }
  ~Pinger() {
    reader_.reset();
    dds_delete_listener(listener_);
  }
  Pinger(const Pinger&) = delete;
  Pinger& operator=(const Pinger&) = delete;

  Samples times_us(int count) {
    times_us_.clear();
    times_us_.reserve(static_cast<std::size_t>(count));
    left_ = count;
    send();
    if (!over_.try_acquire_for(std::chrono::milliseconds(200 + count))) left_ = 0;
    return times_us_;
  }

 private:
  void send() {
    ++command_.seq;
    sent_ns_ = now_ns();
    dds_write(writer_.get(), &command_);
  }
  void heard(dds_entity_t reader) {
    void* pointer = &ack_;
    dds_sample_info_t info;
    while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
      const TimeNs now = now_ns();
      if (!info.valid_data || ack_.seq != command_.seq || left_ == 0) continue;
      times_us_.push_back(static_cast<double>(now - sent_ns_) * 1e-3);
      if (--left_ > 0) {
        send();
      } else {
        over_.release();
      }
    }
  }

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

// The median round trip as ddsperf says it, which is half of it.
Samples ddsperf_us(int domain) {
  Folder folder;
  const std::string id = std::to_string(domain);
  std::optional<Process> pong;
  {
    const OnCpu servers(measured_cpu());
    pong.emplace(std::vector<std::string>{"ddsperf", "-i", id, "pong"}, folder / "pong.log",
                 Process::Environment{loopback()});
  }
  Process ping({"ddsperf", "-i", id, "-D", "2.5", "ping", "size", "200"}, folder / "ping.log",
               {loopback()});
  ping.wait();
  const std::string said = read_file(folder / "ping.log");
  const std::size_t at = said.rfind(" 50% ");
  if (at == std::string::npos) throw NotHere("ddsperf does not measure round trips here");
  return {2 * std::strtod(said.c_str() + at + 5, nullptr)};
}

Samples call_ms(const std::vector<std::string>& words,
                const std::pair<std::string, std::string>& variable, int count) {
  Folder folder;
  Samples times;
  for (int i = 0; i < count; ++i) {
    Process call(words, folder / "call.log", {variable});
    if (const int code = call.wait(); code != 0)
      throw std::runtime_error(words.front() + " failed: " + read_file(folder / "call.log"));
    times.push_back(static_cast<double>(now_ns() - call.started_ns()) * 1e-6);
  }
  return times;
}

// Its enclaves/: the daemon's, and that of this program.
std::filesystem::path make_keystore(const std::filesystem::path& folder) {
  const std::string keys = folder / "keys", cli = program("lss-cli");
  for (const std::vector<std::string>& words : {std::vector<std::string>{"create", keys},
                                                {"add", keys, "zebro-1", "--role", "vehicle"},
                                                {"add", keys, "lss-bench", "--role", "command"}}) {
    std::vector<std::string> line{cli, "keystore"};
    line.insert(line.end(), words.begin(), words.end());
    Process call(line, folder / "keys.log");
    if (call.wait() != 0) throw NotHere(read_file(folder / "keys.log"));
  }
  return folder / "keys/enclaves";
}

}  // namespace

Figures command_to_ack(const Options& options) {
  const int daemon_domain = domain(0), echo_domain = domain(1);
  Folder folder;
  const int secured_domain = domain(3);
  const std::filesystem::path enclaves = make_keystore(folder);
  std::optional<Daemon> daemon, secured;
  std::optional<Process> echo;
  // Servers on one CPU, clients on the other: else a round trip is three times shorter whenever the
  // scheduler puts both onto one.
  {
    const OnCpu servers(measured_cpu());
    daemon.emplace(daemon_domain, false);
    secured.emplace(secured_domain, false, enclaves / "zebro-1");
    echo.emplace(std::vector<std::string>{program("bench-dds-echo"), std::to_string(echo_domain)},
                 folder / "echo.log", Process::Environment{loopback()});
  }
  const OnCpu clients(kHardwareCpu);
  Pinger to_daemon(daemon_domain), to_echo(echo_domain);
  Pinger to_secured(secured_domain, enclaves / "lss-bench");

  const int pings = options.count(2000, 200);
  const Rounds rounds = turn_by_turn([&] { return to_daemon.times_us(pings); },
                                     [&] { return to_echo.times_us(pings); });
  Figures figures{figure("iii", "command to acknowledgement, p50", "us", rounds, median, 1.25),
                  figure("iii", "command to acknowledgement, p99", "us", rounds, p99, kNone)};

  const Rounds security = turn_by_turn([&] { return to_secured.times_us(pings); },
                                       [&] { return to_daemon.times_us(pings); });
  figures.push_back(noted(
      figure("iii", "command to acknowledgement with DDS Security, p50", "us", security, median, 2),
      "against the same daemon without"));

  if (options.quick) {
    figures.push_back(not_measured("iii", "command to acknowledgement against ddsperf",
                                   "left out by --quick, ddsperf speaks once a second"));
  } else {
    const Rounds against = turn_by_turn([&] { return Samples{median(to_daemon.times_us(pings))}; },
                                        [&] { return ddsperf_us(domain(2)); });
    figures.push_back(
        noted(figure("iii", "command to acknowledgement against ddsperf", "us", against, median, 1),
              "medians; ddsperf with 200 bytes"));
  }

  const int calls = options.count(4, 1);
  const std::string id = std::to_string(daemon_domain);
  const std::vector<std::string> cli{program("lss-cli"), "--domain", id,         "--vehicle",
                                     "zebro-1",          "stop",     "--dry-run"};
  const std::vector<std::string> client{program("bench-dds-client"), id, "zebro-1",
                                        std::to_string(static_cast<int>(CommandKind::stop)),
                                        std::to_string(kFlagDryRun)};
  const Rounds whole = turn_by_turn(
      [&] {
        return call_ms(cli, {"LSS_SOURCE", "lss-bench-cli"}, calls);
      },
      [&] { return call_ms(client, loopback(), calls); });
  figures.push_back(
      held_back(noted(figure("iii", "whole call of lss-cli, p50", "ms", whole, median, 1.5),
                      "stop --dry-run --vehicle; reference: the same by the client in C"),
                "waits for the vehicle's status, and for the match of its two writers"));
  return figures;
}

}  // namespace lss::bench
