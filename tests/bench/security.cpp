// Row xv: DDS Security. The daemon with an enclave of lss-cli keystore against the same daemon
// without, side by side: command to acknowledgement, how long a client takes from its start until
// its first command is acknowledged, and the CPU time that the daemon needs while telemetry is
// read. With the keystore every topic is protected in the same way (docs/security.md).

#include <fmt/format.h>

#include <ctime>
#include <sstream>
#include <thread>

#include "daemon/runtime/clock.h"
#include "tests/bench/clients.h"
#include "tests/bench/realtime.h"
#include "zebro.h"

namespace lss::bench {
namespace {

constexpr double kOfUnsecured = 2, kDiscovery_s = 2;  // at most

// Reads telemetry, so that the daemon sends it.
class Reader {
 public:
  Reader(int domain, const std::filesystem::path& enclave)
      : participant_(value(dds::Participant::create({.domain = domain, .enclave = enclave}))),
        reader_(value(dds::create_reader(
            participant_.get(), dds::telemetry_topic("zebro", &lss_ZebroTelemetry_desc)))) {
    if (!eventually([this] { return heard() > 0; }))
      throw NotHere("no telemetry is heard on loopback");
  }
  int heard() {
    lss_ZebroTelemetry sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    int count = 0;
    while (dds_take(reader_.get(), &pointer, &info, 1, 1) > 0) count += info.valid_data ? 1 : 0;
    return count;
  }

 private:
  dds::Participant participant_;
  dds::Entity reader_;
};

// A daemon on the measured CPU, and its clients on the other.
struct Side {
  explicit Side(int where, const std::filesystem::path& enclaves = {}) : domain(where) {
    const std::filesystem::path vehicle = enclaves.empty() ? enclaves : enclaves / "zebro-1";
    pilot = enclaves.empty() ? enclaves : enclaves / kPilot;
    {
      const OnCpu servers(measured_cpu());
      daemon.emplace(domain, false, vehicle);
    }
    pinger.emplace(domain, pilot);
    reader.emplace(domain, pilot);
  }

  // From exec of lss-cli until it has ended with the acknowledgement.
  Samples call_s(int count) const {
    Samples times =
        call_ms(stop_dry_run(domain),
                pilot.empty() ? std::pair<std::string, std::string>("LSS_SOURCE", kPilot)
                              : std::pair("LSS_ENCLAVE", pilot.string()),
                count);
    for (double& time : times) time *= 1e-3;
    return times;
  }

  int domain;
  std::filesystem::path pilot;
  std::optional<Daemon> daemon;
  std::optional<Pinger> pinger;
  std::optional<Reader> reader;
};

double daemon_cpu_s(pid_t pid) {
  clockid_t clock;
  timespec used{};
  if (::clock_getcpuclockid(pid, &clock) != 0 || ::clock_gettime(clock, &used) != 0)
    throw NotHere("the CPU time of another process cannot be read here");
  return static_cast<double>(used.tv_sec) + static_cast<double>(used.tv_nsec) * 1e-9;
}

// Of its thread that sends.
double publish_cpu_s(pid_t pid) {
  for (const auto& task : std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid))) {
    if (read_file(task.path() / "comm") != "publish\n") continue;
    double ran_ns = kNone;
    std::istringstream(read_file(task.path() / "schedstat")) >> ran_ns;
    if (std::isfinite(ran_ns)) return ran_ns * 1e-9;
  }
  throw NotHere("the CPU time of a thread cannot be read here: no schedstat");
}

struct Spent {
  const char* by;
  double (*cpu_s)(pid_t);
};

// For a second of telemetry.
Samples telemetry_ms(Side& side, double (*cpu_s)(pid_t), std::chrono::milliseconds span) {
  const pid_t pid = side.daemon->pid();
  side.reader->heard();
  const double before_s = cpu_s(pid);
  const TimeNs began_ns = now_ns();
  int heard = 0;
  const TimeNs end_ns = began_ns + span.count() * kMillisecond, last_ns = end_ns + 5 * kSecond;
  for (TimeNs now = began_ns; now < end_ns || (heard == 0 && now < last_ns); now = now_ns()) {
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    heard += side.reader->heard();
  }
  const double elapsed_s = static_cast<double>(now_ns() - began_ns) * 1e-9;
  if (heard == 0) throw std::runtime_error("telemetry is no longer heard");
  return {1e3 * (cpu_s(pid) - before_s) / elapsed_s};
}

}  // namespace

Figures security(const Options& options) {
  Folder folder;
  const OnCpu clients(kHardwareCpu);
  Side plain(domain(0)), secured(domain(1), make_keystore(folder));

  const int pings = options.count(2000, 200);
  const Rounds acks = turn_by_turn([&] { return secured.pinger->times_us(pings); },
                                   [&] { return plain.pinger->times_us(pings); });
  Figures figures{
      noted(figure("xv", "command to acknowledgement, p50", "us", acks, median, kOfUnsecured),
            "all topics encrypted, all messages signed; reference: the same daemon without"),
      figure("xv", "command to acknowledgement, p99", "us", acks, p99, kNone)};

  const int calls = options.count(4, 1);
  const Rounds starts =
      turn_by_turn([&] { return secured.call_s(calls); }, [&] { return plain.call_s(calls); });
  const std::string start = "start of a client to its first acknowledgement, ";
  figures.push_back(
      noted(at_most(figure("xv", start + "p50", "s", starts, median, kNone), kDiscovery_s),
            fmt::format("lss-cli stop --dry-run, exec to exit, {} calls", 2 * calls * kRounds)));
  figures.push_back(at_most(most("xv", start + "max", "s", starts), kDiscovery_s));

  const auto span = std::chrono::milliseconds(options.count(1000, 100));
  for (const Spent& spent :
       {Spent{"the daemon", daemon_cpu_s}, {"thread publish", publish_cpu_s}}) {
    const auto ms = [&](Side& side) { return telemetry_ms(side, spent.cpu_s, span); };
    const Rounds used = turn_by_turn([&] { return ms(secured); }, [&] { return ms(plain); });
    Figure cost = figure("xv", fmt::format("CPU of {}, a second of telemetry", spent.by), "ms",
                         used, median, kNone);
    cost.in_document = true;
    figures.push_back(noted(cost, "50 samples a second to one reader"));
  }
  return figures;
}

}  // namespace lss::bench
