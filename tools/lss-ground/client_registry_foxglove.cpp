// Clients of Foxglove: what they subscribe to, and the samples for them.

#include <fmt/format.h>

#include <cstring>

#include "tools/lss-ground/client_registry.h"

namespace lss::ground {
namespace {

using foxglove::Kind;

constexpr std::size_t kStoredEvents = 64;  // of those before a subscription

FramePtr foxglove_frame(const foxglove::Json& document) {
  return std::make_shared<Frame>(
      document.dump(-1, ' ', false, foxglove::Json::error_handler_t::replace));
}

// In UTC; any number may come from outside.
std::uint64_t utc_ns(const Craft& craft, std::int64_t time_ns) {
  return static_cast<std::uint64_t>(craft.status.utc_ns) + static_cast<std::uint64_t>(time_ns) -
         static_cast<std::uint64_t>(craft.status.time_ns);
}

std::int64_t telemetry_time_ns(const void* sample) {
  std::int64_t time_ns = 0;  // behind the key, in every type
  std::memcpy(&time_ns, static_cast<const std::byte*>(sample) + sizeof lss_Status::vehicle_id,
              sizeof time_ns);
  return time_ns;
}

bool shows(const Client& client, const std::string& id) {
  return client.line == Client::Line::foxglove && (client.only.empty() || client.only == id);
}

}  // namespace

bool ClientRegistry::may_look(std::string_view key) {
  if (door_.admit(key) >= Role::look) return true;
  ++counters_.wrong_keys;
  return false;
}

void ClientRegistry::show(Client& client, std::string only) {
  client.role = Role::look;
  client.only = std::move(only);
  tell_newest(client, "", foxglove_frame(foxglove::server_info(session_)));
  tell_newest(client, "",
              foxglove_frame({{"op", "advertise"}, {"channels", foxglove::Json::array()}}));
  for (const std::string& id : described_) {
    if (shows(client, id)) client.untold.push_back(id);
  }
  tell_more(client);
}

void ClientRegistry::show_channels(Client& client, const std::string& id) {
  tell_newest(client, "", foxglove_frame(channels_.advertise(id, client.only)));
}

void ClientRegistry::show_vehicle(const Craft& craft) {
  channels_.add(craft);
  for (auto& [number, client] : clients_) {
    if (!shows(client, craft.id)) continue;
    client.untold.push_back(craft.id);
    tell_more(client);
  }
}

void ClientRegistry::hide_vehicle(const std::string& id) {
  for (auto& [number, client] : clients_) {
    if (!shows(client, id) || std::erase(client.untold, id) > 0) continue;
    std::erase_if(client.subscriptions, [&](const auto& subscription) {
      const auto place = channels_.find(subscription.first);
      return !place || place->id == id;
    });
    tell_newest(client, "", foxglove_frame(channels_.unadvertise(id)));
  }
  channels_.remove(id);
}

// A sample that finds no place is lost, and counted; of telemetry and timing the newest waits.
void ClientRegistry::show_sample(Client& client, const Craft& craft, Kind kind, FramePtr sample) {
  const bool newest = kind == Kind::telemetry || kind == Kind::timing_statistics;
  const Clock::time_point now = Clock::now();
  const std::string key = fmt::format("{} {}", static_cast<int>(kind), craft.id);
  const bool fits = newest ? client.outbox.push_newest(key, std::move(sample), now)
                           : client.outbox.push(std::move(sample), now);
  if (!fits) ++client.lost;
  client.wake();
}

void ClientRegistry::show_sample(const Craft& craft, Kind kind, const void* sample,
                                 std::uint64_t utc) {
  const std::uint32_t channel = channels_.channel(craft.id, kind);
  if (channel == 0) return;
  std::string payload;  // made when somebody subscribed to it
  for (auto& [number, client] : clients_) {
    const auto subscription = client.subscriptions.find(channel);
    if (subscription == client.subscriptions.end() || client.doomed) continue;
    if (payload.empty()) payload = channels_.topic(craft.id, kind).json(sample);
    show_sample(client, craft, kind, foxglove::message_data(subscription->second, utc, payload));
  }
}

void ClientRegistry::show_status(const Craft& craft) {
  show_sample(craft, Kind::status, &craft.status, static_cast<std::uint64_t>(craft.status.utc_ns));
}

void ClientRegistry::show_event(const Craft& craft, const lss_Event& event) {
  show_sample(craft, Kind::event, &event, static_cast<std::uint64_t>(event.utc_ns));
}

void ClientRegistry::show_timing(const Craft& craft) {
  show_sample(craft, Kind::timing_statistics, &craft.timing, utc_ns(craft, craft.timing.until_ns));
}

void ClientRegistry::show_telemetry(const Craft& craft) {
  show_sample(craft, Kind::telemetry, craft.sample(),
              utc_ns(craft, telemetry_time_ns(craft.sample())));
}

void ClientRegistry::receive_foxglove(Client& client, std::string_view text) {
  const auto request = foxglove::parse(text);
  if (!request) return bad(client, request.error());
  for (const std::uint32_t id : request->unsubscribe)
    std::erase_if(client.subscriptions, [&](const auto& s) { return s.second == id; });
  for (const foxglove::Subscription& wanted : request->subscribe) {
    const auto place = channels_.find(wanted.channel);
    // It may be gone since: no error of the client.
    if (!place || !shows(client, place->id)) continue;
    for (const auto& [channel, id] : client.subscriptions) {
      if (channel == wanted.channel || id == wanted.id)
        return bad(client, fmt::format("subscription {} or channel {} is in use", wanted.id,
                                       wanted.channel));
    }
    client.subscriptions[wanted.channel] = wanted.id;
    if (const Craft* craft = fleet_.find(place->id))
      show_stored(client, *craft, place->kind, wanted.id);
  }
}

void ClientRegistry::show_stored(Client& client, const Craft& craft, Kind kind, std::uint32_t id) {
  const foxglove::Topic& topic = channels_.topic(craft.id, kind);
  const auto show = [&](const void* sample, std::uint64_t utc) {
    show_sample(client, craft, kind, foxglove::message_data(id, utc, topic.json(sample)));
  };
  switch (kind) {
    case Kind::status: show(&craft.status, static_cast<std::uint64_t>(craft.status.utc_ns)); break;
    case Kind::timing_statistics:
      if (craft.timing.until_ns != 0) show(&craft.timing, utc_ns(craft, craft.timing.until_ns));
      break;
    case Kind::telemetry:
      if (const void* sample = craft.sample())
        show(sample, utc_ns(craft, telemetry_time_ns(sample)));
      break;
    case Kind::event: {
      const std::size_t count = craft.events.size();
      for (std::size_t i = count > kStoredEvents ? count - kStoredEvents : 0; i < count; ++i)
        show(&craft.events[i], static_cast<std::uint64_t>(craft.events[i].utc_ns));
    }
  }
}

void ClientRegistry::tell_lost() {
  for (auto& [number, client] : clients_) {
    if (client.line != Client::Line::foxglove) continue;
    const std::uint64_t lost = client.lost + client.outbox.replaced();
    if (lost == client.told_lost) continue;
    client.told_lost = lost;
    tell_newest(
        client, "lost",
        foxglove_frame(foxglove::status(
            foxglove::Level::warning,
            fmt::format("{} samples were left out: the connection is too slow", lost), "lost")));
  }
}

}  // namespace lss::ground
