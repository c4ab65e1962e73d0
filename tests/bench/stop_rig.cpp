#include "tests/bench/stop_rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <fstream>
#include <regex>
#include <thread>

#include "daemon/runtime/clock.h"
#include "idl/codes.h"
#include "idl/commands.h"
#include "idl/recording_reader.h"

namespace lss::bench {
namespace {

constexpr auto kEmergencyStop = static_cast<std::uint16_t>(CommandKind::emergency_stop);
constexpr auto kStart = static_cast<std::uint16_t>(CommandKind::start);
constexpr auto kSolve = static_cast<std::uint16_t>(CommandKind::solve);
constexpr std::uint32_t kLease_ms = 20'000;  // no heartbeats of ours in the figures
constexpr TimeNs kMotion = 60 * kSecond;
constexpr TimeNs kRepeat = 100 * kMillisecond, kPatience = 20 * kSecond;
// Between stops of the echo, and before one of the daemon: other moments of a frame each time.
constexpr TimeNs kPause = 5 * kMillisecond;
constexpr double kGoldenRatio = 0.6180339887498949;
// The load repeats numbers from 1 on in our name; ours are distinguishable.
constexpr std::uint64_t kFirstSeq = std::uint64_t{1} << 40;

std::string vehicle_id(const Stoppable& vehicle) { return std::string(vehicle.name) + "-1"; }

bool is_begun(lss_Phase phase) {
  return phase == lss_PHASE_EXECUTING || phase == lss_PHASE_COMPLETED;
}

}  // namespace

Stoppable lunar_zebro() {
  return {.name = "zebro",
          .start = {0, 1, 0, 2},
          .mode = "Holding",
          .then = 0,
          .parameters = {},
          .config = {},
          .is_stop = nullptr,
          .frame_ns = 20 * kMillisecond,
          .echoed = "3A303030363030303030303030303030303030303046410A",
          .held_back = "a module's reply on its way, 24 characters of 11 bits: 2.3 ms at 115200"};
}

StopClient::StopClient(int domain, const std::string& vehicle_id)
    : participant_(value(dds::Participant::create({.domain = domain}))),
      listener_(dds_create_listener(this)),
      writer_(
          value(dds::create_writer(participant_.get(), dds::common_topic(dds::Kind::command)))) {
  std::strncpy(command_.vehicle_id, vehicle_id.c_str(), sizeof command_.vehicle_id - 1);
  std::strcpy(command_.source, kSource);
  command_.seq = kFirstSeq;
  dds_lset_data_available(listener_, [](dds_entity_t reader, void* self) {
    static_cast<StopClient*>(self)->heard(reader);
  });
  acks_ = value(dds::create_recording_reader(participant_.get(),
                                             dds::common_topic(dds::Kind::command_ack), listener_));
  statuses_ = value(dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::status)));
}

StopClient::~StopClient() {
  acks_.reset();
  dds_delete_listener(listener_);
}

void StopClient::heard(dds_entity_t reader) {
  lss_CommandAck ack;
  void* pointer = &ack;
  dds_sample_info_t info;
  while (dds_take(reader, &pointer, &info, 1, 1) > 0) {
    if (!info.valid_data || ack.seq < kFirstSeq || std::strcmp(ack.source, kSource) != 0) continue;
    const std::lock_guard lock(mutex_);
    answers_.push_back(ack);
  }
}

void StopClient::wait_for_reader() {
  const auto matched = [&] {
    dds_publication_matched_status_t status{};
    return dds_get_publication_matched_status(writer_.get(), &status) == DDS_RETCODE_OK &&
           status.current_count > 0;
  };
  if (!eventually(matched))
    throw NotHere("nobody reads commands: is loopback up, and multicast allowed on it?");
}

void StopClient::send(std::uint16_t kind, const std::vector<double>& parameters) {
  ++command_.seq;
  command_.kind = kind;
  std::ranges::fill(command_.parameter, 0.0);
  std::ranges::copy(parameters, command_.parameter);
  dds_write(writer_.get(), &command_);
}

