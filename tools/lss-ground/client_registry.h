#pragma once

// Messages to and from clients: roles, commands with their answers, heartbeats, emergency stops.
// Independent of sockets (server.h) and of the type of vehicle. Every client has its own source
// name, so the daemon's rule of authority applies between pages as between all other sources. Event
// loop only.

#include <cstdint>
#include <deque>
#include <functional>
#include <list>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>

#include "tools/lss-cli/session/wire.h"
#include "tools/lss-ground/access.h"
#include "tools/lss-ground/fleet.h"
#include "tools/lss-ground/foxglove.h"
#include "tools/lss-ground/message.h"
#include "tools/lss-ground/outbox.h"

namespace lss::ground {

inline constexpr Clock::duration kTick = std::chrono::milliseconds(50);  // telemetry: 20 Hz

inline bool is_final(lss_Phase phase) {
  return phase != lss_PHASE_ACCEPTED && phase != lss_PHASE_EXECUTING;
}

struct Counters {
  std::uint64_t connections = 0;  // ever
  std::uint64_t refused = 0;      // over the limit, foreign origin
  std::uint64_t wrong_keys = 0;
  std::uint64_t bad_messages = 0;
  std::uint64_t too_fast = 0;  // dropped for it
  std::uint64_t too_slow = 0;  // dropped for it
  std::uint64_t replaced = 0;  // outdated before it was sent: replaced by the newest
  std::uint64_t commands = 0, stops = 0;
};

// One connection.
struct Client {
  enum class Line : std::uint8_t { data, stop, foxglove };  // what the connection is for

  std::uint64_t number = 0;
  Line line = Line::data;
  Role role = Role::none;
  std::string source;
  Outbox outbox;
  RateLimit rate{100, 300};
  std::set<std::string> driven;  // vehicles that its heartbeat is for
  std::uint64_t beat = 0;
  unsigned bad = 0;
  Clock::time_point since{};
  std::function<void()> wake;     // there is data to send
  std::function<void()> hang_up;  // at once, without a message
  bool doomed = false;            // to be closed, with the reason
  std::string why;
  Clock::time_point doomed_at{};
  std::deque<std::string> untold{};  // vehicles that were not sent to it yet
  // Of foxglove:
  std::string only;                                      // the vehicle to show; empty: all
  std::map<std::uint32_t, std::uint32_t> subscriptions;  // by channel
  std::uint64_t lost = 0, told_lost = 0;                 // samples
};

class ClientRegistry {
 public:
  ClientRegistry(Fleet& fleet, const Door& door, std::uint32_t lease_ms);

  Client& enter(Client::Line line, std::function<void()> wake, std::function<void()> hang_up);
  void leave(Client& client);
  void refused() { ++counters_.refused; }
  // Of foxglove, before and after the connection is made.
  bool may_look(std::string_view key);
  void show(Client& client, std::string only);
  std::size_t clients(Client::Line line) const;

  // A whole message. The client may be marked for closing afterwards.
  void receive(Client& client, std::string_view text);
  // Too long, or not a text: marks it for closing.
  void too_long(Client& client);
  // Every kTick.
  void tick();
  // The clients to disconnect: the time to send them the reason is over.
  std::vector<Client*> doomed();

 private:
  // A command, or a sequence of commands, from a client.
  struct Job {
    std::uint64_t client = 0;
    std::uint64_t id = 0;
    std::string vehicle;
    std::shared_ptr<const cli::DescribedVehicle> described{};  // what the steps refer to
    std::deque<cli::Invocation> steps{};  // the first one was sent, the others wait for its end
    std::size_t count = 1;                // of steps in all
    bool dry_run = false;
    std::uint32_t lease_ms = kMaxLease_ms;
    bool accepted = false;  // of the one sent
    std::uint64_t seq = 0;
    std::string source{};
    Clock::time_point sent{};
    std::int64_t sent_ns = 0;  // the daemon's time in its last status before
  };
  // A stop that is repeated until it is completed (client_registry_stop.cpp).
  struct Emergency {
    std::uint64_t client = 0, id = 0;
    std::string vehicle, source;  // dds::kEveryVehicle: all of them
    bool land = false;            // otherwise: everything off at once
    std::set<std::uint64_t> asked{};
    std::set<std::string> stopped{};  // that completed it
    bool accepted = false;            // the landing was completed
    bool late = false;                // its client was informed
    Clock::time_point begun{}, sent{};
  };

  void on(Client& client, const Hello& hello);
  void on(Client& client, const Beat& beat);
  void on(Client& client, const Order& order);
  void on(Client& client, const Stop& stop);
  void on(Client& client, const Script& script);

  void heard_status(Craft& craft);
  void tell_event(const Craft& craft, const lss_Event& event);
  void heard_ack(const lss_CommandAck& ack);
  bool is_over(Job& job, const lss_CommandAck& ack);  // otherwise it continues
  void send_step(Job& job);
  void begin_stop(Emergency emergency);
  void send_stop(Emergency& emergency);
  bool heard_stop(const lss_CommandAck& ack);  // false: it answers no stop
  bool is_over(Emergency& emergency, Clock::time_point now);
  void tell_end(const Emergency& emergency, const char* phase, bool final);
  bool all_stopped(const Emergency& emergency) const;

  void doom(Client& client, const std::string& why);
  void bad(Client& client, const std::string& why);
  void refuse(Client& client, std::uint64_t id, const std::string& command, const std::string& why,
              const std::string& advice = "");
  bool is_replaced(const Client& client) const;  // by a newer connection of the same page
  void add(Client& client, Job job);
  void tell(Client& client, const nlohmann::json& document);
  void tell_newest(Client& client, const std::string& key, const FramePtr& frame);
  void tell_everybody(const std::string& key, const nlohmann::json& document);
  void tell_everything(Client& client);
  void tell_more(Client& client);
  nlohmann::json describe(const Craft& craft) const;
  nlohmann::json status(const Craft& craft) const;
  nlohmann::json parameters(const Craft& craft) const;
  void receive_foxglove(Client& client, std::string_view text);
  void show_vehicle(const Craft& craft);
  void show_channels(Client& client, const std::string& id);
  void hide_vehicle(const std::string& id);
  void show_status(const Craft& craft);
  void show_event(const Craft& craft, const lss_Event& event);
  void show_timing(const Craft& craft);
  void show_telemetry(const Craft& craft);
  void show_sample(const Craft& craft, foxglove::Kind kind, const void* sample, std::uint64_t utc);
  void show_sample(Client& client, const Craft& craft, foxglove::Kind kind, FramePtr sample);
  void show_stored(Client& client, const Craft& craft, foxglove::Kind kind, std::uint32_t id);
  void tell_lost();
  void tell_pulse();
  void give_up();
  Client* client_of(std::uint64_t number);

  Fleet& fleet_;
  const Door& door_;
  std::uint32_t lease_ms_;
  Counters counters_;
  std::map<std::uint64_t, Client> clients_;
  std::uint64_t numbers_ = 0;
  std::list<Job> jobs_;
  std::list<Emergency> emergencies_;
  cli::Sequence sequence_;           // shared by all sources, so it increases for each
  std::set<std::string> described_;  // vehicles that all clients know
  foxglove::Channels channels_;      // of these
  std::string session_;              // for Foxglove
  Clock::time_point next_pulse_{}, next_forget_{};
};

}  // namespace lss::ground
