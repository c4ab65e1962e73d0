#include "tools/lss-cli/recording/idl_types.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {

std::size_t size_of(Kind kind) {
  switch (kind) {
    case Kind::boolean:
    case Kind::octet:
    case Kind::character: return 1;
    case Kind::int16:
    case Kind::uint16: return 2;
    case Kind::int32:
    case Kind::uint32:
    case Kind::float32:
    case Kind::enumeration: return 4;
    case Kind::int64:
    case Kind::uint64:
    case Kind::float64: return 8;
    case Kind::structure: break;
  }
  return 0;
}

namespace {

constexpr std::size_t kEncapsulation = 4;
constexpr std::byte kLittleEndianCdr{1};

struct Primitive {
  const char* name;
  Kind kind;
};
constexpr Primitive kPrimitives[] = {
    {"boolean", Kind::boolean}, {"octet", Kind::octet},
    {"uint8", Kind::octet},     {"char", Kind::character},
    {"short", Kind::int16},     {"unsigned short", Kind::uint16},
    {"long", Kind::int32},      {"unsigned long", Kind::uint32},
    {"long long", Kind::int64}, {"unsigned long long", Kind::uint64},
    {"float", Kind::float32},   {"double", Kind::float64},
};

bool is_word(char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_'; }

// Words, and every other sign alone, without comments.
std::vector<std::string> tokens(std::string_view idl) {
  std::vector<std::string> list;
  for (std::size_t i = 0; i < idl.size();) {
    if (idl.substr(i, 2) == "//") {
      i = std::min(idl.find('\n', i), idl.size());
    } else if (idl.substr(i, 2) == "/*") {
      const std::size_t end = idl.find("*/", i);
      i = end == std::string_view::npos ? idl.size() : end + 2;
    } else if (is_word(idl[i])) {
      std::size_t end = i;
      while (end < idl.size() && is_word(idl[end])) ++end;
      list.emplace_back(idl.substr(i, end - i));
      i = end;
    } else {
      if (std::isspace(static_cast<unsigned char>(idl[i])) == 0) list.emplace_back(1, idl[i]);
      ++i;
    }
  }
  return list;
}

template <class Number>
Number read(Bytes message, std::size_t offset) {
  Number value{};
  std::memcpy(&value, message.data() + kEncapsulation + offset, sizeof value);
  return value;
}

std::string text_at(Bytes message, std::size_t offset, std::size_t size) {
  const char* begin = reinterpret_cast<const char*>(message.data()) + kEncapsulation + offset;
  return {begin, std::find(begin, begin + size, '\0')};
}

nlohmann::ordered_json value_at(const Type& type, Bytes message, std::size_t offset) {
  switch (type.kind) {
    case Kind::boolean: return read<std::uint8_t>(message, offset) != 0;
    case Kind::octet: return read<std::uint8_t>(message, offset);
    case Kind::character: return text_at(message, offset, 1);
    case Kind::int16: return read<std::int16_t>(message, offset);
    case Kind::uint16: return read<std::uint16_t>(message, offset);
    case Kind::int32: return read<std::int32_t>(message, offset);
    case Kind::uint32:
    case Kind::enumeration: return read<std::uint32_t>(message, offset);
    case Kind::int64: return read<std::int64_t>(message, offset);
    case Kind::uint64: return read<std::uint64_t>(message, offset);
    case Kind::float32: return static_cast<double>(read<float>(message, offset));
    case Kind::float64: return read<double>(message, offset);
    case Kind::structure: break;
  }
  return nullptr;
}

// The layout with the alignment of CDR: a number at a multiple of its size.
void lay_out(const Type& type, const std::string& name, std::size_t& at,
             std::vector<Column>& columns) {
  if (type.kind != Kind::structure) {
    const std::size_t size = size_of(type.kind);
    at = (at + size - 1) / size * size;
    columns.push_back({name, &type, at, 0});
    at += size;
    return;
  }
  const std::string prefix = name.empty() ? "" : name + ".";
  for (const Member& member : type.members) {
    if (member.type->kind == Kind::character && member.count > 0) {
      columns.push_back({prefix + member.name, member.type, at, member.count});
      at += member.count;
    } else if (member.count == 0) {
      lay_out(*member.type, prefix + member.name, at, columns);
    } else {
      for (std::size_t i = 0; i < member.count; ++i)
        lay_out(*member.type, fmt::format("{}{}[{}]", prefix, member.name, i), at, columns);
    }
  }
}

// Takes the columns of the type in their order.
nlohmann::ordered_json nest(const Layout& layout, const Type& type, const Column*& column,
                            Bytes message) {
  if (type.kind != Kind::structure) return layout.json(*column++, message);
  nlohmann::ordered_json object = nlohmann::ordered_json::object();
  for (const Member& member : type.members) {
    if (member.count == 0 || member.type->kind == Kind::character) {
      object[member.name] = nest(layout, *member.type, column, message);
      continue;
    }
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < member.count; ++i)
      list.push_back(nest(layout, *member.type, column, message));
    object[member.name] = std::move(list);
  }
  return object;
}

}  // namespace

