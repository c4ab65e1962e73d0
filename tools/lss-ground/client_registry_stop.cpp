// Stops: the emergency stop of one vehicle or of all, and the landing that replaces it in flight. A
// stop does not depend on the gateway's knowledge: it is sent for any name, and repeated until the
// daemon reports that it is completed, regardless of earlier answers. Only a landing may be
// rejected, by the daemon: a vehicle that is not in the air cannot land.

#include <algorithm>
#include <array>

#include "idl/codes.h"
#include "tools/lss-cli/session/ack.h"
#include "tools/lss-ground/client_registry.h"

namespace lss::ground {
namespace {

using nlohmann::json;

constexpr Clock::duration kAgain = std::chrono::milliseconds(100);
constexpr Clock::duration kLate = std::chrono::seconds(3);       // its client needs an answer
constexpr Clock::duration kGiveUp = std::chrono::seconds(10);    // not sent again
constexpr Clock::duration kEverybody = std::chrono::seconds(1);  // for vehicles that may not exist
constexpr Clock::duration kLanding = std::chrono::minutes(2);
constexpr std::ptrdiff_t kMost = 64;  // of a client at a time

// The daemon did not evaluate the command: its queue was full, or it took the command for an old
// one.
constexpr std::array kAskAgain = {Reason::busy, Reason::stale_sequence};

const CommandInfo& stop_command() {
  return *std::ranges::find(
      kCommonCommands, static_cast<std::uint16_t>(CommandKind::emergency_stop), &CommandInfo::kind);
}

const CommandInfo* land_command(const cli::Vehicle& kind) {
  const auto land =
      std::ranges::find(kind.commands, std::string_view("land"),
                        [](const CommandInfo& c) { return std::string_view(c.name); });
  return land == kind.commands.end() ? nullptr : &*land;
}

// The vehicle's own; if the vehicle is not known, that of this build. nullptr: it cannot land.
const CommandInfo* land_command(const Craft* craft) {
  if (craft != nullptr) return land_command(*craft->kind);
  for (const cli::Vehicle* kind : cli::vehicles()) {
    if (const CommandInfo* land = land_command(*kind)) return land;
  }
  return nullptr;
}

}  // namespace

void ClientRegistry::on(Client& client, const Stop& stop) {
  const char* command = stop.land ? "land" : "estop";
  if (client.line != Client::Line::stop) return bad(client, "stopping has a connection of its own");
  if (client.role < Role::stop) return refuse(client, stop.id, command, "this key may not stop");
  if (stop.land && stop.vehicle.empty())
    return refuse(client, stop.id, command, "name a vehicle that can land");
  if (stop.land && land_command(fleet_.find(stop.vehicle)) == nullptr)
    return refuse(client, stop.id, command, "this vehicle has no command 'land'");
  begin_stop({.client = client.number,
              .id = stop.id,
              .vehicle = stop.vehicle.empty() ? std::string(dds::kEveryVehicle) : stop.vehicle,
              .source = client.source,
              .land = stop.land,
              .begun = Clock::now()});
}

// A repeated stop replaces the one before it.
void ClientRegistry::begin_stop(Emergency emergency) {
  ++counters_.stops;
  std::erase_if(emergencies_, [&](const Emergency& e) {
    return e.client == emergency.client && e.vehicle == emergency.vehicle &&
           e.land == emergency.land;
  });
  if (std::ranges::count(emergencies_, emergency.client, &Emergency::client) >= kMost)
    emergencies_.erase(std::ranges::find(emergencies_, emergency.client, &Emergency::client));
  send_stop(emergencies_.emplace_back(std::move(emergency)));
}

void ClientRegistry::send_stop(Emergency& emergency) {
  emergency.sent = Clock::now();
  const auto send = [&](const std::string& vehicle) {
    const CommandInfo* command =
        emergency.land ? land_command(fleet_.find(vehicle)) : &stop_command();
    if (command == nullptr) return;  // another daemon has taken its name
    const std::uint64_t seq = sequence_.next();
    emergency.asked.insert(seq);
    fleet_.send(cli::to_dds(cli::with_defaults(*command), {vehicle, emergency.source, seq, 0, 0}));
  };
  const bool early = emergency.sent - emergency.begun < kEverybody;
  if (emergency.vehicle != dds::kEveryVehicle || early || emergency.stopped.empty())
    return send(emergency.vehicle);
  // A stopped vehicle may have been solved and started again meanwhile.
  for (const auto& [id, craft] : fleet_.crafts()) {
    if (craft.alive && !emergency.stopped.contains(id)) send(id);
  }
}

bool ClientRegistry::heard_stop(const lss_CommandAck& ack) {
  const std::string vehicle(cli::text(ack.vehicle_id));
  const auto emergency = std::ranges::find_if(emergencies_, [&](const Emergency& e) {
    return (e.vehicle == vehicle || e.vehicle == dds::kEveryVehicle) &&
           e.source == cli::text(ack.source) && e.asked.contains(ack.seq);
  });
  if (emergency == emergencies_.end()) return false;
  fleet_.answered(vehicle);
  bool over = ack.phase == lss_PHASE_COMPLETED;
  if (over) emergency->stopped.insert(vehicle);
  if (emergency->land) {
    // An answer to a repeated stop, or to a repetition that was too late.
    const bool newest = ack.seq == *emergency->asked.rbegin();
    if (is_final(ack.phase) && !over && !newest) return true;
    if (ack.phase == lss_PHASE_REJECTED && emergency->accepted) return true;
    emergency->accepted = ack.phase == lss_PHASE_ACCEPTED || ack.phase == lss_PHASE_EXECUTING;
    over = is_final(ack.phase) &&
           std::ranges::find(kAskAgain, static_cast<Reason>(ack.reason)) == kAskAgain.end();
  }
  over = over && emergency->vehicle != dds::kEveryVehicle;
  if (Client* client = client_of(emergency->client)) {
    json document = cli::ack_json(ack);
    if (document["reason"].is_object()) document["reason"]["text"] = cli::reason_text(ack);
    document["type"] = "ack";
    document["request"] = emergency->id;
    document["vehicle"] = vehicle;
    document["command"] = emergency->land ? "land" : "estop";
    document["final"] = over;
    document["after_ms"] =
        std::chrono::duration<double, std::milli>(Clock::now() - emergency->begun).count();
    tell(*client, document);
  }
  if (over) emergencies_.erase(emergency);
  return true;
}

bool ClientRegistry::all_stopped(const Emergency& emergency) const {
  return !emergency.stopped.empty() && std::ranges::all_of(fleet_.crafts(), [&](const auto& craft) {
    return !craft.second.alive || emergency.stopped.contains(craft.first);
  });
}

bool ClientRegistry::is_over(Emergency& emergency, Clock::time_point now) {
  const Clock::duration since = now - emergency.begun;
  const bool all = emergency.vehicle == dds::kEveryVehicle;
  if (all && since >= kEverybody && all_stopped(emergency)) {
    tell_end(emergency, "completed", true);
    return true;
  }
  if (since >= (emergency.accepted ? kLanding : kGiveUp)) {
    tell_end(emergency, "unanswered", true);
    return true;
  }
  if (since >= kLate && !emergency.late && !emergency.accepted) {
    emergency.late = true;
    tell_end(emergency, "unanswered", false);
  }
  if (!emergency.accepted && now - emergency.sent >= kAgain) send_stop(emergency);
  return false;
}

void ClientRegistry::tell_end(const Emergency& emergency, const char* phase, bool final) {
  Client* client = client_of(emergency.client);
  if (client == nullptr) return;
  json document = {{"type", "ack"},
                   {"request", emergency.id},
                   {"vehicle", emergency.vehicle},
                   {"command", emergency.land ? "land" : "estop"},
                   {"phase", phase},
                   {"final", final}};
  if (emergency.vehicle == dds::kEveryVehicle) {
    document["silent"] = json::array();
    for (const auto& [id, craft] : fleet_.crafts()) {
      if (!emergency.stopped.contains(id)) document["silent"].push_back(id);
    }
  }
  tell(*client, document);
}

}  // namespace lss::ground
