#include "tools/lss-cli/recording/record_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "daemon/record/json.h"
#include "daemon/record/limits.h"
#include "tools/lss-cli/recording/recording.h"
#include "tools/lss-cli/show/failure.h"
#include "tools/lss-cli/show/names.h"

namespace lss::cli::recording {
namespace {

using Json = nlohmann::ordered_json;

[[noreturn]] void broken(const std::string& what) {
  throw Failure(ExitCode::failed, "its records are not as its header describes them: " + what,
                "was the file made by lssd? Take another copy of it");
}

// "in.samples[12].value" as "in.samples[*].value": the same of any element.
std::string loosened(const std::string& pattern) {
  std::string loose;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    loose += pattern[i];
    if (pattern[i] != '[') continue;
    const std::size_t end = pattern.find_first_not_of("0123456789", i + 1);
    if (end == std::string::npos || end == i + 1 || pattern[end] != ']') continue;
    loose += '*';
    i = end - 1;
  }
  return loose;
}

bool names_field(const std::string& pattern, const std::string& path) {
  for (const std::string& full : {pattern, "telemetry." + pattern}) {
    if (matches(full, path) || matches(full + ".*", path) || matches(full + "[*", path))
      return true;
  }
  return false;
}

// The name that lssd gives a number (daemon/record/json.h); nullptr: as a number.
using Said = Json (*)(std::uint64_t, const OwnCodes&);
Said said(const std::string& path) {
  if (path == "state.controller.state" || path == "telemetry.state")
    return [](std::uint64_t x, const OwnCodes&) -> Json { return kStateNames[x & 3]; };
  if (path.ends_with("verdict.reason")) {
    return [](std::uint64_t x, const OwnCodes& own) {
      return record::name_of(info(static_cast<Reason>(x), own), static_cast<std::uint16_t>(x));
    };
  }
  if (matches("state.faults[*].id", path)) {
    return [](std::uint64_t x, const OwnCodes& own) {
      return record::name_of(info(static_cast<FaultId>(x), own), static_cast<std::uint16_t>(x));
    };
  }
  return nullptr;
}

template <class T>
T load(const std::uint8_t* at) {
  T x;
  std::memcpy(&x, at, sizeof x);
  return x;
}

Json real(double x) { return std::isfinite(x) ? Json(x) : Json(); }

}  // namespace

// ---- the fields

struct RecordLayout::Node {
  const RecordType& type;
  std::string path;
  bool in_list = false, chosen = true;
  Said said = nullptr;
  bool event = false;
  std::size_t column = SIZE_MAX;               // none
  std::vector<std::unique_ptr<Node>> parts{};  // members, elements, alternatives

  bool leaf() const { return type.number() || type.text(); }
};

std::unique_ptr<RecordLayout::Node> RecordLayout::expand(const RecordType& type, std::string path,
                                                         bool in_list) {
  auto node = std::make_unique<Node>(Node{.type = type, .path = std::move(path)});
  node->in_list = in_list;
  node->said = said(node->path);
  node->event = matches("outbox.events[*]", node->path) && type.what == '{';
  if (node->leaf()) return node;
  const auto element = [&](std::size_t i, bool list) {
    node->parts.push_back(
        expand(*type.members.front().type, fmt::format("{}[{}]", node->path, i), list));
  };
  if (type.what == '[') {
    for (std::size_t i = 0; i < type.count; ++i) element(i, in_list);
  } else if (type.what == '<') {
    element(0, true);
  } else {
    for (const auto& [name, member] : type.members) {
      const bool inside = !name.empty() && !node->path.empty();
      node->parts.push_back(expand(*member, node->path + (inside ? "." : "") + name, in_list));
    }
  }
  return node;
}

// Reads the chosen fields of a record, from its beginning to its end.
class RecordLayout::Walk {
 public:
  explicit Walk(RecordLayout& layout, Bytes record) : layout_(layout), record_(record) {}

  Json json() {
    Json json = json_of(*layout_.root_);
    end();
    return json;
  }
  // take(node, value) for each leaf.
  template <class Take>
  void leaves(Take&& take) {
    leaves_of(*layout_.root_, take);
    end();
  }

 private:
  const std::uint8_t* next_bytes(std::size_t count) {
    if (record_.size() - at_ < count)
      broken(fmt::format("one ends after {} bytes, in the middle of a field", record_.size()));
    const std::uint8_t* begin = record_.data() + at_;
    at_ += count;
    return begin;
  }
  void end() const {
    if (at_ != record_.size())
      broken(fmt::format("one has {} bytes, its fields have {}", record_.size(), at_));
  }