class Parser {
 public:
  Parser(std::string_view idl, Types& types) : types_(types) {
    if (idl.size() > most::kIdl)
      refuse(fmt::format("it has {} bytes, at most {} are read", idl.size(), most::kIdl));
    tokens_ = tokens(idl);
    for (const Primitive& primitive : kPrimitives) {
      auto type = std::make_unique<Type>();
      type->kind = primitive.kind;
      type->name = primitive.name;
      types_.types_.emplace(primitive.name, std::move(type));
    }
    while (at_ < tokens_.size()) definition();
  }

 private:
  [[noreturn]] void refuse(const std::string& what) const {
    throw Failure(ExitCode::usage, "its IDL cannot be read: " + what,
                  "it uses more of IDL than the files of lssd do");
  }
  const std::string& peek() const {
    if (at_ >= tokens_.size()) refuse("it ends too early");
    return tokens_[at_];
  }
  std::string take() {
    std::string token = peek();
    ++at_;
    return token;
  }
  std::string take_name() {
    std::string name = take();
    if (name.size() > most::kName)
      refuse(
          fmt::format("a name has {} characters, at most {} are read", name.size(), most::kName));
    return name;
  }
  bool accept(std::string_view token) {
    if (at_ >= tokens_.size() || tokens_[at_] != token) return false;
    ++at_;
    return true;
  }
  void expect(std::string_view token) {
    if (!accept(token))
      refuse(fmt::format("'{}' in the place of '{}'", peek().substr(0, most::kName), token));
  }
  std::string scoped(const std::string& name) const {
    std::string all;
    for (const std::string& module : modules_) all += module + "::";
    return all + name;
  }
  void annotations() {
    while (accept("@")) {
      take();
      if (accept("(")) {
        while (!accept(")")) take();
      }
    }
  }

  void definition() {
    annotations();
    if (accept("module")) {
      modules_.push_back(take_name());
      if (modules_.size() > most::kModuleDepth)
        refuse(fmt::format("modules are nested deeper than {}", most::kModuleDepth));
      expect("{");
      while (!accept("}")) definition();
      expect(";");
      modules_.pop_back();
    } else if (accept("enum")) {
      auto type = make(Kind::enumeration);
      expect("{");
      do {
        type->names.push_back(take_name());
        check_count(*type, type->names.size());
      } while (accept(","));
      expect("}");
      expect(";");
      add(std::move(type));
    } else if (accept("struct")) {
      auto type = make(Kind::structure);
      type->columns = 0;
      expect("{");
      while (!accept("}")) member(*type);
      expect(";");
      add(std::move(type));
    } else {
      refuse("do not know '" + peek().substr(0, most::kName) + "'");
    }
  }

  std::unique_ptr<Type> make(Kind kind) {
    auto type = std::make_unique<Type>();
    type->kind = kind;
    type->name = scoped(take_name());
    return type;
  }

  // Only when it is complete, so that no type contains itself; once, because others refer to it.
  void add(std::unique_ptr<Type> type) {
    if (type->kind == Kind::structure && type->members.empty())
      refuse(type->name + " has no members");
    columns_ += type->columns;
    if (columns_ > most::kColumns)
      refuse(fmt::format("its types have more than {} columns", most::kColumns));
    const std::string name = type->name;
    if (!types_.types_.try_emplace(name, std::move(type)).second)
      refuse(name + " is defined twice");
  }

  void check_count(const Type& type, std::size_t count) const {
    if (count > most::kMembers)
      refuse(fmt::format("{} has more than {} members", type.name, most::kMembers));
  }

