#include "tools/lss-cli/verbs/poll_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/answer.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/show/names.h"
#include "tools/lss-cli/verbs/sequence.h"

namespace lss::cli {
namespace {

constexpr std::ptrdiff_t kStored = 64;  // commands, and as many other requests
constexpr double kTurn_s = 0.2;         // longest time between two turns of a program that runs
constexpr double kStoodStill_s = 1;     // validity of a command in the daemon
constexpr double kTelemetry_s = 2;

// Commands of the table that have another way in.
constexpr std::string_view kNoCommands[] = {"data", "estop", "reset-timing", "set-parameter",
                                            "save-parameters"};

Failure no_verb(const Vehicle& vehicle, const std::string& name) {
  std::vector<std::string> known = command_names(vehicle);
  for (const char* own : {"status", "heartbeat", "result"}) known.emplace_back(own);
  std::string advice = did_you_mean(name, known);
  if (advice.empty()) advice = "commands of the vehicle, status, data, heartbeat, result, estop";
  return Failure(ExitCode::unknown_name, fmt::format("there is no '{}' on this socket", name),
                 advice);
}

std::vector<std::string> words_of(const std::string& text) {
  const std::vector<Line> lines = parse_sequence(text, "request");
  if (lines.size() != 1)
    throw Failure(ExitCode::usage, fmt::format("a request is one command, not {}", lines.size()));
  const std::vector<std::string>& words = lines.front().words;
  if (std::ranges::any_of(words, &std::string::empty))
    throw Failure(ExitCode::usage, "a word is empty");
  return words;
}

void need_alone(std::span<const std::string> words) {
  if (words.size() > 1)
    throw Failure(ExitCode::usage, fmt::format("{} has no parameters here", words.front()));
}

nlohmann::json error_json(const Failure& failure) {
  return {{"error",
           {{"exit_code", static_cast<int>(failure.code())},
            {"text", failure.what()},
            {"advice", failure.advice()}}}};
}

// One line of ASCII.
std::string dump(const nlohmann::json& document) {
  return document.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace);
}

}  // namespace

Invocation read_polled(const Vehicle& vehicle, std::span<const std::string> words) {
  const std::string& name = words.front();
  const bool hidden =
      std::ranges::find(kNoCommands, name) != std::end(kNoCommands) || is_composed(vehicle, name);
  const std::vector<std::string> names = command_names(vehicle);
  if (hidden || std::ranges::find(names, name) == names.end()) throw no_verb(vehicle, name);
  const CommandInfo& info = find_command(vehicle, name);
  std::vector<std::string> bare;
  std::map<std::string, std::string> named;
  for (std::size_t i = 1; i < words.size(); ++i) {
    if (!words[i].starts_with("--")) {
      bare.push_back(words[i]);
      continue;
    }
    const std::size_t equals = words[i].find('=');
    const std::string option =
        words[i].substr(2, equals == std::string::npos ? equals : equals - 2);
    if (std::ranges::find(info.parameters, option, &ParameterInfo::name) == info.parameters.end()) {
      throw Failure(ExitCode::usage, fmt::format("{} has no parameter '{}'", name, option),
                    fmt::format("see: lss-cli command describe {}", name));
    }
    if (equals == std::string::npos && i + 1 == words.size())
      throw Failure(ExitCode::usage, fmt::format("{} --{} needs a value", name, option));
    std::string value = equals == std::string::npos ? words[++i] : words[i].substr(equals + 1);
    if (value.empty())
      throw Failure(ExitCode::usage, fmt::format("{} --{} needs a value", name, option));
    if (!named.emplace(option, std::move(value)).second)
      throw Failure(ExitCode::usage, fmt::format("{} --{} is there twice", name, option));
  }
  return read_invocation(info, vehicle, bare, named);
}

PollServer::PollServer(Context& context, obc::Socket& socket) : context_(context), socket_(socket) {
  context_.session();
  link().open_telemetry();
  link().open_commands(context_.options.source);
}

void PollServer::run() {
  turned_ = Clock::now();
  while (true) {
    const Waker::Result woken = link().wait(std::max(next_, Clock::now()), socket_.fd());
    if (woken.interrupted) return;
    turn(woken.input);
    check_daemon();
  }
}

void PollServer::turn(bool input) {
  const Clock::time_point before = std::exchange(turned_, Clock::now());
  next_ = turned_ + seconds(kTurn_s);
  if (input) {
    const obc::Socket::News news = socket_.take();
    if (news.connected) asked_.clear();
    // It may stand still anywhere, also between looking at the clock and reading the socket.
    for (const obc::Lines::Line& line : news.lines)
      take(line, Clock::now() - before > seconds(kStoodStill_s));
  }
  take_answers();
  for (Asked& asked : asked_) check(asked);
}

