#include "tools/lss-cli/session/status.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <ctime>

#include "idl/codes.h"
#include "tools/lss-cli/session/vehicle_words.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-cli/show/units.h"

namespace lss::cli {
namespace {

const char* shared_memory_name(lss_SharedMemory memory) {
  static constexpr const char* kNames[] = {"off", "active", "absent", "lost"};
  return name_of(kNames, static_cast<unsigned>(memory));
}

const char* policy_name(std::int32_t policy) {
  static constexpr const char* kNames[] = {"SCHED_OTHER", "SCHED_FIFO", "SCHED_RR"};
  return name_of(kNames, static_cast<unsigned>(policy));
}

double age_s(const lss_Status& status, std::int64_t since_ns) {
  return static_cast<double>(status.time_ns - since_ns) * 1e-9;
}

std::string utc_text(std::int64_t utc_ns) {
  const auto seconds = static_cast<std::time_t>(utc_ns / 1'000'000'000);
  return fmt::format("{:%H:%M:%S}.{:03}", fmt::localtime(seconds), utc_ns / 1'000'000 % 1000);
}

nlohmann::json faults_json(const Vehicle& vehicle, const lss_Status& status) {
  nlohmann::json list = nlohmann::json::array();
  for (const lss_Fault& fault : status.faults) {
    if (fault.id == 0) continue;
    const CodeInfo* code = info(static_cast<FaultId>(fault.id), vehicle.codes);
    list.push_back({{"id", fault.id},
                    {"name", code != nullptr ? code->name : ""},
                    {"subject", fault.subject},
                    {"subject_name", subject_name(vehicle, fault.subject)},
                    {"count", fault.count},
                    {"age_s", age_s(status, fault.since_ns)},
                    {"text", code != nullptr ? code->text : ""},
                    {"advice", code != nullptr ? code->advice : ""}});
  }
  return list;
}

nlohmann::json realtime_json(const lss_Status& status) {
  nlohmann::json threads = nlohmann::json::array();
  for (std::size_t i = 0; i < std::min<std::size_t>(status.thread_count, std::size(status.threads));
       ++i) {
    const lss_ThreadContract& t = status.threads[i];
    threads.push_back({{"name", text(t.name)},
                       {"policy", policy_name(t.policy)},
                       {"priority", t.priority},
                       {"cpu", t.cpu},
                       {"granted", t.granted},
                       {"page_faults_since_start", t.page_faults_since_start},
                       {"mallocs_since_start", t.mallocs_since_start}});
  }
  return {{"policy", status.realtime_enforced ? "enforce" : "degrade"},
          {"granted", status.realtime_granted},
          {"memory_locked", status.memory_locked},
          {"page_faults_since_start", status.page_faults_since_start},
          {"mallocs_since_start", status.mallocs_since_start},
          {"threads", std::move(threads)}};
}

std::string heading(const Vehicle& vehicle, const lss_Status& status, const Style& style) {
  const char* state = state_name(status.state);
  std::string shown = status.state == lss_STATE_FATAL_ERROR    ? style.bad(state)
                      : status.state == lss_STATE_SOLVE_ERRORS ? style.warning(state)
                                                               : style.good(state);
  if (status.state == lss_STATE_OPERATIONAL) shown += ", " + style.good(text(status.mode_name));
  const std::string_view holder = text(status.authority);
  return fmt::format(
      "{} ({})   {}   {}\n", style.bold(text(status.vehicle_id)), vehicle.name, shown,
      holder.empty() ? style.dim("nobody commands") : fmt::format("commanded by {}", holder));
}

}  // namespace

std::string problem_lines(const std::vector<Problem>& list, const Style& style) {
  std::string lines;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const Problem& problem = list[i];
    lines += fmt::format("{} {}\n", problem.error ? style.bad("ERROR  ") : style.warning("warning"),
                         problem.text);
    const bool same_again = i + 1 < list.size() && list[i + 1].advice == problem.advice;
    if (!problem.advice.empty() && !same_again)
      lines += fmt::format("        {}\n", style.dim("-> " + problem.advice));
  }
  return lines;
}

namespace {

std::string contract(const lss_Status& status) {
  std::string threads;
  for (std::size_t i = 0; i < std::min<std::size_t>(status.thread_count, std::size(status.threads));
       ++i) {
    const lss_ThreadContract& t = status.threads[i];
    if (t.policy == 0) continue;
    threads += fmt::format("{}{} {}", threads.empty() ? "" : ", ", text(t.name), t.priority);
  }
  return fmt::format("{}; memory {}; {} page faults, {} mallocs since start",
                     threads.empty() ? "no FIFO threads" : "FIFO: " + threads,
                     status.memory_locked ? "locked" : "not locked", status.page_faults_since_start,
                     status.mallocs_since_start);
}

std::string system_lines(const lss_Status& status, const Style& style) {
  const auto row = [&](const char* name, const std::string& value) {
    return fmt::format("{} {}\n", style.dim(fmt::format("{:<10}", name)), value);
  };
  const std::string heard =
      status.obc_age_ms < 0
          ? "no message"
          : fmt::format("last message {} ago",
                        format_duration(static_cast<double>(status.obc_age_ms) / 1000));
  std::string lines =
      row("OBC link", fmt::format("{}; {} commands rejected", heard, status.commands_rejected));
  lines +=
      row("frame", fmt::format("{} of {:.0f} ms, {} overruns, {} safe commands, {} samples dropped",
                               status.frame_index, static_cast<double>(status.period_ns) * 1e-6,
                               status.overruns, status.safe_commands, status.telemetry_dropped));
  lines += row("real time", contract(status));
  const std::string_view why = text(status.shared_memory_text);
  lines += row("shared mem", fmt::format("{}{}{}", shared_memory_name(status.shared_memory),
                                         why.empty() ? "" : ": ", why));
  return lines;
}

}  // namespace

const char* state_name(lss_State state) {
  static constexpr const char* kNames[] = {"Idle", "Operational", "FatalError", "SolveErrors"};
  return name_of(kNames, static_cast<unsigned>(state));
}

const char* saved_name(lss_SavedParameters saved) {
  static constexpr const char* kNames[] = {"none", "good", "one_copy", "partly", "lost"};
  return name_of(kNames, static_cast<unsigned>(saved));
}

const char* saved_trouble(lss_SavedParameters saved) {
  switch (saved) {
    case lss_SAVED_ONE_COPY:
      return "one copy of the saved parameters is not good: the other one was taken";
    case lss_SAVED_PARTLY: return "some of the saved parameters were not taken";
    case lss_SAVED_LOST:
      return "no copy of the saved parameters is good: those of the configuration apply";
    default: return "";
  }
}

const char* phase_name(lss_Phase phase) {
  static constexpr const char* kNames[] = {"accepted",  "rejected", "executing",
                                           "completed", "failed",   "superseded"};
  return name_of(kNames, static_cast<unsigned>(phase));
}

const char* severity_name(lss_Severity severity) {
  static constexpr const char* kNames[] = {"info", "warning", "error", "fatal"};
  return name_of(kNames, static_cast<unsigned>(severity));
}

std::string fault_text(const Vehicle& vehicle, const lss_Fault& fault) {
  const CodeInfo* code = info(static_cast<FaultId>(fault.id), vehicle.codes);
  const std::string what = code != nullptr ? code->text : fmt::format("fault {}", fault.id);
  const std::string subject = subject_name(vehicle, fault.subject);
  return subject.empty() ? what : fmt::format("{}: {}", subject, what);
}

std::string instance_text(const lss_Instance& instance) {
  if (instance.pid == 0) return "of an unknown host";
  const auto started = static_cast<std::time_t>(instance.started_utc_ns / 1'000'000'000);
  return fmt::format("{}, pid {}, since {:%F %T} UTC", text(instance.host), instance.pid,
                     fmt::gmtime(started));
}

nlohmann::json instance_json(const lss_Instance& instance) {
  if (instance.pid == 0) return nullptr;
  return {{"host", text(instance.host)},
          {"pid", instance.pid},
          {"started_utc_ns", instance.started_utc_ns},
          {"boot", instance.boot}};
}

std::optional<Problem> name_conflict(const lss_Status& status,
                                     const std::vector<lss_Instance>& instances) {
  if (instances.size() < 2) return std::nullopt;
  std::string list;
  for (const lss_Instance& instance : instances)
    list += (list.empty() ? "" : "; ") + instance_text(instance);
  return Problem{true,
                 fmt::format("{} daemons have the name {}: {}", instances.size(),
                             text(status.vehicle_id), list),
                 info(Reason::name_conflict)->advice};
}

std::vector<Problem> problems(const Vehicle& vehicle, const lss_Status& status,
                              const void* telemetry) {
  std::vector<Problem> list;
  std::uint32_t shown = 0;
  for (const lss_Fault& fault : status.faults) {
    if (fault.id == 0) continue;
    ++shown;
    const CodeInfo* code = info(static_cast<FaultId>(fault.id), vehicle.codes);
    const std::string times = fault.count > 1 ? fmt::format(", {} times", fault.count) : "";
    list.push_back({true,
                    fmt::format("{} (since {}{})", fault_text(vehicle, fault),
                                format_duration(age_s(status, fault.since_ns)), times),
                    code != nullptr ? code->advice : ""});
  }
  if (status.fault_count > shown) list.push_back({true, "more faults than are listed", ""});
  if (status.state == lss_STATE_FATAL_ERROR && shown == 0) {
    list.push_back({true, "stopped by an emergency", "lss-cli solve"});
  }
  if (telemetry == nullptr) {
    list.push_back({true, "no telemetry comes", "check the log of lssd"});
  } else if (vehicle.problems) {
    for (Problem& problem : vehicle.problems(status, telemetry)) list.push_back(std::move(problem));
  }
  if (!status.realtime_granted) {
    list.push_back({false, "real-time permissions are missing: timing is not guaranteed",
                    "run under systemd (lssd@.service), or grant CAP_SYS_NICE and memlock"});
  }
  if (status.shared_memory == lss_SHM_ABSENT || status.shared_memory == lss_SHM_LOST) {
    list.push_back(
        {false,
         fmt::format("shared memory is {}: telemetry goes by the network",
                     shared_memory_name(status.shared_memory)),
         "start RouDi (iox-roudi.service), then restart the daemon when the vehicle is Idle"});
  }
  if (const char* wrong = saved_trouble(status.saved_parameters); *wrong != '\0') {
    list.push_back({false, wrong,
                    "lss-cli events names it; see lss-cli param diff, then lss-cli param save "
                    "writes both copies again"});
  }
  if (!status.recording)
    list.push_back({false, "not everything is recorded",
                    "the journal says what is wrong; or nothing is to be recorded: name a preset "
                    "in log.use, or "
                    "set record = true in [recorder]"});
  std::ranges::stable_sort(list, std::greater<>{}, &Problem::error);
  return list;
}

nlohmann::json status_json(const Vehicle& vehicle, const lss_Status& status,
                           const void* telemetry) {
  const std::string_view holder = text(status.authority);
  return {{"schema_version", kSchemaVersion},
          {"vehicle", text(status.vehicle)},
          {"vehicle_id", text(status.vehicle_id)},
          {"version", text(status.version)},
          {"instance", instance_json(status.instance)},
          {"state", state_name(status.state)},
          {"mode", text(status.mode_name)},
          {"faults", faults_json(vehicle, status)},
          {"fault_count", status.fault_count},
          {"airborne", status.airborne},
          {"simulated_time", status.simulated_time},
          {"stop_in_flight", status.stop_in_flight == lss_STOP_LANDS ? "land" : "fall"},
          {"authority", holder.empty() ? nlohmann::json() : nlohmann::json(holder)},
          {"recording", status.recording},
          {"time_ns", status.time_ns},
          {"utc_ns", status.utc_ns},
          {"link", {{"obc_age_ms", status.obc_age_ms}}},
          {"frame",
           {{"index", status.frame_index},
            {"period_ns", status.period_ns},
            {"offset_ns", status.offset_ns},
            {"overruns", status.overruns}}},
          {"counters",
           {{"commands_rejected", status.commands_rejected},
            {"safe_commands", status.safe_commands},
            {"events", status.events},
            {"telemetry_dropped", status.telemetry_dropped}}},
          {"realtime", realtime_json(status)},
          {"shared_memory", shared_memory_name(status.shared_memory)},
          {"shared_memory_text", text(status.shared_memory_text)},
          {"saved_parameters", saved_name(status.saved_parameters)},
          {"telemetry", telemetry != nullptr ? vehicle.json(telemetry) : nullptr}};
}

std::string status_screen(const Vehicle& vehicle, const lss_Status& status, const void* telemetry,
                          const Style& style) {
  std::string screen = heading(vehicle, status, style);
  screen += problem_lines(problems(vehicle, status, telemetry), style);
  screen += "\n" + cli::screen(vehicle, telemetry, style) + "\n";
  return screen + system_lines(status, style);
}

std::string status_line(const Vehicle& vehicle, const lss_Status& status, const void* telemetry) {
  std::string line = state_name(status.state);
  if (status.fault_count > 0) line += fmt::format(", {} faults", status.fault_count);
  return line + ", " + progress(vehicle, status, telemetry);
}

bool is_newer(const lss_Event& event, const lss_Event& than) {
  return event.count > 1 && event.id == than.id && event.subject == than.subject &&
         event.first_ns == than.first_ns && event.index > than.index;
}

std::string event_line(const lss_Event& event, const Style& style) {
  const std::string severity = fmt::format("{:<7}", severity_name(event.severity));
  const std::string shown = event.severity == lss_SEVERITY_INFO      ? style.dim(severity)
                            : event.severity == lss_SEVERITY_WARNING ? style.warning(severity)
                                                                     : style.bad(severity);
  return fmt::format("{:>6}  {}  {}  {}\n", event.index, style.dim(utc_text(event.utc_ns)), shown,
                     text(event.text));
}

nlohmann::json event_json(const Vehicle& vehicle, const lss_Event& event) {
  const CodeInfo* code = event_info(event.id, vehicle.codes);
  nlohmann::json arguments = nlohmann::json::array();
  for (const double value : event.argument) arguments.push_back(value);
  return {{"index", event.index},     {"time_ns", event.time_ns},
          {"utc_ns", event.utc_ns},   {"severity", severity_name(event.severity)},
          {"id", event.id},           {"name", code != nullptr ? code->name : ""},
          {"subject", event.subject}, {"subject_name", subject_name(vehicle, event.subject)},
          {"count", event.count},     {"first_ns", event.first_ns},
          {"text", text(event.text)}, {"arguments", std::move(arguments)}};
}

}  // namespace lss::cli