std::string StopClient::order(std::uint16_t kind, const std::vector<double>& parameters) {
  {
    const std::lock_guard lock(mutex_);
    answers_.clear();
  }
  command_.lease_ms = kind == kSolve ? 0 : kLease_ms;
  std::string said = "nothing";
  for (TimeNs end = now_ns() + kPatience; now_ns() < end;) {
    send(kind, parameters);
    lss_CommandAck last{};
    const auto answered = [&] {
      const std::lock_guard lock(mutex_);
      for (const lss_CommandAck& ack : answers_) {
        if (ack.seq == command_.seq && ack.phase != lss_PHASE_ACCEPTED && last.seq == 0) last = ack;
      }
      return last.seq != 0;
    };
    if (!eventually(answered, std::chrono::seconds(10))) continue;
    if (is_begun(last.phase)) return {};
    said = last.text;
    if (last.reason != static_cast<std::uint16_t>(Reason::busy)) break;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return fmt::format("command {} of {}: {}", kind, command_.vehicle_id, said);
}

TimeNs StopClient::stop(const std::function<bool()>& done) {
  {
    const std::lock_guard lock(mutex_);
    answers_.clear();
  }
  command_.lease_ms = 0;
  const TimeNs begin = now_ns();
  for (TimeNs due = begin; !done();) {
    const TimeNs now = now_ns();
    if (now - begin > kPatience)
      throw std::runtime_error(fmt::format("{} does not stop", command_.vehicle_id));
    if (now >= due) {
      send(kEmergencyStop, {});
      due += kRepeat;
    }
    std::this_thread::sleep_for(std::chrono::microseconds(100));
  }
  return begin;
}

bool StopClient::completed(std::uint64_t since_seq) const {
  const std::lock_guard lock(mutex_);
  return std::ranges::any_of(answers_, [&](const lss_CommandAck& ack) {
    return ack.seq >= since_seq && ack.phase == lss_PHASE_COMPLETED;
  });
}

const lss_Status& StopClient::status() {
  const auto take = [&] {
    lss_Status sample;
    void* pointer = &sample;
    dds_sample_info_t info;
    if (dds_take(statuses_.get(), &pointer, &info, 1, 1) <= 0 || !info.valid_data) return false;
    status_ = sample;
    return true;
  };
  while (take()) {
  }
  return status_;
}

const lss_Status& StopClient::next_status() {
  const TimeNs before_ns = status().time_ns;
  if (!eventually([&] { return status().time_ns != before_ns; }))
    throw std::runtime_error("the daemon says no status");
  return status_;
}

Load::Load(int domain, const std::string& vehicle_id) {
  for (const auto& [mode, rate] :
       {std::pair{"flood-heartbeats", "14000"}, std::pair{"flood-commands", "6000"}}) {
    const std::filesystem::path log = folder_ / mode;
    programs_.push_back(std::make_unique<Process>(
        std::vector<std::string>{program("lss-attack"), mode, std::to_string(domain), vehicle_id,
                                 "--source", StopClient::kSource, "--rate", rate, "--seconds",
                                 "3600"},
        log));
    if (!eventually([&] { return programs_.back()->said("ready"); }))
      throw NotHere("the load does not run");
  }
}

Load::~Load() {
  for (const auto& program : programs_) program->signal(SIGTERM);
}

StopDaemon::StopDaemon(const Stoppable& vehicle, int domain) : vehicle_(vehicle) {
  start_simulator();
  start_daemon(domain);
  client_.emplace(domain, vehicle_id(vehicle));
  client_->wait_for_reader();
  late();
}

void StopDaemon::start_simulator() {
  const std::filesystem::path folder = folder_ / "sim", log = folder_ / "lss-sim.log";
  std::vector<std::string> words{program("lss-sim"), vehicle_.name, "--dir", folder, "--pace"};
  if (vehicle_.is_stop != nullptr) words.insert(words.end(), {"--can", "udp://127.0.0.1:0"});
  simulator_.emplace(words, log);
  if (!eventually([&] { return simulator_->said("ready"); }))
    throw NotHere("lss-sim does not start here");
  std::filesystem::create_directory(folder_ / "run");
  if (vehicle_.is_stop == nullptr) {
    line_ = std::make_unique<PtyStopLine>(folder / "legs");
    std::filesystem::create_symlink(line_->where(), folder_ / "run" / "legs");
    return;
  }
  const std::string said = read_file(log);
  std::smatch found;
  if (!std::regex_search(said, found, std::regex("udp://127\\.0\\.0\\.1:([0-9]+)")))
    throw NotHere("lss-sim does not say where its bus is");
  line_ = std::make_unique<CanStopLine>(vehicle_.is_stop,
                                        static_cast<std::uint16_t>(std::stoi(found[1])));
  for (const char* port : {"imu", "altimeter"}) {
    if (std::filesystem::exists(folder / port))
      std::filesystem::create_symlink(folder / port, folder_ / "run" / port);
  }
}

void StopDaemon::start_daemon(int domain) {
  std::string text = shipped_config(vehicle_.name);
  text = edited(text, "shared_memory", "false");
  for (const auto& [key, to] : vehicle_.config) text = edited(text, key, to);
  const std::string old = "udp://127.0.0.1:20000";
  if (const std::size_t at = text.find('"' + old + '"'); at != std::string::npos)
    text.replace(at + 1, old.size(), "udp://127.0.0.1:" + line_->where());
  const std::filesystem::path config = folder_ / "config.toml";
  std::ofstream(config) << text;
  ReadySocket ready(folder_);
  daemon_.emplace(std::vector<std::string>{program("lssd"), "--config", config, "--run-dir",
                                           folder_ / "run", "--domain", std::to_string(domain)},
                  folder_ / "lssd.log", Process::Environment{ready.variable()});
  ready.wait();
}

// Until it moves and no stop is on its bus, even after a stop caused by a busy machine.
TimeNs StopDaemon::moving() {
  constexpr int kTimes = 20;
  for (int i = 0; i < kTimes; ++i) {
    begin_motion();
    ++stops_;
    const double part = std::fmod(stops_ * kGoldenRatio, 1.0);
    sleep_until(now_ns() + vehicle_.frame_ns +
                static_cast<TimeNs>(part * static_cast<double>(vehicle_.frame_ns)));
    if (const TimeNs now = now_ns(); now - line_->last_stop_ns() >= vehicle_.frame_ns) return now;
  }
  throw std::runtime_error(fmt::format("{}: a stop is on its bus without one from here, {} times",
                                       vehicle_.name, kTimes));
}

Samples StopDaemon::stops_us(int count) {
  Samples times;
  for (int i = 0; i < count; ++i) {
    const TimeNs before_ns = moving();
    line_->expect(before_ns);
    const std::uint64_t seq = client_->next_seq();
    const TimeNs sent_ns =
        client_->stop([&] { return line_->stopped_ns() != 0 && client_->completed(seq); });
    times.push_back(static_cast<double>(line_->stopped_ns() - sent_ns) * 1e-3);
    expect_stopped();
  }
  return times;
}

void StopDaemon::expect_stopped() {
  if (!eventually([&] { return client_->status().state == lss_STATE_FATAL_ERROR; }))
    throw std::runtime_error(std::string(vehicle_.name) + " completed a stop and is not stopped");
}

Samples StopDaemon::calls_ms(const std::vector<std::string>& words, int count) {
  Samples times;
  for (int i = 0; i < count; ++i) {
    line_->expect(moving());
    Process call(words, folder_ / "call.log", {loopback()});
    if (call.wait() != 0)
      throw std::runtime_error(words.front() + " failed: " + read_file(folder_ / "call.log"));
    if (!eventually([&] { return line_->stopped_ns() != 0; }))
      throw std::runtime_error(words.front() + " stopped nothing");
    times.push_back(static_cast<double>(line_->stopped_ns() - call.started_ns()) * 1e-6);
    expect_stopped();
  }
  return times;
}

// From any state: a busy machine can make a vehicle stop by itself.
void StopDaemon::begin_motion() {
  std::string said;
  for (const TimeNs end = now_ns() + kMotion; now_ns() < end;) {
    const lss_Status status = client_->status();
    if (status.state == lss_STATE_FATAL_ERROR) {
      said = client_->order(kSolve);
    } else if (status.state == lss_STATE_IDLE) {
      said = client_->order(kStart, vehicle_.start);
    } else if (std::string(vehicle_.mode) == status.mode_name) {
      if (vehicle_.then == 0) return;
      if (said = client_->order(vehicle_.then, vehicle_.parameters); said.empty()) return;
    }
    [[maybe_unused]] const bool went_on = eventually(
        [&] {
          const lss_Status& now = client_->status();
          return now.state != status.state || now.mode != status.mode;
        },
        std::chrono::seconds(2));
  }
  throw std::runtime_error(std::string(vehicle_.name) + " does not move: " + said);
}

StopDaemon::Late StopDaemon::late() {
  const lss_Status& status = client_->next_status();
  const Late since{status.frame_index - frames_, status.overruns - late_};
  frames_ = status.frame_index;
  late_ = status.overruns;
  return since;
}

StopEcho::StopEcho(const Stoppable& vehicle, int domain) {
  if (vehicle.is_stop == nullptr) {
    line_ = std::make_unique<PtyStopLine>();
  } else {
    line_ = std::make_unique<CanStopLine>(vehicle.is_stop);
  }
  const std::filesystem::path log = folder_ / "echo.log";
  echo_.emplace(
      std::vector<std::string>{program("bench-stop-echo"), std::to_string(domain), line_->where(),
                               vehicle.echoed, std::to_string(kBusPriority)},
      log, Process::Environment{loopback()});
  if (!eventually([&] { return echo_->said("ready"); }))
    throw NotHere("the echo does not run here");
  client_.emplace(domain, vehicle_id(vehicle));
  client_->wait_for_reader();
}

Samples StopEcho::stops_us(int count) {
  Samples times;
  for (int i = 0; i < count; ++i) {
    sleep_until(now_ns() + kPause);
    line_->expect(now_ns());
    const TimeNs sent_ns = client_->stop([&] { return line_->stopped_ns() != 0; });
    times.push_back(static_cast<double>(line_->stopped_ns() - sent_ns) * 1e-3);
  }
  return times;
}

}  // namespace lss::bench