void PollServer::take(const obc::Lines::Line& line, bool late) {
  if (line.too_long)
    return refuse(fmt::format("the line is longer than {} bytes", obc::kLongestRequest));
  const tl::expected<obc::Request, std::string> request = obc::read_request(line.text);
  if (!request) return refuse(request.error());
  const auto same = std::ranges::find(asked_, line.text, &Asked::line);
  if (same != asked_.end()) {
    ++repeats_;
    if (same->reply.empty()) return void(++same->repeated);
    if (!same->stops) return socket_.send(same->reply);
    asked_.erase(same);  // a stop is never answered from memory
  }
  ++requests_;
  make_room();
  Asked& asked = asked_.emplace_back();
  asked.sequence = request->sequence;
  asked.line = line.text;
  try {
    perform(asked, request->words, late);
  } catch (const Failure& e) {
    fail(asked, e);
  }
}

// For another request. Questions about a command never push it out.
void PollServer::make_room() {
  for (const bool commands : {true, false}) {
    const auto is_such = [&](const Asked& asked) { return (asked.seq != 0) == commands; };
    if (std::ranges::count_if(asked_, is_such) < kStored) continue;
    const auto oldest = std::ranges::find_if(asked_, is_such);
    if (oldest->reply.empty())
      fail(*oldest, Failure(ExitCode::timed_out, "too many later requests: outcome unknown"));
    asked_.erase(oldest);
  }
}

void PollServer::refuse(const std::string& why) {
  ++refused_;
  socket_.send(obc::frame(0, dump(error_json(Failure(ExitCode::usage, why, "send it again")))));
}

void PollServer::perform(Asked& asked, const std::string& words, bool late) {
  const std::vector<std::string> parsed = words_of(words);
  const std::string& verb = parsed.front();
  if (verb == common_command(CommandKind::emergency_stop).name) {
    need_alone(parsed);
    return stop(asked);
  }
  if (late) {
    ++late_;
    throw Failure(ExitCode::rejected, "the request waited while lss-cli stood still: not executed",
                  "send it again with another sequence number");
  }
  link().heartbeat();
  if (verb == "result") {
    if (parsed.size() != 2)
      throw Failure(ExitCode::usage, "result needs the sequence number of a command");
    return answer(asked, result_of(parsed[1]));
  }
  if (verb != "heartbeat" && verb != "status" && verb != "data") return command(asked, parsed);
  need_alone(parsed);
  if (verb == "heartbeat") return answer(asked, packet());
  if (verb == "status") {
    asked.wait = Wait::status;
    asked.until = Clock::now() + kStatusFollows;
    return;
  }
  link().telemetry();
  asked.samples = link().telemetry_count();
  link().send(with_defaults(common_command(CommandKind::request_data)), 0);
  asked.wait = Wait::telemetry;
  asked.until = Clock::now() + seconds(kTelemetry_s);
}

void PollServer::command(Asked& asked, std::span<const std::string> words) {
  const Invocation invocation = read_polled(vehicle(), words);
  asked.info = invocation.info;
  if (invocation.info->leased) {
    link().check_meant();
    if (const auto conflict = name_conflict(link().status(), link().instances()))
      throw Failure(ExitCode::rejected, conflict->text, conflict->advice);
  }
  asked.sent = Clock::now();
  asked.sent_ns = link().status().time_ns;
  asked.seq = link().send(invocation, 0);
  asked.wait = Wait::acknowledgement;
}

// Of the vehicles that `lss-cli estop` with the same --vehicle stops.
void PollServer::stop(Asked& asked) {
  const Options& options = context_.options;
  stop_.emplace(link(),
                options.vehicle_typed ? options.vehicle_id : std::string(dds::kEveryVehicle));
  stop_until_ = Clock::now() + seconds(options.find_timeout_s());
  asked.wait = Wait::stop;
  asked.stops = true;
  link().heartbeat();
}

nlohmann::json PollServer::result_of(const std::string& sequence) const {
  std::uint32_t number = 0;
  const char* const end = sequence.data() + sequence.size();
  const auto [rest, error] = std::from_chars(sequence.data(), end, number);
  const auto found = std::find_if(asked_.rbegin(), asked_.rend(), [&](const Asked& asked) {
    return asked.sequence == number && asked.seq != 0;
  });
  if (error != std::errc() || rest != end || found == asked_.rend()) {
    throw Failure(ExitCode::unknown_name,
                  fmt::format("no command of sequence {} is among the last {}", sequence, kStored),
                  "see: status");
  }
  return command_json(*found);
}

