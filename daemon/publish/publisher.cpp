#include "daemon/publish/publisher.h"

#include <fmt/format.h>
#include <pthread.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cstdlib>
#include <ranges>
#include <span>
#include <utility>

#include "daemon/runtime/clock.h"

namespace lss {
namespace {

constexpr TimeNs kStatusInLockstep = 200 * kMillisecond;
// Each goes to every daemon of the domain. Of a second daemon of a name the first has to know soon,
// as it may move: a new daemon sends more of them, too.
constexpr TimeNs kHeartbeatAtRest = kSecond;
constexpr TimeNs kHeartbeatOften = 200 * kMillisecond;
constexpr TimeNs kNew = 5 * kSecond;
constexpr TimeNs kWatchEvery = 100 * kMillisecond;
constexpr TimeNs kForeignEvery = 60 * kSecond;

}  // namespace

Publisher::Publisher(const config::Config& config, const Logic& logic, const Vocabulary& vocabulary,
                     std::string dictionary)
    : config_(config),
      commands_(logic.commands),
      tunable_infos_(logic.tunables),
      vocabulary_(vocabulary),
      dictionary_(std::move(dictionary)) {}

tl::expected<void, Refusal> Publisher::open(RequestSink sink) {
  auto face = Face::create({.domain = config_.domain,
                            .vehicle = config_.vehicle,
                            .vehicle_id = config_.vehicle_id,
                            .version = LSS_VERSION,
                            .modules = vocabulary_.modules,
                            .tunables = tunable_infos_,
                            .commands = commands_,
                            .dictionary = dictionary_,
                            .interfaces = config_.interfaces,
                            .shared_memory = config_.shared_memory,
                            .enclave = config_.enclave,
                            .clock_slack = std::chrono::days(config_.clock_slack_days)},
                           std::move(sink));
  if (!face) return tl::unexpected(face.error());
  face_ = std::move(*face);
  answering_ = face_.get();
  expiry_ = ExpiryWatch(face_->expires_utc_s());
  for (const std::string& warning : face_->warnings()) spdlog::warn("DDS Security: {}", warning);
  for (const std::string& name : face_->missing_interfaces())
    told_.push_back({EventId::interface_missing,
                     "network interface " + name + " is not up: nobody is reached by it"});
  return {};
}

void Publisher::complain(const std::string& refused) {
  granted_ = false;
  spdlog::warn("{}", refused);
}

void Publisher::parameters(const ParameterReport& report, std::vector<Told> told) {
  parameters_ = report;
  told_ = std::move(told);
}

void Publisher::start(const Threads& threads, Sources sources) {
  threads_ = &threads;
  statistics_.set_period(config_.period_ns);
  sources_ = std::move(sources);
  const TimeNs now = now_ns();
  tell(EventId::started, now);
  for (const Told& what : told_) {
    EventRecord event{.time_ns = now,
                      .severity = static_cast<Severity>(info(what.id)->severity),
                      .id = static_cast<std::uint16_t>(what.id)};
    std::ranges::copy(what.argument, event.argument.begin());
    event.first_ns = now;
    publish(event, what.text.empty() ? event_text(event, vocabulary_, tunable_infos_) : what.text);
  }
  face_->parameters(parameters_);
  thread_ = std::thread([this] { run(); });
}

void Publisher::stop() {
  if (!thread_.joinable()) return;
  stop_ = true;
  wake();
  thread_.join();
  series_.report_all([this](const EventRecord& event) { publish(event); });
  tell(EventId::stopping, now_ns());
  face_.reset();  // returns when no answer is in progress
  answering_ = nullptr;
}

void Publisher::answer(const Ack& ack, std::string_view name) {
  if (Face* face = answering_) face->acknowledge(ack, name);
  answered_ = true;
}

void Publisher::put(const Supervisor::Outbox& outbox) noexcept {
  std::uint64_t dropped = outbox.dropped;
  for (const Ack& ack : std::span(outbox.acks).first(outbox.ack_count)) {
    if (ack.source != outbox.holder && acks_.room() <= kAcks / 4) {
      ++dropped;
    } else {
      acks_.push(ack);
    }
  }
  for (std::uint32_t i = 0; i < outbox.event_count; ++i) events_.push(outbox.events[i]);
  if (dropped != 0) dropped_.fetch_add(dropped, std::memory_order_relaxed);
}

void Publisher::run() {
  ::pthread_setname_np(::pthread_self(), "publish");
  const lockstep::Part part("publish");
  const TimeNs begun_ns = now_ns();
  while (!stop_) {
    wake_up_.wait(now_ns() + kWatchEvery);
    drain();
    const TimeNs now = now_ns();
    if (now >= next_watch_ns_) {
      next_watch_ns_ = now + kWatchEvery;
      watch(now);
    }
    publish_status(now);
    const State state = state_.value().controller.state;
    const bool often = state == State::operational || now - begun_ns < kNew;
    const TimeNs every = often ? kHeartbeatOften : kHeartbeatAtRest;
    if (now - heartbeat_ns_ >= every) {
      heartbeat_ns_ = now;
      face_->heartbeat(state);
    }
    turns_.fetch_add(1, std::memory_order_relaxed);
  }
  drain();
  publish_status(now_ns());
}

void Publisher::saved(const SaveResult& result) {
  const TimeNs now = now_ns();
  const bool failed = result.error != 0;
  const bool of_parameters = result.command.kind != 0;
  if (!failed && !of_parameters) return;
  if (!failed) {
    parameters_.saved = result.saved;
    parameters_.number = result.number;
    parameters_.state = SavedState::good;
  }
  face_->parameters(parameters_);
  EventRecord event{.time_ns = now, .severity = failed ? Severity::warning : Severity::info};
  event.id = static_cast<std::uint16_t>(failed ? EventId::parameters_not_saved
                                               : EventId::parameters_saved);
  if (failed) {
    event.argument = {static_cast<double>(result.error)};
  } else {
    event.argument = {static_cast<double>(result.count), static_cast<double>(result.number)};
  }
  tell(event);
  if (!of_parameters) return;
  Verdict verdict;
  if (failed)
    verdict = {.reason = Reason::save_failed, .measured = static_cast<double>(result.error)};
  face_->acknowledge({.source = result.command.source,
                      .sequence = result.command.sequence,
                      .kind = result.command.kind,
                      .phase = failed ? Phase::failed : Phase::completed,
                      .verdict = verdict,
                      .time_ns = now});
}

void Publisher::drain() {
  // Before the acknowledgements: a client that receives one finds the change.
  if (tunables_.update()) {
    parameters_.present = tunables_.value();
    face_->parameters(parameters_);
  }
  // Results of saving complete commands whose other acknowledgements were put before.
  std::vector<SaveResult> results;
  for (SaveResult result; sources_.parameters_saved(result);) results.push_back(result);
  for (Ack ack; acks_.pop(ack);) answer(ack, {});
  for (const SaveResult& result : results) saved(result);
  for (EventRecord event; events_.pop(event);) {
    publish(event);
    if (event.id == static_cast<std::uint16_t>(EventId::timing_reset)) {
      statistics_.reset();
      statistics_from_ns_ = event.time_ns;
    }
  }
  if (const void* sample = sources_.newest_telemetry()) face_->telemetry(sample);
  while (timings_.pop(timing_)) {
    face_->timing(timing_);
    if (certified_) certified_->look(timing_, [this](const EventRecord& event) { tell(event); });
    if (timing_.boundary_ns > statistics_from_ns_) statistics_.add(timing_);
  }
}

void Publisher::watch(TimeNs now) {
  if (face_->watch_shared_memory()) {
    next_status_ns_ = 0;
    if (face_->shared_memory() == SharedMemory::lost) {
      const EventRecord lost{
          .time_ns = now,
          .severity = Severity::warning,
          .id = static_cast<std::uint16_t>(FaultId::shared_memory_lost) + kFaultEventBase};
      tell(lost);
    }
  }
  face_->look_for_others();
  if (face_->other_interface()) tell(EventId::other_interface, now);
  if (const std::uint64_t foreign = face_->foreign();
      foreign != foreign_ && now >= next_foreign_ns_) {
    foreign_ = foreign;
    next_foreign_ns_ = now + kForeignEvery;
    spdlog::warn(
        "DDS Security: {} messages so far were dropped: the source that they give is not the name "
        "of their certificate, or its role does not allow them",
        foreign);
  }
  watch_clock();
  watch_expiry(now);
  for (EventId event; sources_.log_event(event);) tell(event, now);
  series_.report_due(now, [this](const EventRecord& event) { publish(event); });
  const SupervisorState& state = state_.value();
  const bool rests = at_rest(state);
  // Whom nobody has reached, nobody can bring back to Idle.
  const bool unreached = state.contact_ns == 0 && state.controller.state == State::fatal_error;
  const char* reason = nullptr;
  if ((rests || unreached) && face_->interfaces_could_return()) {
    reason = "a network interface that was missing is up";
  } else if (rests && config_.restart_for_shared_memory && face_->shared_memory_could_return()) {
    reason = "RouDi is back";
  }
  restart_reason_ = reason;
}

// Reads both clocks together: this thread may be delayed between any two lines.
void Publisher::watch_clock() {
  const TimeNs before = now_ns();
  const std::int64_t utc = utc_ns();
  if (now_ns() - before > ClockStep::kLimit / 10) return;
  if (const TimeNs step = clock_step_.look(before, utc); step != 0)
    tell(EventId::clock_stepped, before, static_cast<double>(step) * 1e-9);
}

void Publisher::watch_expiry(TimeNs now) {
  const std::optional<std::int64_t> left_s = expiry_.look(utc_ns() / kSecond);
  if (!left_s) return;
  tell(*left_s < 0 ? EventId::certificate_expired : EventId::certificate_expires, now,
       static_cast<double>(std::abs(*left_s) / ExpiryWatch::kDay_s));
}

void Publisher::publish_status(TimeNs now) {
  state_.update();
  if (now < next_status_ns_) return;
  const TimeNs contact_ns = state_.value().contact_ns;
  const bool spoken_to = std::exchange(contact_ns_, contact_ns) != contact_ns;
  const bool asked = answered_.exchange(false) || spoken_to || next_status_ns_ == 0;
  // Simulated time may be slower than the clock by which a client misses it.
  next_status_ns_ = now + (lockstep::on() ? kStatusInLockstep : StatusPace::kEvery);
  const StatusReport r = report(now);
  if (pace_.is_due(r, asked)) face_->status(r);
  face_->timing(statistics_.statistics());
  std::string summary =
      fmt::format("{} {}{}{}, frame {}, overruns {}, faults {}", config_.vehicle_id,
                  kStateNames[static_cast<std::size_t>(r.state)], *r.mode_name ? "/" : "",
                  r.mode_name, r.frame_index, r.overruns, r.fault_count);
  const std::lock_guard lock(summary_mutex_);
  summary_.swap(summary);
}

StatusReport Publisher::report(TimeNs now) const {
  const SupervisorState& s = state_.value();
  StatusReport r;
  r.state = s.controller.state;
  r.mode = s.controller.mode;
  r.mode_name = vocabulary_.modes[s.controller.mode];
  r.authority = s.authority;
  r.faults = s.faults;
  r.fault_count = s.fault_count;
  r.time_ns = now;
  r.obc_age_ms = s.contact_ns == 0 ? -1 : (now - s.contact_ns) / kMillisecond;
  r.frame_index = timing_.frame;
  r.period_ns = config_.period_ns;
  r.offset_ns = config_.offset_ns;
  r.overruns = timing_.overruns;
  r.commands_rejected = s.commands_refused + sources_.commands_refused() + face_->foreign();
  r.safe_commands = s.safe_commands;
  r.telemetry_dropped = acks_.dropped() + events_.dropped() + timings_.dropped() + dropped_ +
                        sources_.telemetry_missed() + sources_.log_dropped();
  r.recording = sources_.recording();
  r.saved_parameters = parameters_.state;
  r.airborne = airborne_;
  r.stop_falls = config_.stop_falls;
  r.simulated_time = lockstep::on();
  r.realtime_enforced = config_.realtime_enforce;
  r.realtime_granted = granted_ && memory_locked_;
  r.memory_locked = memory_locked_;
  // Those that come last first: frame and actuate, which are there whatever else is.
  for (const auto& thread : *threads_ | std::views::reverse) {
    const ThreadStatus t = thread->status();
    if (r.thread_count < kMaxThreads) r.threads[r.thread_count++] = t;
    if (t.policy == SCHED_OTHER) continue;
    r.page_faults += t.page_faults;
    r.mallocs += t.mallocs;
  }
  return r;
}

std::string Publisher::summary() const {
  const std::lock_guard lock(summary_mutex_);
  return summary_;
}

void Publisher::tell(EventId id, TimeNs now, double argument) {
  tell({.time_ns = now,
        .severity = static_cast<Severity>(info(id)->severity),
        .id = static_cast<std::uint16_t>(id),
        .argument = {argument}});
}

void Publisher::tell(const EventRecord& event) {
  series_.add(event, [this](const EventRecord& counted) { publish(counted); });
}

void Publisher::publish(const EventRecord& event) {
  publish(event, event_text(event, vocabulary_, tunable_infos_));
}

void Publisher::publish(const EventRecord& event, std::string text) {
  face_->event(event, text);
  next_status_ns_ = 0;  // it counts the events: clients know by it which is the last one
  if (event.id >= kFaultEventBase) {  // the log has no list of advice
    const CodeInfo* fault = info(static_cast<FaultId>(event.id - kFaultEventBase));
    text = fmt::format("fault: {}. {}", text, fault ? fault->advice : "");
  }
  switch (event.severity) {
    case Severity::info: spdlog::info("{}", text); break;
    case Severity::warning: spdlog::warn("{}", text); break;
    case Severity::error:
    case Severity::fatal: spdlog::error("{}", text); break;
  }
}

}  // namespace lss
