#pragma once

// Vehicles as channels of Foxglove's WebSocket protocol (github.com/foxglove/ws-protocol,
// docs/spec.md of version 0.8): topics and types as in a recording of the vehicle, samples as JSON.
// Of the requests of that protocol only subscribe and unsubscribe, so that nothing can be sent to a
// vehicle. Event loop only.

#include <cstdint>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "tools/lss-cli/recording/idl_types.h"
#include "tools/lss-ground/fleet.h"
#include "tools/lss-ground/outbox.h"

namespace lss::ground::foxglove {

using Json = nlohmann::ordered_json;

enum class Kind : std::uint8_t { telemetry, status, timing_statistics, event };
inline constexpr std::uint32_t kKinds = 4;

// A topic, and its type.
class Topic {
 public:
  // `packed`: a sample in memory has the layout of CDR, not that of a struct in C.
  Topic(std::string name, std::string_view idl, const std::string& type, bool packed);

  Json channel(std::uint32_t id, const std::string& prefix) const;
  // As `lss-cli log show` has it.
  std::string json(const void* sample) const;

 private:
  std::string name_;
  cli::recording::Types types_;
  cli::recording::Layout layout_;
  bool packed_;
};

// The channels of all vehicles. Their ids are not used again.
class Channels {
 public:
  Channels();

  void add(const Craft& craft);
  void remove(const std::string& id);
  std::uint32_t channel(const std::string& id, Kind kind) const;  // 0: there is none

  struct Place {
    std::string id;  // of the vehicle
    Kind kind;
  };
  std::optional<Place> find(std::uint32_t channel) const;
  const Topic& topic(const std::string& id, Kind kind) const;

  // Of one vehicle. Topics of the first one, or of `only`, are named as in a recording; those of
  // others have their id before the name.
  Json advertise(const std::string& id, const std::string& only) const;
  Json unadvertise(const std::string& id) const;

 private:
  struct Vehicle {
    std::uint32_t first = 0;
    std::unique_ptr<const Topic> telemetry;  // nullptr: its type is not known
  };

  std::map<std::string, Vehicle> vehicles_;
  std::string plain_;  // the first vehicle
  std::uint32_t next_ = 1;
  std::map<Kind, std::unique_ptr<const Topic>> common_;
};

Json server_info(const std::string& session);

enum class Level : std::uint8_t { info, warning, error };
// A later one with the same `id` replaces it.
Json status(Level level, const std::string& text, const std::string& id = "");

// `utc_ns`: of the sample.
FramePtr message_data(std::uint32_t subscription, std::uint64_t utc_ns, std::string_view payload);

struct Subscription {
  std::uint32_t id = 0, channel = 0;
};
struct Request {
  std::vector<Subscription> subscribe;
  std::vector<std::uint32_t> unsubscribe;  // ids
};
tl::expected<Request, std::string> parse(std::string_view text);

}  // namespace lss::ground::foxglove