void PollServer::heard(const lss_CommandAck& ack) {
  if (text(ack.vehicle_id) != text(link().status().vehicle_id)) return;
  last_ack_ns_ = std::max<std::int64_t>(last_ack_ns_, ack.time_ns);
  for (Asked& asked : asked_) {
    const bool over = asked.ack && asked.ack->phase != lss_PHASE_ACCEPTED &&
                      asked.ack->phase != lss_PHASE_EXECUTING;
    if (asked.seq != 0 && asked.seq == ack.seq && !over) asked.ack = ack;
  }
}

void PollServer::take_answers() {
  if (stop_) {
    const auto next =
        stop_->step({.turn = {}, .answer = [&](const lss_CommandAck& ack) { heard(ack); }});
    if (next) next_ = std::min(next_, *next);
    if (!next || Clock::now() >= stop_until_) {
      for (Asked& asked : asked_) {
        if (asked.wait == Wait::stop) answer(asked, stopped_json());
      }
      stop_.reset();
    }
  }
  while (const std::optional<Link::Answer> answer = link().next_answer()) heard(answer->ack);
  link().take();
  link().telemetry();
}

// Answers it when that is possible now.
void PollServer::check(Asked& asked) {
  const Clock::time_point now = Clock::now();
  const bool over = now >= asked.until;
  switch (asked.wait) {
    case Wait::none:
    case Wait::stop: return;
    case Wait::acknowledgement:
      if (asked.ack) return answer(asked, command_json(asked));
      if (could_answer(now - asked.sent, asked.sent_ns, link().status())) {
        fail(asked,
             Failure(ExitCode::timed_out,
                     fmt::format("{} was not acknowledged: outcome unknown", asked.info->name),
                     "see: status"));
      }
      return;  // the next turn comes soon enough
    case Wait::status:
      if (over || (!stop_ && link().status().time_ns >= last_ack_ns_)) {  // a stop is in it
        nlohmann::json document = status_json(vehicle(), link().status(), nullptr);
        document["obc"] = packet()["obc"];
        return answer(asked, std::move(document));
      }
      break;
    case Wait::telemetry:
      if (link().telemetry_count() != asked.samples)
        return answer(asked, status_json(vehicle(), link().status(), link().telemetry()));
      if (over) fail(asked, Failure(ExitCode::timed_out, "no telemetry came", "see: status"));
      break;
  }
  if (asked.wait != Wait::none) next_ = std::min(next_, asked.until);
}

void PollServer::answer(Asked& asked, nlohmann::json document) {
  document["schema_version"] = kSchemaVersion;
  asked.wait = Wait::none;
  asked.reply = obc::frame(asked.sequence, dump(document));
  for (int i = 0; i <= asked.repeated; ++i) socket_.send(asked.reply);
}

void PollServer::fail(Asked& asked, const Failure& failure) { answer(asked, error_json(failure)); }

void PollServer::check_daemon() const {
  if (!context_.link().daemon_lost()) return;
  throw Failure(ExitCode::unreachable, "the daemon went away",
                "check that lssd runs (systemctl status lssd@NAME)");
}

nlohmann::json PollServer::command_json(const Asked& asked) const {
  nlohmann::json document = {{"phase", "unanswered"}};
  if (asked.ack) document = ack_json(*asked.ack, context_.link().vehicle().codes);
  document["command"] = asked.info->name;
  document["kind"] = asked.info->kind;
  document["seq"] = asked.seq;
  return document;
}

nlohmann::json PollServer::stopped_json() {
  nlohmann::json list = nlohmann::json::array();
  const std::vector<Stopped> all = stop_->results();
  for (const Stopped& stopped : all) list.push_back(to_json(stopped, link().source()));
  const bool complete = !all.empty() && std::ranges::all_of(all, &Stopped::completed);
  return {{"command", common_command(CommandKind::emergency_stop).name},
          {"stopped", complete},
          {"vehicles", std::move(list)}};
}

// What a heartbeat is answered with.
nlohmann::json PollServer::packet() {
  const lss_Status& status = link().status();
  const std::string_view authority = text(status.authority);
  return {
      {"state", state_name(status.state)},
      {"mode", text(status.mode_name)},
      {"authority", authority.empty() ? nlohmann::json() : nlohmann::json(authority)},
      {"fault_count",
       std::ranges::count_if(status.faults, [](const lss_Fault& f) { return f.id != 0; })},
      {"airborne", static_cast<bool>(status.airborne)},
      {"time_ns", status.time_ns},
      {"obc",
       {{"requests", requests_}, {"repeats", repeats_}, {"refused", refused_}, {"late", late_}}}};
}

}  // namespace lss::cli
