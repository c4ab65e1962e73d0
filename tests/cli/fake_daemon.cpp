#include "tests/cli/fake_daemon.h"

#include <earlier.h>  // of the IDL
#include <zebro.h>    // of the IDL

#include <algorithm>
#include <chrono>
#include <cmath>
#include <tuple>

#include "tools/lss-cli/session/link.h"

namespace lss::cli::test {
namespace {

using std::chrono::milliseconds, std::chrono::seconds;
using zebro::Mode;

constexpr milliseconds kPeriod{10};

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(Clock::now().time_since_epoch())
      .count();
}

dds::Participant join(int domain) {
  dds::ParticipantParameters parameters;
  parameters.domain = domain;
  parameters.daemon = true;
  return checked(dds::Participant::create(parameters));
}

// That of a vehicle of this build.
std::string built_dictionary(const std::string& vehicle) {
  for (std::string& text : built_dictionaries())
    if (nlohmann::json::parse(text)["vehicle"] == vehicle) return std::move(text);
  return "";
}

}  // namespace

FakeDaemon::FakeDaemon(int domain, const Birth& birth)
    : birth_(birth), participant_(join(domain)), speaks_(Clock::now() + birth.late_by) {
  put(parameters_.vehicle_id, birth_.vehicle_id);
  for (const auto& [name, unit, value, min, max, change] :
       {std::tuple{"limits.current_A", "A", 1.2, 0.05, 1.7, lss_CHANGE_ALWAYS},
        std::tuple{"gait.flight_s", "s", 3.0, 0.1, 60.0, lss_CHANGE_AT_REST},
        std::tuple{"solve.rounds", "", 10.0, 1.0, 1000.0, lss_CHANGE_ALWAYS}}) {
    lss_Parameter& p = parameters_.item[parameters_.count++];
    put(p.name, name);
    put(p.unit, unit);
    p.value = p.configured = value;
    p.min = min;
    p.max = max;
    p.saved = NAN;
    p.change = change;
  }
  if (!birth_.mark.empty()) {
    dds_qos_t* qos = dds_create_qos();
    dds_qset_userdata(qos, birth_.mark.data(), birth_.mark.size());
    dds_set_qos(participant_.get(), qos);
    dds_delete_qos(qos);
  }
  if (birth_.late == Birth::Late::status) open();
  thread_ = std::thread([this] { run(); });
}

void FakeDaemon::open() {
  const auto writer = [&](dds::Kind kind) {
    return checked(dds::create_writer(participant_.get(), dds::common_topic(kind)));
  };
  acks_ = writer(dds::Kind::command_ack);
  heartbeat_writer_ = writer(dds::Kind::heartbeat);
  events_ = writer(dds::Kind::event);
  timing_ = writer(dds::Kind::timing_statistics);
  parameter_writer_ = writer(dds::Kind::parameters);
  const bool described = !birth_.dictionary.empty();
  telemetry_ = checked(dds::create_writer(
      participant_.get(),
      dds::telemetry_topic(described ? birth_.vehicle : "zebro", &lss_ZebroTelemetry_desc)));
  std::string dictionary = described ? birth_.dictionary : built_dictionary(birth_.vehicle);
  dictionary_ = writer(dds::Kind::dictionary);
  lss_Dictionary sample{};
  put(sample.vehicle_id, birth_.vehicle_id);
  sample.json = dictionary.data();
  dds_write(dictionary_.get(), &sample);
  dds_topic_descriptor_t earlier = earlier_Command_desc;
  earlier.m_typename = lss_Command_desc.m_typename;
  const auto reader = [&](dds::Kind kind) {
    dds::Topic topic = dds::common_topic(kind);
    if (birth_.earlier && kind == dds::Kind::command) topic.descriptor = &earlier;
    return checked(
        dds::create_daemon_reader(participant_.get(), topic, birth_.vehicle_id, nullptr));
  };
  commands_ = reader(dds::Kind::command);
  heartbeat_reader_ = reader(dds::Kind::heartbeat);
  status_ = writer(dds::Kind::status);
  publish_parameters();
}

FakeDaemon::~FakeDaemon() {
  stop_ = true;
  thread_.join();
}

