#pragma once

// The registry with a fleet on a DDS domain of its own, on which a test speaks for vehicles, word
// by word.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "idl/codes.h"
#include "tests/support/eventually.h"
#include "tests/support/own_domain.h"
#include "tools/lss-cli/session/wire.h"
#include "tools/lss-ground/client_registry.h"

namespace lss::ground {

using nlohmann::json;
using std::chrono::seconds;

// A participant of the domain that sends the messages of a test.
class Talker {
 public:
  explicit Talker(int domain)
      : participant_(cli::checked(dds::Participant::create({.domain = domain}))),
        status_(writer(dds::Kind::status)),
        acks_(writer(dds::Kind::command_ack)),
        heartbeats_(writer(dds::Kind::heartbeat)),
        dictionary_(writer(dds::Kind::dictionary)),
        commands_(cli::checked(
            dds::create_reader(participant_.get(), dds::common_topic(dds::Kind::command)))) {}

  void say(const std::string& id, const std::function<void(lss_Status&)>& change = {},
           const char* vehicle = "zebro") {
    lss_Status status{};
    cli::put(status.vehicle_id, id);
    cli::put(status.vehicle, vehicle);
    if (change) change(status);
    dds_write(status_.get(), &status);
  }
  void beat(const std::string& id, std::string_view source = dds::kDaemonSource) {
    lss_Heartbeat heartbeat{};
    cli::put(heartbeat.vehicle_id, id);
    cli::put(heartbeat.source, source);
    dds_write(heartbeats_.get(), &heartbeat);
  }
  void answer(const lss_Command& command, const std::string& id, lss_Phase phase,
              Reason reason = Reason::none) {
    lss_CommandAck ack{};
    cli::put(ack.vehicle_id, id);
    cli::put(ack.source, cli::text(command.source));
    ack.seq = command.seq;
    ack.kind = command.kind;
    ack.phase = phase;
    ack.reason = static_cast<std::uint16_t>(reason);
    dds_write(acks_.get(), &ack);
  }
  void describe(const std::string& id, std::string dictionary) {
    lss_Dictionary sample{};
    cli::put(sample.vehicle_id, id);
    sample.json = dictionary.data();
    dds_write(dictionary_.get(), &sample);
  }
  // All that came so far.
  const std::vector<lss_Command>& heard() {
    lss_Command command{};
    void* samples[1] = {&command};
    dds_sample_info_t info{};
    while (dds_take(commands_.get(), samples, &info, 1, 1) == 1) {
      if (info.valid_data) heard_.push_back(command);
    }
    return heard_;
  }

 private:
  dds::Entity writer(dds::Kind kind) {
    return cli::checked(dds::create_writer(participant_.get(), dds::common_topic(kind)));
  }

  dds::Participant participant_;
  dds::Entity status_, acks_, heartbeats_, dictionary_, commands_;
  std::vector<lss_Command> heard_;
};

class ClientRegistryTest : public testing::Test {
 protected:
  // As the server does.
  void turn() {
    fleet_->take();
    registry_->tick();
    for (auto& [client, messages] : said_) {
      while (!client->outbox.empty()) {
        const FramePtr frame = client->outbox.pop(Clock::now());
        if (frame->binary()) {
          ++samples_;
        } else {
          messages.push_back(json::parse(frame->text(), frame->text() + frame->size()));
        }
      }
    }
  }
  testing::AssertionResult until(const std::function<bool()>& condition,
                                 Clock::duration limit = testing_support::kHung) {
    const Clock::time_point end = Clock::now() + limit;
    while (!condition()) {
      if (Clock::now() > end) return testing::AssertionFailure() << "it did not come";
      turn();
      ::usleep(2000);
    }
    return testing::AssertionSuccess();
  }
  void pass(Clock::duration time) {
    const Clock::time_point end = Clock::now() + time;
    (void)until([&] { return Clock::now() >= end; });
  }

  Client& client(Client::Line line) { return enter(line, ""); }
  Client& enter(Client::Line line, const std::string& key) {
    Client& c = registry_->enter(
        line, [] {}, [] {});
    said_[&c];
    json hello = {{"type", "hello"}, {"session", "0123456789abcdef"}};
    if (!key.empty()) hello["key"] = key;
    registry_->receive(c, hello.dump());
    return c;
  }
  std::vector<json> said(Client& client, const std::string& type) {
    std::vector<json> list;
    for (const json& m : said_[&client]) {
      if (m["type"] == type) list.push_back(m);
    }
    return list;
  }
  std::vector<std::string> phases(Client& client) {
    std::vector<std::string> list;
    for (const json& m : said(client, "ack"))
      list.push_back(m["phase"].get<std::string>() + (m["final"] == true ? ", final" : ""));
    return list;
  }
  // Vehicles that have a place in the gateway.
  std::vector<std::string> fleet() {
    std::vector<std::string> list;
    for (const auto& [id, craft] : fleet_->crafts()) list.push_back(id);
    return list;
  }
  bool has(const std::string& id) { return fleet_->find(id) != nullptr; }

  const int domain_ = testing_support::own_domain();
  Door door_;
  std::unique_ptr<Fleet> fleet_ = std::move(*Fleet::create(domain_, "", [] {}));
  std::unique_ptr<ClientRegistry> registry_ =
      std::make_unique<ClientRegistry>(*fleet_, door_, 2000);
  std::map<Client*, std::vector<json>> said_;
  std::size_t samples_ = 0;  // of Foxglove
};

inline std::string dictionary_of(const char* command) {
  json all = json::parse(R"({"schema_version": 2, "vehicle": "hover", "states": ["Idle"],
      "subjects": ["fan"], "parameters": [], "faults": [], "reasons": [], "events": [],
      "telemetry": {}, "commands": [{"kind": 401, "summary": "go up", "access": "holder",
      "leased": true, "ends_motion": false, "endless": true, "parameters": [],
      "allowed": [{"where": "Idle", "when": []}]}]})");
  all["commands"][0]["name"] = command;
  return all.dump();
}

}  // namespace lss::ground
