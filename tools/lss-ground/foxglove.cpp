#include "tools/lss-ground/foxglove.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

#include "idl/idl_text.h"
#include "idl/units.h"
#include "tools/lss-cli/recording/idl_types.h"

namespace lss::ground::foxglove {
namespace {

using cli::recording::Member;
using cli::recording::Type;
using cli::recording::Types;
using TypeKind = cli::recording::Kind;

constexpr std::byte kCdr[] = {std::byte{0}, std::byte{1}, std::byte{0}, std::byte{0}};
constexpr std::uint8_t kMessageData = 1;  // its opcode

const Type& find_type(const Types& types, const std::string& name) {
  const Type* type = types.find(name);
  if (type == nullptr) throw std::logic_error("the IDL does not have " + name);
  return *type;
}

std::size_t up(std::size_t at, std::size_t to) { return (at + to - 1) / to * to; }

std::size_t alignment(const Type& type) {
  std::size_t most = 1;
  if (type.kind != TypeKind::structure) return size_of(type.kind);
  for (const Member& member : type.members) most = std::max(most, alignment(*member.type));
  return most;
}

// From a struct as a C compiler lays it out to CDR, which aligns numbers but no structs.
class Packer {
 public:
  explicit Packer(const void* sample) : from_(static_cast<const std::byte*>(sample)) {}

  void put(const Type& type) {
    const std::size_t align = alignment(type);
    at_ = up(at_, align);
    if (type.kind == TypeKind::structure) {
      for (const Member& member : type.members) {
        for (std::size_t i = 0; i < std::max<std::size_t>(member.count, 1); ++i) put(*member.type);
      }
      at_ = up(at_, align);
      return;
    }
    to_.resize(up(to_.size() - std::size(kCdr), align) + std::size(kCdr));
    to_.insert(to_.end(), from_ + at_, from_ + at_ + align);
    at_ += align;
  }
  std::vector<std::byte> take() { return std::move(to_); }

