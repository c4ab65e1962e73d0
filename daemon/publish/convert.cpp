#include "daemon/publish/convert.h"

#include <algorithm>

#include "daemon/runtime/clock.h"

namespace lss::dds {
namespace {

// The IDL has the numbers of our own lists.
template <class E, std::size_t N>
consteval bool same(const E (&ours)[N], const int (&theirs)[N]) {
  return std::ranges::equal(ours, theirs, {}, [](E e) { return static_cast<int>(e); });
}

static_assert(same({State::idle, State::operational, State::fatal_error, State::solve_errors},
                   {lss_STATE_IDLE, lss_STATE_OPERATIONAL, lss_STATE_FATAL_ERROR,
                    lss_STATE_SOLVE_ERRORS}));
static_assert(same({Phase::accepted, Phase::rejected, Phase::executing, Phase::completed,
                    Phase::failed, Phase::superseded},
                   {lss_PHASE_ACCEPTED, lss_PHASE_REJECTED, lss_PHASE_EXECUTING,
                    lss_PHASE_COMPLETED, lss_PHASE_FAILED, lss_PHASE_SUPERSEDED}));
static_assert(same({Severity::info, Severity::warning, Severity::error, Severity::fatal},
                   {lss_SEVERITY_INFO, lss_SEVERITY_WARNING, lss_SEVERITY_ERROR,
                    lss_SEVERITY_FATAL}));
static_assert(same({SharedMemory::off, SharedMemory::active, SharedMemory::absent,
                    SharedMemory::lost},
                   {lss_SHM_OFF, lss_SHM_ACTIVE, lss_SHM_ABSENT, lss_SHM_LOST}));
static_assert(same({SavedState::none, SavedState::good, SavedState::one_copy, SavedState::partly,
                    SavedState::lost},
                   {lss_SAVED_NONE, lss_SAVED_GOOD, lss_SAVED_ONE_COPY, lss_SAVED_PARTLY,
                    lss_SAVED_LOST}));
static_assert(same({Change::always, Change::at_rest}, {lss_CHANGE_ALWAYS, lss_CHANGE_AT_REST}));
static_assert(sizeof(lss_Command::source) == sizeof(Name));
static_assert(sizeof(lss_Command::parameter) == sizeof(Request::parameter));
static_assert(sizeof(lss_Command::name) == sizeof(ParameterName));
static_assert(sizeof(lss_Parameter::name) == sizeof(ParameterName));
static_assert(std::size(decltype(lss_Status::faults){}) == kMaxFaults);
static_assert(std::size(decltype(lss_Status::threads){}) == kMaxThreads);

Name to_name(const char (&from)[sizeof(Name)]) {
  Name name{};
  if (const auto text = read_text(from)) std::copy(text->begin(), text->end(), name.begin());
  return name;
}

template <std::size_t N>
std::string_view view(const std::array<char, N>& text) {
  return {text.data(), ::strnlen(text.data(), N)};
}

lss_Fault to_dds(const FaultRecord& fault) {
  lss_Fault to{};
  to.id = static_cast<std::uint16_t>(fault.id);
  to.subject = fault.subject;
  to.count = fault.count;
  to.since_ns = fault.since_ns;
  return to;
}

lss_ThreadContract to_dds(const ThreadStatus& thread) {
  lss_ThreadContract to{};
  copy_text(view(thread.name), to.name);
  to.policy = thread.policy;
  to.priority = thread.priority;
  to.cpu = thread.cpu;
  to.granted = thread.granted;
  to.page_faults_since_start = thread.page_faults;
  to.mallocs_since_start = thread.mallocs;
  return to;
}

}  // namespace

Request to_request(const lss_Command& command, TimeNs arrival_ns) {
  Request request;
  request.source = to_name(command.source);
  request.sequence = command.seq;
  request.kind = command.kind;
  request.flags = command.flags & kFlagDryRun;
  request.lease_ms = command.lease_ms;
  std::copy(std::begin(command.parameter), std::end(command.parameter), request.parameter.begin());
  std::copy(std::begin(command.name), std::end(command.name), request.name.begin());
  request.arrival_ns = arrival_ns;
  return request;
}

Request to_request(const lss_Heartbeat& heartbeat, TimeNs arrival_ns) {
  Request request;
  request.source = to_name(heartbeat.source);
  request.sequence = heartbeat.counter;
  request.arrival_ns = arrival_ns;
  return request;
}

lss_CommandAck to_dds(const Ack& ack, std::string_view vehicle_id, const Subjects& subjects) {
  lss_CommandAck to{};
  copy_text(vehicle_id, to.vehicle_id);
  copy_text(view(ack.source), to.source);
  to.seq = ack.sequence;
  to.kind = ack.kind;
  to.reason = static_cast<std::uint16_t>(ack.verdict.reason);
  to.phase = static_cast<lss_Phase>(ack.phase);
  to.measured = ack.verdict.measured;
  to.limit = ack.verdict.limit;
  to.time_ns = ack.time_ns;
  copy_text(ack_text(ack, subjects), to.text);
  return to;
}

lss_Event to_dds(const EventRecord& record, std::string_view text, std::string_view vehicle_id,
                 std::uint64_t index) {
  lss_Event to{};
  copy_text(vehicle_id, to.vehicle_id);
  to.index = index;
  to.time_ns = record.time_ns;
  // UTC of the event: the present wall clock less the age of the event.
  to.utc_ns = utc_ns() - (now_ns() - record.time_ns);
  to.severity = static_cast<lss_Severity>(record.severity);
  to.id = record.id;
  to.subject = record.subject;
  to.count = record.count;
  to.first_ns = record.first_ns;
  std::copy(record.argument.begin(), record.argument.end(), std::begin(to.argument));
  copy_text(text, to.text);
  return to;
}

lss_Status to_dds(const StatusReport& report, std::string_view vehicle_id) {
  lss_Status to{};
  copy_text(vehicle_id, to.vehicle_id);
  to.state = static_cast<lss_State>(report.state);
  to.mode = report.mode;
  copy_text(report.mode_name, to.mode_name);
  copy_text(view(report.authority), to.authority);
  std::transform(report.faults.begin(), report.faults.end(), std::begin(to.faults),
                 [](const FaultRecord& fault) { return to_dds(fault); });
  to.recording = report.recording;
  to.fault_count = report.fault_count;
  to.time_ns = report.time_ns;
  to.utc_ns = utc_ns() - (now_ns() - report.time_ns);
  to.obc_age_ms = report.obc_age_ms;
  to.frame_index = report.frame_index;
  to.period_ns = report.period_ns;
  to.offset_ns = report.offset_ns;
  to.overruns = report.overruns;
  to.commands_rejected = report.commands_rejected;
  to.safe_commands = report.safe_commands;
  to.telemetry_dropped = report.telemetry_dropped;
  to.realtime_enforced = report.realtime_enforced;
  to.realtime_granted = report.realtime_granted;
  to.memory_locked = report.memory_locked;
  to.page_faults_since_start = report.page_faults;
  to.mallocs_since_start = report.mallocs;
  std::transform(report.threads.begin(), report.threads.end(), std::begin(to.threads),
                 [](const ThreadStatus& thread) { return to_dds(thread); });
  to.thread_count = report.thread_count;
  to.saved_parameters = static_cast<lss_SavedParameters>(report.saved_parameters);
  to.airborne = report.airborne;
  to.simulated_time = report.simulated_time;
  to.stop_in_flight = report.stop_falls ? lss_STOP_FALLS : lss_STOP_LANDS;
  return to;
}

void to_dds(const TimingPoints& points, std::string_view vehicle_id, lss_Timing& to) {
  to = {};
  copy_text(vehicle_id, to.vehicle_id);
  to.frame = points.frame;
  to.boundary_ns = points.boundary_ns;
  to.woken_ns = points.woken_ns;
  to.read_ns = points.read_ns;
  to.navigated_ns = points.navigated_ns;
  to.ready_ns = points.ready_ns;
  to.released_ns = points.released_ns;
  to.margin_ns = points.margin_ns;
  to.offset_ns = points.offset_ns;
  to.overruns = points.overruns;
  to.frames_skipped = points.frames_skipped;
  to.frames_held = points.frames_held;
  to.commands_repeated = points.commands_repeated;
  to.samples = points.samples;
}

void to_dds(const TimingStatistics& statistics, std::string_view vehicle_id,
            lss_TimingStatistics& to) {
  copy_text(vehicle_id, to.vehicle_id);
  to.frames = statistics.frames;
  to.overruns = statistics.overruns;
  to.repeated = statistics.repeated;
  to.skipped = statistics.skipped;
  to.held = statistics.held;
  to.since_ns = statistics.since_ns;
  to.until_ns = statistics.until_ns;
  to.period_ns = statistics.period_ns;
  to.offset_ns = statistics.offset_ns;
  for (std::size_t i = 0; i < kTimingStepCount; ++i) {
    const TimingSeries& from = statistics.series[i];
    lss_TimingSeries& series = to.series[i];
    series = {.count = from.count,
              .sum_ns = from.sum_ns,
              .squares_ns2 = from.squares_ns2,
              .min_ns = from.min_ns,
              .max_ns = from.max_ns,
              .bucket = {}};
    std::ranges::copy(from.bucket, std::begin(series.bucket));
  }
}

void to_dds(const ParameterReport& report, std::string_view vehicle_id, lss_Parameters& to) {
  static_assert(std::extent_v<decltype(lss_Parameters::item)> == kMaxTunables);
  to = {};
  copy_text(vehicle_id, to.vehicle_id);
  to.count = static_cast<std::uint32_t>(report.infos.size());
  to.changes = report.present.changes;
  to.save = report.number;
  to.saved = static_cast<lss_SavedParameters>(report.state);
  for (std::size_t i = 0; i < report.infos.size(); ++i) {
    const TunableInfo& info = report.infos[i];
    lss_Parameter& p = to.item[i];
    copy_text(info.name, p.name);
    copy_text(info.unit, p.unit);
    p.value = report.present.value[i];
    p.min = info.min;
    p.max = info.max;
    p.configured = report.configured.value[i];
    p.saved = report.saved[i];
    p.change = static_cast<lss_ParameterChange>(info.change);
    p.whole = info.whole;
  }
}

}  // namespace lss::dds
