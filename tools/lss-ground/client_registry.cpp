#include "tools/lss-ground/client_registry.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/answer.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/timing.h"

namespace lss::ground {
namespace {

using cli::Invocation;
using nlohmann::json;

constexpr Clock::duration kPulse = std::chrono::milliseconds(200);
constexpr Clock::duration kHello = std::chrono::seconds(3);   // to authenticate
constexpr Clock::duration kAnswer = std::chrono::seconds(2);  // of the daemon, in its time
constexpr Clock::duration kToldWhy = std::chrono::seconds(1);
constexpr Clock::duration kForget = std::chrono::seconds(1);  // how often
constexpr unsigned kMostBad = 10;
constexpr std::size_t kMostJobs = 64;  // of a client at a time; a page sends about thirty

Invocation read(const Craft& craft, const Order& order) {
  const CommandInfo& info = cli::find_command(*craft.kind, order.command);
  Invocation invocation = cli::with_defaults(info);
  invocation.name = order.name;  // the daemon judges it
  for (const auto& [name, value] : order.parameters) {
    std::size_t i = 0;
    while (i < info.parameters.size() && name != info.parameters[i].name) ++i;
    if (i == info.parameters.size()) {
      throw cli::Failure(cli::ExitCode::usage, fmt::format("{} has no '{}'", info.name, name));
    }
    invocation.parameter[i] = value;
  }
  for (std::size_t i = 0; i < info.parameters.size(); ++i) {
    if (std::isnan(invocation.parameter[i])) {
      throw cli::Failure(cli::ExitCode::usage,
                         fmt::format("{} needs its {}", info.name, info.parameters[i].name),
                         info.parameters[i].help);
    }
  }
  return invocation;
}

}  // namespace

ClientRegistry::ClientRegistry(Fleet& fleet, const Door& door, std::uint32_t lease_ms)
    : fleet_(fleet),
      door_(door),
      lease_ms_(lease_ms),
      session_(std::to_string(std::chrono::system_clock::now().time_since_epoch().count())) {
  fleet_.listen({
      .status = [this](Craft& craft) { heard_status(craft); },
      .event =
          [this](Craft& craft, const lss_Event& event) {
            tell_event(craft, event);
            show_event(craft, event);
          },
      .timing =
          [this](Craft& craft) {
            json document = cli::timing_json(cli::to_statistics(craft.timing));
            document["type"] = "timing";
            document["id"] = craft.id;
            tell_everybody("timing " + craft.id, document);
            show_timing(craft);
          },
      .parameters =
          [this](Craft& craft) { tell_everybody("parameters " + craft.id, parameters(craft)); },
      .telemetry =
          [this](Craft& craft) {
            tell_everybody("telemetry " + craft.id,
                           {{"type", "telemetry"},
                            {"id", craft.id},
                            {"telemetry", craft.kind->json(craft.sample())}});
            show_telemetry(craft);
          },
      .ack = [this](const lss_CommandAck& ack) { heard_ack(ack); },
      .gone =
          [this](const std::string& id) {
            if (described_.erase(id) > 0) hide_vehicle(id);
            tell_everybody("", {{"type", "gone"}, {"id", id}});
          },
      .driven =
          [this](const std::string& id) {
            return std::ranges::any_of(
                clients_, [&](const auto& client) { return client.second.driven.contains(id); });
          },
  });
}

Client& ClientRegistry::enter(Client::Line line, std::function<void()> wake,
                              std::function<void()> hang_up) {
  ++counters_.connections;
  const std::uint64_t number = ++numbers_;
  Client& client = clients_[number];
  client.number = number;
  client.line = line;
  client.since = Clock::now();
  client.wake = std::move(wake);
  client.hang_up = std::move(hang_up);
  return client;
}

// Nothing more is sent for it: neither its remaining commands nor a heartbeat. The lease brings its
// vehicle to a safe stop. An emergency stop continues.
void ClientRegistry::leave(Client& client) {
  counters_.replaced += client.outbox.replaced() + client.lost;
  std::erase_if(jobs_, [&](const Job& job) { return job.client == client.number; });
  clients_.erase(client.number);
}

std::size_t ClientRegistry::clients(Client::Line line) const {
  return static_cast<std::size_t>(
      std::ranges::count_if(clients_, [&](const auto& c) { return c.second.line == line; }));
}

Client* ClientRegistry::client_of(std::uint64_t number) {
  const auto found = clients_.find(number);
  return found == clients_.end() ? nullptr : &found->second;
}

void ClientRegistry::doom(Client& client, const std::string& why) {
  if (client.doomed) return;
  client.doomed = true;
  client.doomed_at = Clock::now();
  client.why = why;
  client.wake();
}

std::vector<Client*> ClientRegistry::doomed() {
  std::vector<Client*> list;
  for (auto& [number, client] : clients_) {
    if (client.doomed && Clock::now() - client.doomed_at > kToldWhy) list.push_back(&client);
  }
  return list;
}

void ClientRegistry::bad(Client& client, const std::string& why) {
  ++counters_.bad_messages;
  if (client.line == Client::Line::foxglove) {
    tell(client, foxglove::status(foxglove::Level::error, why));
  } else {
    tell(client, {{"type", "bad"}, {"text", why}});
  }
  if (++client.bad >= kMostBad) doom(client, "too many bad messages");
}

void ClientRegistry::too_long(Client& client) {
  ++counters_.bad_messages;
  doom(client, "a message was too long, or no text");
}

// The same answer as a rejection by the daemon.
void ClientRegistry::refuse(Client& client, std::uint64_t id, const std::string& command,
                            const std::string& why, const std::string& advice) {
  tell(client, {{"type", "ack"},
                {"request", id},
                {"command", command},
                {"phase", "rejected"},
                {"final", true},
                {"reason", {{"id", 0}, {"name", "ground"}, {"text", why}, {"advice", advice}}}});
}

void ClientRegistry::receive(Client& client, std::string_view text) {
  if (client.doomed) return;
  if (!client.rate.take(Clock::now())) {
    ++counters_.too_fast;
    return doom(client, "too many messages a second");
  }
  if (client.line == Client::Line::foxglove) return receive_foxglove(client, text);
  const tl::expected<Message, std::string> message = parse_message(text);
  if (!message) return bad(client, message.error());
  if (client.role == Role::none && !std::holds_alternative<Hello>(*message))
    return doom(client, "say hello first");
  std::visit([&](const auto& m) { on(client, m); }, *message);
}

void ClientRegistry::on(Client& client, const Hello& hello) {
  if (client.role != Role::none) return bad(client, "said hello before");
  const Role role = door_.admit(hello.key);
  if (role == Role::none) {
    ++counters_.wrong_keys;
    return doom(client, "wrong key");
  }
  client.role = role;
  client.source = source_of(hello.session, fleet_.own_name());
  tell(client, {{"type", "welcome"},
                {"role", role_name(role)},
                {"locked", door_.locked()},
                {"source", client.source},
                {"lease_ms", lease_ms_},
                {"version", LSS_VERSION}});
  if (client.line == Client::Line::data) tell_everything(client);
}

void ClientRegistry::on(Client& client, const Beat& beat) {
  client.beat = beat.n;
  for (const std::string& vehicle : client.driven) fleet_.heartbeat(vehicle, client.source);
}

void ClientRegistry::on(Client& client, const Order& order) {
  const auto no = [&](const std::string& why, const std::string& advice = "") {
    refuse(client, order.id, order.command, why, advice);
  };
  if (client.line != Client::Line::data) return bad(client, "this connection is for stopping");
  if (client.role < Role::command) return no("this key may not command");
  Craft* craft = fleet_.find(order.vehicle);
  if (craft == nullptr) return no("there is no such vehicle");
  try {
    const Invocation wanted = read(*craft, order);
    Job job{.id = order.id,
            .vehicle = craft->id,
            .described = craft->described,
            .dry_run = order.dry_run,
            .lease_ms = order.lease_ms};
    if (order.whole) {
      for (const Invocation& step : craft->kind->prepare(craft->status, wanted))
        job.steps.push_back(step);
    }
    job.steps.push_back(wanted);
    // Too late for a motion, never for its end.
    const bool ends = wanted.info->ends_motion || wanted.info->kind == craft->kind->rest;
    if (is_replaced(client) && (!ends || job.steps.size() > 1))
      return no("this page has a newer connection", "reload this page");
    add(client, std::move(job));
  } catch (const cli::Failure& e) {
    no(e.what(), e.advice());
  }
}

void ClientRegistry::on(Client& client, const Script& script) {
  const auto no = [&](const std::string& why, const std::string& advice = "") {
    refuse(client, script.id, "script", why, advice);
  };
  if (client.line != Client::Line::data) return bad(client, "this connection is for stopping");
  if (client.role < Role::command) return no("this key may not command");
  if (is_replaced(client)) return no("this page has a newer connection", "reload this page");
  Craft* craft = fleet_.find(script.vehicle);
  if (craft == nullptr) return no("there is no such vehicle");
  if (craft->kind->overlay == nullptr || craft->kind->overlay->scripts.commands == nullptr)
    return no("this vehicle has no scripts");
  try {
    Job job{.id = script.id, .vehicle = craft->id};
    for (Invocation& step : craft->kind->overlay->scripts.commands(script.text))
      job.steps.push_back(std::move(step));
    add(client, std::move(job));
  } catch (const cli::Failure& e) {
    no(e.what(), e.advice());
  }
}

// A command that waited in the old connection of a page, while the network was gone, comes too
// late: the heartbeat of the newer connection would keep its motion going.
bool ClientRegistry::is_replaced(const Client& client) const {
  return std::ranges::any_of(clients_, [&](const auto& c) {
    return c.second.line == client.line && c.second.source == client.source &&
           c.second.number > client.number;
  });
}

void ClientRegistry::add(Client& client, Job job) {
  const auto mine = std::ranges::count(jobs_, client.number, &Job::client);
  if (static_cast<std::size_t>(mine) >= kMostJobs) {
    return refuse(client, job.id, job.steps.back().info->name, "too many commands at a time",
                  "wait for their answers");
  }
  ++counters_.commands;
  job.client = client.number;
  job.source = client.source;
  job.count = job.steps.size();
  send_step(jobs_.emplace_back(std::move(job)));
}

void ClientRegistry::send_step(Job& job) {
  const Invocation& step = job.steps.front();
  Client* client = client_of(job.client);
  // A stop also needs the lease until it is completed.
  if (client != nullptr && !job.dry_run && step.info->access == Access::holder)
    client->driven.insert(job.vehicle);
  job.seq = sequence_.next();
  job.sent = Clock::now();
  const Craft* craft = fleet_.find(job.vehicle);
  job.sent_ns = craft != nullptr ? craft->status.time_ns : 0;
  job.accepted = false;
  const std::uint16_t flags = job.dry_run ? kFlagDryRun : std::uint16_t{0};
  fleet_.send(cli::to_dds(
      step, {job.vehicle, job.source, job.seq, flags, std::min(job.lease_ms, lease_ms_)}));
}

void ClientRegistry::heard_ack(const lss_CommandAck& ack) {
  if (heard_stop(ack)) return;
  const std::string_view vehicle = cli::text(ack.vehicle_id), source = cli::text(ack.source);
  const auto job = std::ranges::find_if(jobs_, [&](const Job& j) {
    return j.seq == ack.seq && j.vehicle == vehicle && j.source == source;
  });
  if (job == jobs_.end()) return;
  fleet_.answered(job->vehicle);
  if (is_over(*job, ack)) jobs_.erase(job);
}

bool ClientRegistry::is_over(Job& job, const lss_CommandAck& ack) {
  job.accepted = true;
  const bool done = ack.phase == lss_PHASE_COMPLETED && job.steps.size() > 1;
  const bool over = !done && (job.dry_run || is_final(ack.phase));
  if (Client* client = client_of(job.client)) {
    const Craft* craft = fleet_.find(job.vehicle);
    const OwnCodes own = craft != nullptr ? craft->kind->codes : OwnCodes{};
    json document = cli::ack_json(ack, own);
    if (document["reason"].is_object()) document["reason"]["text"] = cli::reason_text(ack, own);
    document["type"] = "ack";
    document["request"] = job.id;
    document["vehicle"] = job.vehicle;
    document["command"] = job.steps.back().info->name;
    document["step"] = cli::describe(job.steps.front());
    document["left"] = job.steps.size() - 1;
    document["steps"] = job.count;
    document["dry_run"] = job.dry_run;
    document["final"] = over;
    tell(*client, document);
  }
  if (done) {
    job.steps.pop_front();
    send_step(job);
  }
  return over;
}

// Commands without an answer.
void ClientRegistry::give_up() {
  const Clock::time_point now = Clock::now();
  std::erase_if(jobs_, [&](const Job& job) {
    const Craft* craft = fleet_.find(job.vehicle);
    if (job.accepted || !cli::could_answer(now - job.sent, job.sent_ns,
                                           craft != nullptr ? craft->status : lss_Status{}))
      return false;
    if (Client* client = client_of(job.client)) {
      tell(*client, {{"type", "ack"},
                     {"request", job.id},
                     {"vehicle", job.vehicle},
                     {"command", job.steps.back().info->name},
                     {"dry_run", job.dry_run},
                     {"phase", "unanswered"},
                     {"final", true}});
    }
    return true;
  });
  std::erase_if(emergencies_, [&](Emergency& emergency) { return is_over(emergency, now); });
}

void ClientRegistry::tick() {
  const Clock::time_point now = Clock::now();
  fleet_.take_telemetry();
  give_up();
  if (now >= next_pulse_) {
    next_pulse_ = now + kPulse;
    tell_pulse();
    tell_lost();
  }
  if (now >= next_forget_) {
    next_forget_ = now + kForget;
    fleet_.forget();
  }
  for (auto& [number, client] : clients_) {
    tell_more(client);
    if (client.role == Role::none && now - client.since > kHello)
      doom(client, "did not say who it is");
    if (!client.doomed && client.outbox.stalled(now)) {
      ++counters_.too_slow;
      doom(client, "too slow: it stopped reading");
    }
  }
}

}  // namespace lss::ground