  Json text(const Node& node) {
    const char* begin = reinterpret_cast<const char*>(next_bytes(node.type.count));
    return std::string(begin, ::strnlen(begin, node.type.count));
  }
  Json number(const RecordType& type, Said said) {
    const std::uint8_t* at = next_bytes(type.count);
    if (type.what == 'f')
      return real(type.count == 4 ? static_cast<double>(load<float>(at)) : load<double>(at));
    if (type.what == 'b') return *at != 0;
    std::uint64_t bits = 0;
    std::memcpy(&bits, at, type.count);
    if (said != nullptr) return said(bits, layout_.own_);
    if (type.what == 'u') return bits;
    const int unused = static_cast<int>(64 - 8 * type.count);  // the sign is in the last byte
    return static_cast<std::int64_t>(bits << unused) >> unused;
  }

  void skip(const RecordType& type) {
    if (type.size) {
      next_bytes(*type.size);
    } else if (type.what == '<') {
      for (std::uint32_t left = count(type); left > 0; --left) skip(*type.members.front().type);
    } else if (type.what == '(') {
      skip(*type.members[alternative(type)].type);
    } else if (type.what == '[') {
      for (std::size_t i = 0; i < type.count; ++i) skip(*type.members.front().type);
    } else {
      for (const auto& member : type.members) skip(*member.type);
    }
  }
  std::uint32_t count(const RecordType& list) {
    const auto n = load<std::uint32_t>(next_bytes(4));
    const std::size_t least = std::max<std::size_t>(1, list.members.front().type->least);
    if (n > (record_.size() - at_) / least) broken(fmt::format("a list of {} elements", n));
    return n;
  }
  std::size_t alternative(const RecordType& type) {
    const std::uint8_t index = *next_bytes(1);
    if (index >= type.members.size()) broken(fmt::format("an alternative {}", index));
    return index;
  }
  // The number of elements in this record.
  std::size_t grow(Node& list) {
    const std::uint32_t n = count(list.type);
    while (list.parts.size() < n) {
      layout_.fields_ += list.type.members.front().type->fields;
      if (layout_.fields_ > record::most::kFields)
        broken(fmt::format("one has more than {} fields", record::most::kFields));
      list.parts.push_back(expand(*list.type.members.front().type,
                                  fmt::format("{}[{}]", list.path, list.parts.size()), true));
      layout_.mark(*list.parts.back());
    }
    return n;
  }

  Json json_of(Node& node) {
    switch (node.type.what) {
      case '{': return structure(node);
      case '[': return node.leaf() ? text(node) : elements(node, node.parts.size());
      case '<': return elements(node, grow(node));
      case '(': {
        Node& part = *node.parts[alternative(node.type)];
        if (part.chosen) return json_of(part);
        skip(part.type);
        return Json::object();
      }
      default: return number(node.type, node.said);
    }
  }
  Json structure(Node& node) {
    Json json = Json::object();
    const std::size_t begin = at_;
    for (std::size_t i = 0; i < node.parts.size(); ++i) {
      Node& part = *node.parts[i];
      if (part.chosen) {
        json[node.type.members[i].name] = json_of(part);
      } else {
        skip(part.type);
      }
    }
    if (node.event) name_event(node, begin, json);
    return json;
  }
  void name_event(const Node& node, std::size_t begin, Json& json) const {
    for (const auto& [name, type] : node.type.members) {
      if (name == "id" && type->what == 'u' && type->count == 2)
        json["name"] =
            record::event_name(load<std::uint16_t>(record_.data() + begin), layout_.own_);
      if (!type->size) return;
      begin += *type->size;
    }
  }
  Json elements(Node& node, std::size_t count) {
    Json json = Json::array();
    for (std::size_t i = 0; i < count; ++i) {
      Node& part = *node.parts[i];
      if (!part.chosen) {
        skip(part.type);
        continue;
      }
      while (json.size() < i) json.push_back(nullptr);
      json.push_back(json_of(part));
    }
    return json;
  }

  template <class Take>
  void leaves_of(Node& node, Take& take) {
    if (!node.chosen) return skip(node.type);
    if (node.leaf()) {
      take(node, node.type.text() ? text(node) : number(node.type, nullptr));
    } else if (node.type.what == '(') {
      leaves_of(*node.parts[alternative(node.type)], take);
    } else {
      const std::size_t count = node.type.what == '<' ? grow(node) : node.parts.size();
      for (std::size_t i = 0; i < count; ++i) leaves_of(*node.parts[i], take);
    }
  }

  RecordLayout& layout_;
  Bytes record_;
  std::size_t at_ = 0;
};