void FakeDaemon::run() {
  Clock::time_point next_status{}, next_heartbeat{};
  dds::OtherDaemons others(participant_);
  while (!stop_) {
    others.look();
    others_ = others.count();
    {
      const std::lock_guard lock(mutex_);
      const bool speaks = Clock::now() >= speaks_;
      if (speaks && !status_) open();
      if (!silent_ && status_) {
        if (take_commands()) next_status = std::min(next_status, Clock::now() + seconds(1));
        if (speaks && (changed_ || Clock::now() >= next_status)) {
          publish_status();
          next_status = Clock::now() + seconds(state_ == lss_STATE_IDLE ? 8 : 1);
        }
        if (speaks && Clock::now() >= next_heartbeat) {
          publish_heartbeat();
          next_heartbeat = Clock::now() + seconds(1);
        }
        if (mode_ == Mode::walking) distance_m_ += 0.0001;
        if (periodic_) publish_telemetry();
      }
    }
    std::this_thread::sleep_for(kPeriod);  // the frame period of this daemon
  }
}

bool FakeDaemon::take_commands() {
  bool spoken_to = false;
  dds_sample_info_t info{};
  lss_Heartbeat heartbeat{};
  void* heartbeats[1] = {&heartbeat};
  while (dds_take(heartbeat_reader_.get(), heartbeats, &info, 1, 1) == 1) {
    if (!info.valid_data) continue;
    ++heartbeats_;
    spoken_to = true;
    heart_ = text(heartbeat.source);
  }
  lss_Command command{};
  void* commands[1] = {&command};
  while (dds_take(commands_.get(), commands, &info, 1, 1) == 1) {
    spoken_to = true;
    const std::string_view id = text(command.vehicle_id);
    const bool every = id == dds::kEveryVehicle && command.kind == kEstop;
    if (info.valid_data && (every || id == birth_.vehicle_id))
      obey(command, info.publication_handle);
  }
  return spoken_to;
}

bool FakeDaemon::is_troubled(std::uint16_t kind, Trouble::Kind what) {
  const auto found = troubles_.find(kind);
  if (found == troubles_.end() || found->second.kind != what || found->second.times == 0)
    return false;
  if (found->second.times > 0) --found->second.times;
  return true;
}

void FakeDaemon::obey(const lss_Command& command, std::uint64_t writer) {
  const bool dry_run = (command.flags & kFlagDryRun) != 0;
  if (!dry_run) heard_.push_back(command);
  std::uint64_t& newest = sequences_[writer];
  if (command.seq <= newest) {
    return acknowledge(command, lss_PHASE_REJECTED, Reason::stale_sequence);
  }
  newest = command.seq;
  if (is_troubled(command.kind, Trouble::Kind::no_answer)) return;
  const bool anyone = command.kind == kData || command.kind == kEstop || command.kind == kLand;
  if (!anyone && !authority_.empty() && text(command.source) != authority_) {
    return acknowledge(command, lss_PHASE_REJECTED, Reason::not_authorised);
  }
  if (is_troubled(command.kind, Trouble::Kind::reject)) {
    return acknowledge(command, lss_PHASE_REJECTED, troubles_.at(command.kind).reason);
  }
  acknowledge(command, lss_PHASE_ACCEPTED);
  if (dry_run) return;
  if (command.kind == kData) {
    publish_telemetry();
    return acknowledge(command, lss_PHASE_COMPLETED);
  }
  if (command.kind == kSetParameter || command.kind == kSaveParameters)
    return obey_parameters(command);
  if (active_.kind != 0) finish(lss_PHASE_SUPERSEDED, Reason::superseded);
  acknowledge(command, lss_PHASE_EXECUTING);
  active_ = command;
  if (is_troubled(command.kind, Trouble::Kind::fail))
    return finish(lss_PHASE_FAILED, troubles_.at(command.kind).reason);
  if (is_troubled(command.kind, Trouble::Kind::never_ends)) return;
  perform(command);
}

void FakeDaemon::obey_parameters(const lss_Command& command) {
  if (command.kind == kSetParameter) {
    for (lss_Parameter& p : parameters_.item)
      if (text(p.name) == text(command.name)) p.value = command.parameter[0];
    ++parameters_.changes;
  } else {
    parameters_.saved = lss_SAVED_GOOD;
    ++parameters_.save;
    for (lss_Parameter& p : parameters_.item)
      p.saved = p.value == p.configured ? std::nan("") : p.value;
  }
  publish_parameters();
  acknowledge(command, lss_PHASE_EXECUTING);
  acknowledge(command, lss_PHASE_COMPLETED);
}