 private:
  const std::byte* from_;
  std::size_t at_ = 0;
  std::vector<std::byte> to_{std::begin(kCdr), std::end(kCdr)};
};

Json schema(const Type& type) {
  switch (type.kind) {
    case TypeKind::boolean: return {{"type", "boolean"}};
    case TypeKind::character: return {{"type", "string"}};
    case TypeKind::float32:
    case TypeKind::float64: return {{"type", "number"}};
    case TypeKind::enumeration: {
      Json names = Json::array();
      for (const std::string& name : type.names)
        names.push_back({{"title", name}, {"const", names.size()}});
      return {{"type", "integer"}, {"oneOf", std::move(names)}};
    }
    case TypeKind::structure: break;
    default: return {{"type", "integer"}};
  }
  Json members = Json::object();
  for (const Member& member : type.members) {
    Json one = schema(*member.type);
    if (member.count > 0 && member.type->kind != TypeKind::character)
      one = {{"type", "array"}, {"items", std::move(one)}};
    if (const Unit unit = unit_in(member.name); !unit.text.empty())
      one["description"] = "in " + std::string(unit.text);
    members[member.name] = std::move(one);
  }
  return {{"type", "object"}, {"properties", std::move(members)}};
}

dds::Kind dds_kind(Kind kind) {
  switch (kind) {
    case Kind::status: return dds::Kind::status;
    case Kind::timing_statistics: return dds::Kind::timing_statistics;
    case Kind::event: return dds::Kind::event;
    case Kind::telemetry: break;
  }
  return dds::Kind::telemetry;
}

std::string dump(const Json& document) {
  return document.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace

Topic::Topic(std::string name, std::string_view idl, const std::string& type, bool packed)
    : name_(std::move(name)), types_(idl), layout_(find_type(types_, type)), packed_(packed) {}

Json Topic::channel(std::uint32_t id, const std::string& prefix) const {
  return {{"id", id},
          {"topic", prefix + name_},
          {"encoding", "json"},
          {"schemaName", layout_.type().name},
          {"schemaEncoding", "jsonschema"},
          {"schema", dump(schema(layout_.type()))}};
}

std::string Topic::json(const void* sample) const {
  std::vector<std::byte> message;
  if (packed_) {
    message.assign(std::begin(kCdr), std::end(kCdr));
    const auto* bytes = static_cast<const std::byte*>(sample);
    message.insert(message.end(), bytes, bytes + layout_.size());
  } else {
    Packer packer(sample);
    packer.put(layout_.type());
    message = packer.take();
  }
  return dump(layout_.json(message));
}

Channels::Channels() {
  for (const Kind kind : {Kind::status, Kind::timing_statistics, Kind::event}) {
    const dds::Topic topic = dds::common_topic(dds_kind(kind));
    common_[kind] =
        std::make_unique<Topic>(topic.name, idl_text("lss"), topic.descriptor->m_typename, false);
  }
}

void Channels::add(const Craft& craft) {
  Vehicle& vehicle = vehicles_[craft.id];
  vehicle.first = std::exchange(next_, next_ + kKinds);
  if (plain_.empty()) plain_ = craft.id;
  const cli::Vehicle& kind = *craft.kind;
  if (kind.telemetry == nullptr) return;
  const bool compiled = kind.overlay != nullptr && kind.telemetry == kind.overlay->telemetry.type;
  vehicle.telemetry = std::make_unique<Topic>(dds::telemetry_topic(kind.name, kind.telemetry).name,
                                              kind.idl, kind.telemetry->m_typename, !compiled);
}

void Channels::remove(const std::string& id) {
  vehicles_.erase(id);
  if (plain_ == id) plain_.clear();
}

std::uint32_t Channels::channel(const std::string& id, Kind kind) const {
  const auto vehicle = vehicles_.find(id);
  if (vehicle == vehicles_.end()) return 0;
  if (kind == Kind::telemetry && vehicle->second.telemetry == nullptr) return 0;
  return vehicle->second.first + static_cast<std::uint32_t>(kind);
}

std::optional<Channels::Place> Channels::find(std::uint32_t channel) const {
  for (const auto& [id, vehicle] : vehicles_) {
    if (channel < vehicle.first || channel >= vehicle.first + kKinds) continue;
    const auto kind = static_cast<Kind>(channel - vehicle.first);
    if (this->channel(id, kind) == channel) return Place{id, kind};
  }
  return std::nullopt;
}

const Topic& Channels::topic(const std::string& id, Kind kind) const {
  return kind == Kind::telemetry ? *vehicles_.at(id).telemetry : *common_.at(kind);
}

Json Channels::advertise(const std::string& id, const std::string& only) const {
  const std::string prefix = only == id || plain_ == id ? "" : id + "/";
  Json list = Json::array();
  for (std::uint32_t i = 0; i < kKinds; ++i) {
    const auto kind = static_cast<Kind>(i);
    if (const std::uint32_t number = channel(id, kind); number != 0)
      list.push_back(topic(id, kind).channel(number, prefix));
  }
  return {{"op", "advertise"}, {"channels", std::move(list)}};
}

Json Channels::unadvertise(const std::string& id) const {
  Json list = Json::array();
  for (std::uint32_t i = 0; i < kKinds; ++i) {
    if (const std::uint32_t number = channel(id, static_cast<Kind>(i)); number != 0)
      list.push_back(number);
  }
  return {{"op", "unadvertise"}, {"channelIds", std::move(list)}};
}

Json server_info(const std::string& session) {
  return {{"op", "serverInfo"},
          {"name", "lss-ground " LSS_VERSION},
          {"capabilities", Json::array()},
          {"sessionId", session}};
}

Json status(Level level, const std::string& text, const std::string& id) {
  Json json = {{"op", "status"}, {"level", static_cast<int>(level)}, {"message", text}};
  if (!id.empty()) json["id"] = id;
  return json;
}

FramePtr message_data(std::uint32_t subscription, std::uint64_t utc_ns, std::string_view payload) {
  std::string bytes(1, static_cast<char>(kMessageData));
  const auto put = [&](std::uint64_t number, int size) {
    for (int i = 0; i < size; ++i) bytes += static_cast<char>(number >> (8 * i) & 0xff);
  };
  put(subscription, 4);
  put(utc_ns, 8);
  bytes += payload;
  return std::make_shared<Frame>(bytes, true);
}

namespace {

std::uint32_t number(const nlohmann::json& value) {
  if (!value.is_number_unsigned() || value.get<std::uint64_t>() > UINT32_MAX)
    throw std::runtime_error("an id is a number of 32 bits");
  return value.get<std::uint32_t>();
}

const nlohmann::json& list(const nlohmann::json& all, const char* name) {
  const nlohmann::json& value = all.at(name);
  if (!value.is_array()) throw std::runtime_error(std::string(name) + " is a list");
  return value;
}

}  // namespace

tl::expected<Request, std::string> parse(std::string_view text) {
  try {
    const auto json = nlohmann::json::parse(text, nullptr, false);
    if (!json.is_object()) throw std::runtime_error("a message is a JSON object");
    const std::string op = json.value("op", "");
    Request request;
    if (op == "subscribe") {
      for (const auto& one : list(json, "subscriptions"))
        request.subscribe.push_back({number(one.at("id")), number(one.at("channelId"))});
    } else if (op == "unsubscribe") {
      for (const auto& id : list(json, "subscriptionIds"))
        request.unsubscribe.push_back(number(id));
    } else {
      throw std::runtime_error("this connection only shows: subscribe and unsubscribe");
    }
    return request;
  } catch (const std::exception& e) {  // the library throws, too
    return tl::unexpected(std::string(e.what()));
  }
}

}  // namespace lss::ground::foxglove