// ---- choice of fields

RecordLayout::RecordLayout(std::string_view schema)
    : type_(parse_schema(schema)), fields_(type_->fields) {
  root_ = expand(*type_, "", false);
  choose({"*"});
}
RecordLayout::~RecordLayout() = default;
RecordLayout::RecordLayout(RecordLayout&&) noexcept = default;

bool RecordLayout::meant(const std::string& path) const {
  return std::ranges::any_of(
      patterns_, [&](const std::string& pattern) { return names_field(pattern, path); });
}

// An element of a list, once the list is long enough.
bool RecordLayout::may_be_meant(const Node& node) const {
  if (node.leaf()) {
    return std::ranges::any_of(
        loose_, [&](const std::string& pattern) { return names_field(pattern, node.path); });
  }
  return std::ranges::any_of(node.parts, [&](const auto& part) { return may_be_meant(*part); });
}

void RecordLayout::mark(Node& node) const {
  if (node.leaf()) {
    node.chosen = meant(node.path);
    return;
  }
  node.chosen = false;
  for (const auto& part : node.parts) {
    mark(*part);
    node.chosen = node.chosen || part->chosen;
  }
  if (node.type.what == '<') node.chosen = lists_ && (node.chosen || may_be_meant(node));
}

void RecordLayout::choose(const std::vector<std::string>& patterns) {
  std::vector<std::string> names;
  std::vector<bool> found(patterns.size(), false);
  const auto look = [&](const auto& self, const Node& node) -> void {
    if (node.leaf()) {
      names.push_back(node.path);
      for (std::size_t i = 0; i < patterns.size(); ++i) {
        found[i] = found[i] || names_field(patterns[i], node.path) ||
                   (node.in_list && names_field(loosened(patterns[i]), node.path));
      }
    }
    for (const auto& part : node.parts) self(self, *part);
  };
  look(look, *root_);
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    if (found[i]) continue;
    std::vector<std::string> known = names;
    for (const std::string& name : names)
      if (name.starts_with("telemetry.")) known.push_back(name.substr(name.find('.') + 1));
    const std::string guess = did_you_mean(patterns[i], known);
    throw Failure(
        ExitCode::unknown_name, fmt::format("there is no field '{}' in it", patterns[i]),
        guess.empty() ? "see their names with: lss-cli log list FILE --columns '*'" : guess);
  }
  patterns_ = patterns;
  loose_.clear();
  for (const std::string& pattern : patterns) loose_.push_back(loosened(pattern));
  lists_ = true;
  mark(*root_);
}

void RecordLayout::choose_what_is_always_there() {
  choose({"*"});
  lists_ = false;
  mark(*root_);
}

// ---- reading

Json RecordLayout::json(Bytes record) { return Walk(*this, record).json(); }

void RecordLayout::look(Bytes record) {
  Walk(*this, record).leaves([](const Node&, const Json&) {});
}

// Alternatives may have fields of one name.
void RecordLayout::number_columns() {
  columns_.clear();
  std::map<std::string, std::size_t> numbers;
  const auto number = [&](const auto& self, Node& node) -> void {
    if (!node.chosen) return;
    if (node.leaf()) {
      const auto [at, added] = numbers.try_emplace(node.path, columns_.size());
      if (added) columns_.push_back({node.path, node.type.name()});
      node.column = at->second;
    }
    for (const auto& part : node.parts) self(self, *part);
  };
  number(number, *root_);
}

std::vector<RecordLayout::Column> RecordLayout::columns() {
  number_columns();
  return columns_;
}

void RecordLayout::values(Bytes record, std::vector<Json>& values) {
  values.assign(columns_.size(), nullptr);
  Walk(*this, record).leaves([&](const Node& node, Json value) {
    if (node.column < values.size()) values[node.column] = std::move(value);
  });
}

std::optional<std::size_t> RecordLayout::place(std::string_view name) const {
  const RecordType* type = type_.get();
  std::size_t at = 0;
  while (true) {
    const std::string_view first = name.substr(0, name.find('.'));
    const RecordType* next = nullptr;
    for (const auto& member : type->members) {
      if (member.name == first) {
        next = member.type.get();
        break;
      }
      if (!member.type->size) return std::nullopt;
      at += *member.type->size;
    }
    if (next == nullptr) return std::nullopt;
    if (first.size() == name.size())
      return next->number() && next->count == 8 ? std::optional(at) : std::nullopt;
    if (next->what != '{') return std::nullopt;
    type = next;
    name.remove_prefix(first.size() + 1);
  }
}

}  // namespace lss::cli::recording