  void member(Type& type) {
    annotations();
    const Type* of = type_name();
    do {
      Member& member = type.members.emplace_back();
      check_count(type, type.members.size());
      member.name = take_name();
      member.type = of;
      if (accept("[")) {
        const std::string count = take();
        member.count = std::strtoul(count.c_str(), nullptr, 10);
        if (member.count == 0 || member.count > most::kElements)
          refuse(fmt::format("an array of {}, at most {} are read", count.substr(0, most::kName),
                             most::kElements));
        expect("]");
      }
      measure(type, member);
    } while (accept(","));
    expect(";");
  }

  // The columns and size that the member adds to the type.
  void measure(Type& type, const Member& member) const {
    const bool text = member.type->kind == Kind::character;
    type.columns +=
        text || member.count == 0 ? member.type->columns : member.type->columns * member.count;
    if (type.columns > most::kColumns)
      refuse(fmt::format("{} has more than {} columns", type.name, most::kColumns));
    type.depth = std::max(type.depth, member.type->depth + 1);
    if (type.depth > most::kStructDepth)
      refuse(fmt::format("structs are nested deeper than {}", most::kStructDepth));
    constexpr std::size_t kPlace = std::string_view("[99999].").size();
    type.longest = std::max(type.longest, member.name.size() + kPlace + member.type->longest);
    if (type.longest > most::kName)
      refuse(fmt::format("names of columns of {} are longer than {}", type.name, most::kName));
  }

  const Type* type_name() {
    std::string name = take();
    while (name == "unsigned" || (name.ends_with("long") && peek() == "long")) name += " " + take();
    while (accept(":")) {
      expect(":");
      name += "::" + take();
    }
    for (const std::string& candidate : {scoped(name), name}) {
      if (const Type* found = types_.find(candidate)) return found;
    }
    refuse(fmt::format("there is no type '{}' before it is used", name.substr(0, most::kName)));
  }

  std::vector<std::string> tokens_;
  std::size_t at_ = 0;
  std::vector<std::string> modules_;
  std::size_t columns_ = 0;
  Types& types_;
};

Types::Types(std::string_view idl) { Parser(idl, *this); }

const Type* Types::find(std::string_view name) const {
  const auto found = types_.find(name);
  return found == types_.end() ? nullptr : found->second.get();
}

Layout::Layout(const Type& type) : type_(type) { lay_out(type, "", size_, columns_); }

const Column* Layout::find(std::string_view name) const {
  const auto found = std::ranges::find(columns_, name, &Column::name);
  return found == columns_.end() ? nullptr : &*found;
}

void Layout::check(Bytes message) const {
  const bool plain = message.size() >= kEncapsulation && message[0] == std::byte{0} &&
                     message[1] == kLittleEndianCdr;
  if (plain && message.size() >= kEncapsulation + size_) return;
  throw Failure(ExitCode::usage,
                fmt::format("a message of {} bytes is no {} in little-endian CDR", message.size(),
                            type_.name),
                "the file is damaged, or was not made by lss-cli record");
}

double Layout::number(const Column& column, Bytes message) const {
  if (column.text_size > 0) return std::numeric_limits<double>::quiet_NaN();
  const nlohmann::ordered_json value = value_at(*column.type, message, column.offset);
  if (value.is_boolean()) return value.get<bool>() ? 1 : 0;
  return value.is_number() ? value.get<double>() : std::numeric_limits<double>::quiet_NaN();
}

std::string Layout::text(const Column& column, Bytes message) const {
  if (column.text_size > 0) return text_at(message, column.offset, column.text_size);
  if (column.type->kind == Kind::enumeration) {
    const auto index = read<std::uint32_t>(message, column.offset);
    if (index < column.type->names.size()) return column.type->names[index];
  }
  return value_at(*column.type, message, column.offset)
      .dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

nlohmann::ordered_json Layout::json(const Column& column, Bytes message) const {
  if (column.text_size > 0) return text_at(message, column.offset, column.text_size);
  nlohmann::ordered_json value = value_at(*column.type, message, column.offset);
  const bool broken = value.is_number_float() && !std::isfinite(value.get<double>());
  return broken ? nlohmann::ordered_json() : value;
}

nlohmann::ordered_json Layout::json(Bytes message) const {
  const Column* column = columns_.data();
  return nest(*this, type_, column, message);
}

}  // namespace lss::cli::recording