void FakeDaemon::publish_parameters() { dds_write(parameter_writer_.get(), &parameters_); }

void FakeDaemon::perform(const lss_Command& command) {
  Reason reason{};
  const auto reach = [&](lss_State state, Mode mode) {
    state_ = state;
    mode_ = mode;
    changed_ = true;
    authority_ = state == lss_STATE_OPERATIONAL ? text(command.source) : "";
    airborne_ = false;
  };
  switch (command.kind) {
    case kStart: reach(lss_STATE_OPERATIONAL, Mode::holding); break;
    case kStand: reach(lss_STATE_OPERATIONAL, Mode::standing); break;
    case kLayDown: reach(lss_STATE_OPERATIONAL, Mode::lying); break;
    case kStow: reach(lss_STATE_OPERATIONAL, Mode::stowed); break;
    case kLeg: reach(lss_STATE_OPERATIONAL, Mode::bridge); break;
    case kWalk: return reach(lss_STATE_OPERATIONAL, Mode::walking);  // until another command
    case kLand: reach(lss_STATE_OPERATIONAL, mode_); break;
    case kEstop:
      reason = airborne_ ? Reason::fell : Reason::none;
      reach(lss_STATE_FATAL_ERROR, Mode::none);
      break;
    default: reach(lss_STATE_IDLE, Mode::none); break;
  }
  finish(lss_PHASE_COMPLETED, reason);
}

void FakeDaemon::acknowledge(const lss_Command& command, lss_Phase phase, Reason reason) {
  lss_CommandAck ack{};
  put(ack.vehicle_id, birth_.vehicle_id);
  std::ranges::copy(command.source, ack.source);
  ack.seq = command.seq;
  ack.kind = command.kind;
  ack.phase = phase;
  ack.reason = static_cast<std::uint16_t>(reason);
  ack.measured = ack.limit = NAN;
  ack.time_ns = now_ns();
  dds_write(acks_.get(), &ack);
}

void FakeDaemon::finish(lss_Phase phase, Reason reason) {
  acknowledge(active_, phase, reason);
  active_ = {};
}

lss_Instance FakeDaemon::instance() const {
  lss_Instance instance{};
  put(instance.host, "obc");
  instance.pid = birth_.pid;
  instance.started_utc_ns = 1'900'000'000'000'000'000;
  return instance;
}

void FakeDaemon::publish_heartbeat() {
  lss_Heartbeat heartbeat{};
  put(heartbeat.vehicle_id, birth_.vehicle_id);
  put(heartbeat.source, dds::kDaemonSource);
  heartbeat.state = state_;
  heartbeat.instance = instance();
  dds_write(heartbeat_writer_.get(), &heartbeat);
}

void FakeDaemon::publish_status() {
  lss_Status status{};
  put(status.vehicle_id, birth_.vehicle_id);
  put(status.vehicle, birth_.vehicle);
  put(status.version, "0.0.0");
  status.instance = instance();
  status.airborne = airborne_;
  status.stop_in_flight = stop_in_flight_;
  put(status.authority, authority_);
  put(status.mode_name, zebro::kModeNames[static_cast<std::size_t>(mode_)]);
  status.state = state_;
  status.mode = static_cast<std::uint8_t>(mode_);
  status.time_ns = now_ns();
  status.events = event_index_;
  status.recording = true;
  status.period_ns = 20'000'000;
  status.realtime_granted = true;
  status.memory_locked = true;
  status.obc_age_ms = 12;
  status.shared_memory = lss_SHM_OFF;
  status.thread_count = 1;
  put(status.threads[0].name, "frame");
  status.threads[0].policy = 1;
  status.threads[0].priority = 70;
  std::ranges::copy(faults_, status.faults);
  status.fault_count = static_cast<std::uint32_t>(faults_.size());
  status.saved_parameters = parameters_.saved;
  dds_write(status_.get(), &status);
  changed_ = false;
}

