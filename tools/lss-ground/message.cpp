#include "tools/lss-ground/message.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "idl/commands.h"
#include "lss.h"

namespace lss::ground {
namespace {

using nlohmann::json;

constexpr std::size_t kLongestName = 64, kMostParameters = 8;
constexpr std::size_t kLongestId = sizeof lss_Command::vehicle_id - 1;

// Takes the members of an object one by one; any member left at the end is unknown.
class Members {
 public:
  explicit Members(json object) : object_(std::move(object)) {
    if (!object_.is_object()) throw std::runtime_error("a message is a JSON object");
  }

  std::string text(const char* key, std::size_t longest = kLongestName) {
    const json value = take(key);
    if (!value.is_string()) throw std::runtime_error(fmt::format("{} is not a text", key));
    std::string all = value.get<std::string>();
    if (all.size() > longest) throw std::runtime_error(fmt::format("{} is too long", key));
    return all;
  }
  std::string text_or_empty(const char* key, std::size_t longest = 256) {
    return object_.contains(key) ? text(key, longest) : "";
  }
  std::uint64_t count(const char* key) {
    const json value = take(key);
    if (!value.is_number_unsigned()) throw std::runtime_error(fmt::format("{} is no count", key));
    return value.get<std::uint64_t>();
  }
  std::uint32_t lease(const char* key) {
    if (!object_.contains(key)) return kMaxLease_ms;
    const std::uint64_t ms = count(key);
    if (ms < kMinLease_ms || ms > kMaxLease_ms)
      throw std::runtime_error(
          fmt::format("{} is {} to {}, not {}", key, kMinLease_ms, kMaxLease_ms, ms));
    return static_cast<std::uint32_t>(ms);
  }
  bool flag(const char* key) {
    if (!object_.contains(key)) return false;
    const json value = take(key);
    if (!value.is_boolean()) throw std::runtime_error(fmt::format("{} is not true or false", key));
    return value.get<bool>();
  }
  std::map<std::string, double> numbers(const char* key) {
    std::map<std::string, double> all;
    if (!object_.contains(key)) return all;
    const json value = take(key);
    if (!value.is_object() || value.size() > kMostParameters)
      throw std::runtime_error(fmt::format("{} is no list of numbers", key));
    for (const auto& [name, number] : value.items()) {
      if (!number.is_number() || !std::isfinite(number.get<double>()))
        throw std::runtime_error(fmt::format("{} is not a number", name));
      all[name] = number.get<double>();
    }
    return all;
  }
  void end() const {
    if (!object_.empty())
      throw std::runtime_error(fmt::format("nobody asked for {}", object_.begin().key()));
  }

 private:
  json take(const char* key) {
    const auto found = object_.find(key);
    if (found == object_.end()) throw std::runtime_error(fmt::format("{} is missing", key));
    json value = std::move(*found);
    object_.erase(found);
    return value;
  }

  json object_;
};

Message read(Members& all) {
  const std::string type = all.text("type");
  if (type == "hello")
    return Hello{.key = all.text_or_empty("key"), .session = all.text_or_empty("session")};
  if (type == "beat") return Beat{.n = all.count("n")};
  if (type == "stop") {
    return Stop{.id = all.count("id"),
                .vehicle = all.text_or_empty("vehicle", kLongestId),
                .land = all.flag("land")};
  }
  if (type == "script") {
    return Script{.id = all.count("id"),
                  .vehicle = all.text("vehicle"),
                  .text = all.text("text", kMaxMessage)};
  }
  if (type == "command") {
    return Order{.id = all.count("id"),
                 .vehicle = all.text("vehicle"),
                 .command = all.text("command"),
                 .parameters = all.numbers("parameters"),
                 .name = all.text_or_empty("name", kNameSize - 1),
                 .dry_run = all.flag("dry_run"),
                 .whole = all.flag("whole"),
                 .lease_ms = all.lease("lease_ms")};
  }
  throw std::runtime_error("there is no such type of message");
}

}  // namespace

tl::expected<Message, std::string> parse_message(std::string_view text) {
  try {
    json document = json::parse(text, nullptr, false);
    if (document.is_discarded()) return tl::unexpected(std::string("a message is a JSON object"));
    Members members(std::move(document));
    Message message = read(members);
    members.end();
    return message;
  } catch (const std::exception& e) {  // the library also throws, on invalid UTF-8
    return tl::unexpected(std::string(e.what()));
  }
}

}  // namespace lss::ground
