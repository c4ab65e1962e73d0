// Messages of the registry: vehicles, their commands and status, the pulse; to one client or to
// all.

#include <algorithm>
#include <chrono>

#include "tools/lss-cli/session/ack.h"
#include "tools/lss-cli/session/parameters.h"
#include "tools/lss-cli/session/status.h"
#include "tools/lss-ground/client_registry.h"

namespace lss::ground {
namespace {

using nlohmann::json;

FramePtr frame(const json& document) {
  return std::make_shared<Frame>(document.dump(-1, ' ', false, json::error_handler_t::replace));
}

json age_ms(Clock::time_point since, Clock::time_point now) {
  return since == Clock::time_point{}
             ? json()
             : json(std::chrono::round<std::chrono::milliseconds>(now - since).count());
}

}  // namespace

void ClientRegistry::tell(Client& client, const json& document) {
  tell_newest(client, "", frame(document));
}

void ClientRegistry::tell_newest(Client& client, const std::string& key, const FramePtr& all) {
  const Clock::time_point now = Clock::now();
  const bool fits =
      key.empty() ? client.outbox.push(all, now) : client.outbox.push_newest(key, all, now);
  if (!fits && !client.doomed) {
    ++counters_.too_slow;
    doom(client, "too slow: it stopped reading");
    return;
  }
  client.wake();
}

void ClientRegistry::tell_everybody(const std::string& key, const json& document) {
  FramePtr all;  // created when there is a client to send it to
  for (auto& [number, client] : clients_) {
    if (client.line != Client::Line::data || client.role < Role::look) continue;
    if (!all) all = frame(document);
    tell_newest(client, key, all);
  }
}

json ClientRegistry::describe(const Craft& craft) const {
  json commands = json::array();
  const cli::Overlay* overlay = craft.kind->overlay;
  const auto is_part = [&](std::string_view name) {
    return overlay != nullptr &&
           std::ranges::find(overlay->scripts.parts, name) != overlay->scripts.parts.end();
  };
  for (const CommandInfo* info : cli::commands_of(*craft.kind)) {
    if (info->kind == static_cast<std::uint16_t>(CommandKind::emergency_stop)) continue;
    if (!is_part(info->name)) commands.push_back(cli::to_json(*info, *craft.kind));
  }
  json subjects = json::array();
  for (const char* subject : craft.kind->subjects) subjects.push_back(subject);
  return {{"type", "vehicle"},
          {"fields", *craft.kind->fields},
          {"presentation", *craft.kind->presentation},
          {"id", craft.id},
          {"vehicle", craft.kind->name},
          {"commands", std::move(commands)},
          {"subjects", std::move(subjects)},
          {"scripts", overlay != nullptr && overlay->scripts.commands != nullptr}};
}

json ClientRegistry::status(const Craft& craft) const {
  json document = cli::status_json(*craft.kind, craft.status, craft.sample());
  document["type"] = "status";
  document["id"] = craft.id;
  document["alive"] = craft.alive;
  document["airborne"] = craft.status.airborne;
  document["stop_in_flight"] = craft.status.stop_in_flight == lss_STOP_FALLS ? "falls" : "lands";
  document["daemons"] = json::array();
  for (const lss_Instance& rival : craft.daemons.rivals(Clock::now())) {
    document["daemons"].push_back({{"host", cli::text(rival.host)},
                                   {"pid", rival.pid},
                                   {"started_utc_ns", rival.started_utc_ns}});
  }
  document["progress"] = cli::progress(*craft.kind, craft.status, craft.sample());
  document["problems"] = json::array();
  for (const cli::Problem& p : cli::problems(*craft.kind, craft.status, craft.sample()))
    document["problems"].push_back({{"error", p.error}, {"text", p.text}, {"advice", p.advice}});
  return document;
}

json ClientRegistry::parameters(const Craft& craft) const {
  json document = cli::parameters_json(*craft.kind, craft.parameters, cli::items(craft.parameters));
  document["type"] = "parameters";
  document["id"] = craft.id;
  return document;
}

// All vehicles; its heartbeat is from now on for those that it drives.
void ClientRegistry::tell_everything(Client& client) {
  for (const auto& [id, craft] : fleet_.crafts()) {
    client.untold.push_back(id);
    if (cli::text(craft.status.authority) == client.source && client.role >= Role::command)
      client.driven.insert(id);
  }
  tell_more(client);
}

// All of a large fleet at once would not fit into the outbox.
void ClientRegistry::tell_more(Client& client) {
  while (!client.untold.empty() && client.outbox.roomy() && !client.doomed) {
    const Craft* craft = fleet_.find(client.untold.front());
    client.untold.pop_front();
    if (craft == nullptr) continue;
    if (client.line == Client::Line::foxglove) {
      show_channels(client, craft->id);
      continue;
    }
    tell(client, describe(*craft));
    if (craft->parameters.count > 0) tell(client, parameters(*craft));
    tell(client, status(*craft));
    json list = json::array();
    for (const lss_Event& event : craft->events)
      list.push_back(cli::event_json(*craft->kind, event));
    tell(client, {{"type", "events"}, {"id", craft->id}, {"events", std::move(list)}});
  }
}

void ClientRegistry::tell_event(const Craft& craft, const lss_Event& event) {
  json document = cli::event_json(*craft.kind, event);
  document["type"] = "event";
  document["id"] = craft.id;
  tell_everybody("", document);
}

void ClientRegistry::heard_status(Craft& craft) {
  if (described_.insert(craft.id).second) {
    show_vehicle(craft);
    tell_everybody("", describe(craft));
    if (craft.parameters.count > 0) tell_everybody("parameters " + craft.id, parameters(craft));
    for (const lss_Event& event : craft.events) tell_event(craft, event);
  }
  tell_everybody("status " + craft.id, status(craft));
  show_status(craft);
  // A page that reconnects in time continues. A heartbeat from a page without authority has no
  // effect.
  const std::string_view holder = cli::text(craft.status.authority);
  for (auto& [number, client] : clients_) {
    if (client.role < Role::command || client.line != Client::Line::data) continue;
    const bool asks = std::ranges::any_of(jobs_, [&](const Job& job) {
      return job.client == client.number && job.vehicle == craft.id && !job.dry_run;
    });
    if (holder == client.source) {
      client.driven.insert(craft.id);
    } else if (!asks) {
      client.driven.erase(craft.id);
    }
  }
}

void ClientRegistry::tell_pulse() {
  const Clock::time_point now = Clock::now();
  json crafts = json::object();
  for (const auto& [id, craft] : fleet_.crafts()) {
    crafts[id] = {{"alive", craft.alive},
                  {"daemon_age_ms", age_ms(craft.heard, now)},
                  {"status_age_ms", age_ms(craft.status_time, now)},
                  {"telemetry_age_ms", age_ms(craft.telemetry_time, now)}};
  }
  const json counters = {{"clients", clients_.size()},
                         {"connections", counters_.connections},
                         {"refused", counters_.refused},
                         {"wrong_keys", counters_.wrong_keys},
                         {"bad_messages", counters_.bad_messages},
                         {"too_fast", counters_.too_fast},
                         {"too_slow", counters_.too_slow},
                         {"replaced", counters_.replaced},
                         {"commands", counters_.commands},
                         {"stops", counters_.stops}};
  for (auto& [number, client] : clients_) {
    if (client.role == Role::none || client.line == Client::Line::foxglove) continue;
    json document = {{"type", "pulse"}, {"beat", client.beat}};
    if (client.line == Client::Line::data) {
      document["crafts"] = crafts;
      document["crowded"] = fleet_.crowded();
      document["gateway"] = counters;
    }
    tell_newest(client, "pulse", frame(document));
  }
}

}  // namespace lss::ground