void FakeDaemon::publish_telemetry() {
  lss_ZebroTelemetry t{};
  put(t.vehicle_id, birth_.vehicle_id);
  t.time_ns = now_ns();
  t.state = static_cast<std::uint8_t>(state_);
  t.mode = static_cast<std::uint8_t>(mode_);
  t.speed = 3;
  t.direction = 1;
  t.distance_m = distance_m_;
  t.port_open = true;
  for (std::uint8_t i = 0; i < zebro::kModules; ++i) {
    lss_ZebroModule& module = t.modules[i];
    module.id = module.address = static_cast<std::uint8_t>(i + 1);
    module.online = module.id != silent_module_;
    module.calibrated = true;
    module.temperature_degC = 21.5;
  }
  dds_write(telemetry_.get(), &t);
}

void FakeDaemon::trouble(std::uint16_t kind, Trouble trouble) {
  const std::lock_guard lock(mutex_);
  troubles_.insert_or_assign(kind, trouble);
}
void FakeDaemon::set_state(lss_State state, Mode mode) {
  const std::lock_guard lock(mutex_);
  state_ = state;
  mode_ = mode;
  changed_ = true;
}
void FakeDaemon::take_off(lss_StopInFlight stop) {
  const std::lock_guard lock(mutex_);
  airborne_ = changed_ = true;
  stop_in_flight_ = stop;
}
void FakeDaemon::set_authority(const std::string& source) {
  const std::lock_guard lock(mutex_);
  authority_ = source;
  changed_ = true;
}
void FakeDaemon::latch(FaultId fault, std::uint16_t subject) {
  const std::lock_guard lock(mutex_);
  faults_.push_back({.id = static_cast<std::uint16_t>(fault),
                     .subject = subject,
                     .count = 1,
                     .since_ns = now_ns()});
  changed_ = true;
}
void FakeDaemon::silence_module(std::uint8_t id) {
  const std::lock_guard lock(mutex_);
  silent_module_ = id;
}
void FakeDaemon::telemetry_on_request() {
  const std::lock_guard lock(mutex_);
  periodic_ = false;
}
void FakeDaemon::fall_silent() {
  const std::lock_guard lock(mutex_);
  silent_ = true;
}
void FakeDaemon::emergency() {
  const std::lock_guard lock(mutex_);
  state_ = lss_STATE_FATAL_ERROR;
  mode_ = Mode::none;
  changed_ = true;
  if (active_.kind != 0) finish(lss_PHASE_FAILED, Reason::emergency);
}

void FakeDaemon::event(EventId id, const std::string& what, std::uint32_t count) {
  const std::lock_guard lock(mutex_);
  lss_Event event{};
  put(event.vehicle_id, birth_.vehicle_id);
  event.index = ++event_index_;
  event.time_ns = now_ns();
  event.count = count;
  event.severity = lss_SEVERITY_INFO;
  event.id = static_cast<std::uint16_t>(id);
  put(event.text, what);
  dds_write(events_.get(), &event);
  publish_status();
}

void FakeDaemon::saved_parameters(lss_SavedParameters saved) {
  const std::lock_guard lock(mutex_);
  parameters_.saved = saved;
  publish_parameters();
  changed_ = true;
}

void FakeDaemon::timing(const TimingStatistics& statistics) {
  const std::lock_guard lock(mutex_);
  lss_TimingStatistics sample{};
  put(sample.vehicle_id, birth_.vehicle_id);
  sample.frames = statistics.frames;
  sample.overruns = statistics.overruns;
  sample.offset_ns = statistics.offset_ns;
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    const TimingSeries& from = statistics.series[i];
    sample.series[i].count = from.count;
    sample.series[i].sum_ns = from.sum_ns;
    sample.series[i].min_ns = from.min_ns;
    sample.series[i].max_ns = from.max_ns;
    std::ranges::copy(from.bucket, sample.series[i].bucket);
  }
  dds_write(timing_.get(), &sample);
}

std::string FakeDaemon::heart() const {
  const std::lock_guard lock(mutex_);
  return heart_;
}
std::vector<std::uint16_t> FakeDaemon::kinds() const {
  const std::lock_guard lock(mutex_);
  std::vector<std::uint16_t> list;
  for (const lss_Command& command : heard_) list.push_back(command.kind);
  return list;
}
lss_Command FakeDaemon::last(std::uint16_t kind) const {
  const std::lock_guard lock(mutex_);
  lss_Command found{};
  for (const lss_Command& command : heard_) {
    if (command.kind == kind) found = command;
  }
  return found;
}
lss_State FakeDaemon::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}
Mode FakeDaemon::mode() const {
  const std::lock_guard lock(mutex_);
  return mode_;
}

}  // namespace lss::cli::test
