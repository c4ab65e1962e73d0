#include "drivers/canopen/description.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <set>

namespace lss::canopen {
namespace {

using Text = std::string_view;

constexpr Text kByteOrderMark = "\xEF\xBB\xBF";  // of UTF-8: some editors write it

Text trimmed(Text text) {
  const auto blank = [](char c) { return c == ' ' || c == '\t' || c == '\r'; };
  while (!text.empty() && blank(text.front())) text.remove_prefix(1);
  while (!text.empty() && blank(text.back())) text.remove_suffix(1);
  return text;
}

std::string lower(Text text) {
  std::string result(text);
  for (char& c : result) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c;
  return result;
}

// For a sentence: short, and without control characters.
std::string quoted(Text text) {
  std::string result = "\"";
  for (const char c : text.substr(0, 40)) result += c >= ' ' && c < 127 ? c : '?';
  return result + (text.size() > 40 ? "...\"" : "\"");
}

// Decimal, 0x hexadecimal, 0 octal (CiA 306).
std::optional<std::int64_t> number(Text text) {
  const bool negative = !text.empty() && text.front() == '-';
  if (negative) text.remove_prefix(1);
  int base = 10;
  if (text.size() > 2 && text[0] == '0' && (text[1] == 'x' || text[1] == 'X')) {
    base = 16;
    text.remove_prefix(2);
  } else if (text.size() > 1 && text[0] == '0') {
    base = 8;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc() || end != text.data() + text.size() || value > 0xFFFF'FFFF) return {};
  return negative ? -static_cast<std::int64_t>(value) : static_cast<std::int64_t>(value);
}

constexpr std::int64_t kVariable = 7, kArray = 8, kRecord = 9;  // ObjectType, CiA 301

struct Type {
  std::uint8_t bytes;
  bool is_signed;
};
// Of a DataType of CiA 301.
Type type_of(std::int64_t number) {
  switch (number) {
    case 1:  // BOOLEAN
    case 5: return {1, false};
    case 2: return {1, true};
    case 3: return {2, true};
    case 4: return {4, true};
    case 6: return {2, false};
    case 7: return {4, false};
    default: return {0, false};
  }
}

struct Value {
  std::string text;
  int line;
};
struct Section {
  std::string name;
  int line = 0;
  std::map<std::string, Value> values;  // by key, lower case
};

// [1A00sub1]
struct Place {
  std::uint16_t index;
  std::uint8_t sub;
};
std::optional<Place> place_of(const std::string& name) {
  const auto hex = [&](std::size_t from, std::size_t count) -> std::optional<unsigned> {
    unsigned value = 0;
    const char* begin = name.data() + from;
    const auto [end, error] = std::from_chars(begin, begin + count, value, 16);
    if (error != std::errc() || end != begin + count || count == 0) return {};
    return value;
  };
  if (name.size() == 4) {
    const auto index = hex(0, 4);
    if (index) return Place{static_cast<std::uint16_t>(*index), 0};
  }
  if (name.size() >= 8 && name.size() <= 9 && name.compare(4, 3, "sub") == 0) {
    const auto index = hex(0, 4), sub = hex(7, name.size() - 7);
    if (index && sub)
      return Place{static_cast<std::uint16_t>(*index), static_cast<std::uint8_t>(*sub)};
  }
  return {};
}

class Reader {
 public:
  ReadDescription read(Text text) {
    if (text.size() > kMostDescriptionBytes) {
      wrong(1, "the file is larger than 256 KiB");
      return std::move(result_);
    }
    if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    split(text);
    for (const Section& section : sections_) take(section);
    std::ranges::sort(objects(), [](const DescribedObject& a, const DescribedObject& b) {
      return std::pair(a.index, a.sub) < std::pair(b.index, b.sub);
    });
    for (const DescribedSignal& signal : result_.description.signals) check(signal);
    if (sections_.empty()) wrong(1, "there is no section in it: is it an EDS or DCF file?");
    return std::move(result_);
  }

 private:
  std::vector<DescribedObject>& objects() { return result_.description.objects; }

  void wrong(int line, const std::string& sentence) {
    if (result_.errors.size() < kMostSentences)
      result_.errors.push_back("line " + std::to_string(line) + ": " + sentence);
  }

  void split(Text text) {
    std::set<std::string> names;
    int line = 0;
    for (std::size_t at = 0; at < text.size() && result_.errors.size() < kMostSentences;) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      const Text whole = text.substr(at, end - at);
      at = end + 1;
      ++line;
      if (whole.size() > kMostLine) {
        wrong(line, "the line is longer than 1024 characters");
        continue;
      }
      const Text one = trimmed(whole);
      if (one.find('\0') != Text::npos) {
        wrong(line, "there is a NUL in it: this is no text");
      } else if (one.empty() || one.front() == ';' || one.front() == '#') {
        continue;
      } else if (one.front() == '[') {
        begin_section(one, line, names);
      } else {
        take_line(one, line);
      }
    }
  }

  void begin_section(Text one, int line, std::set<std::string>& names) {
    if (one.back() != ']' || one.size() < 3)
      return wrong(line, quoted(one) + " is no section: write [NAME]");
    if (sections_.size() > 2 * kMostObjects) return wrong(line, "there are too many sections");
    const std::string name = lower(trimmed(one.substr(1, one.size() - 2)));
    if (!names.insert(name).second)
      wrong(line, "section [" + name.substr(0, 40) + "] is there twice");
    sections_.push_back({name, line, {}});
  }

  void take_line(Text one, int line) {
    const std::size_t equals = one.find('=');
    if (equals == Text::npos || equals == 0)
      return wrong(line, quoted(one) + " is neither [SECTION] nor KEY=VALUE");
    if (sections_.empty()) return wrong(line, "there is no section before this line");
    const std::string key = lower(trimmed(one.substr(0, equals)));
    auto& values = sections_.back().values;
    if (values.size() >= kMostObjects)
      return wrong(line, "there are too many lines in its section");
    const bool fresh =
        values.try_emplace(key, Value{std::string(trimmed(one.substr(equals + 1))), line}).second;
    if (!fresh) wrong(line, quoted(key) + " is there twice in its section");
  }

  void take(const Section& section) {
    if (section.name == "deviceinfo") {
      const auto product = section.values.find("productname");
      if (product != section.values.end())
        result_.description.product = product->second.text.substr(0, 80);
    }
    if (section.name == "lsssignals") return take_signals(section);
    if (section.name.size() == 9 && section.name.ends_with("value") &&
        place_of(section.name.substr(0, 4)))
      return wrong(section.line,
                   "[" + section.name + "] is not read: give each sub-index a section of its own");
    if (const auto place = place_of(section.name)) take_object(section, *place);
  }

  // nullopt: it is not there, or depends on the node's number, or is no number.
  std::optional<std::int64_t> number_of(const Section& section, const char* key, bool strict) {
    const auto at = section.values.find(key);
    if (at == section.values.end() || at->second.text.empty()) return {};
    if (lower(at->second.text).find("$nodeid") != std::string::npos) return {};
    const auto value = number(at->second.text);
    if (!value && strict)
      wrong(at->second.line, quoted(at->second.text) + " is no number of 32 bits");
    return value;
  }

  void take_object(const Section& section, const Place& place) {
    const auto data_type = number_of(section, "datatype", true);
    if (!data_type) return;
    const auto kind = number_of(section, "objecttype", true).value_or(kVariable);
    const auto compact = number_of(section, "compactsubobj", true).value_or(0);
    if (compact < 0 || compact > 254)
      return wrong(section.line, "[" + section.name + "] CompactSubObj is not 1 to 254");
    if ((kind == kArray || kind == kRecord) && compact == 0) return;  // its sub-indices have types
    const Type type = type_of(*data_type);
    DescribedObject object{.index = place.index,
                           .sub = place.sub,
                           .bytes = type.bytes,
                           .is_signed = type.is_signed,
                           .line = section.line};
    const auto access = section.values.find("accesstype");
    const std::string how = access != section.values.end() ? lower(access->second.text) : "";
    if (type.bytes != 0 && how != "ro" && how != "wo" && how != "rw" && how != "rwr" &&
        how != "rww" && how != "const")
      wrong(section.line,
            "[" + section.name + "] has no AccessType of ro, wo, rw, rwr, rww, const");
    object.readable = how != "wo";
    object.writable = how == "wo" || how.starts_with("rw");
    object.mappable = number_of(section, "pdomapping", true).value_or(0) != 0;
    object.value = bits_of(section, "parametervalue", type);
    object.by_itself = bits_of(section, "defaultvalue", type);
    if (compact == 0) return add(object);
    for (std::int64_t sub = 1; sub <= compact; ++sub) {
      object.sub = static_cast<std::uint8_t>(sub);
      add(object);
    }
  }

  // As the bits of an SDO.
  std::optional<std::uint32_t> bits_of(const Section& section, const char* key, const Type& type) {
    if (type.bytes == 0) return {};
    const auto value = number_of(section, key, true);
    if (!value) return {};
    const std::int64_t range = std::int64_t{1} << (8 * type.bytes);
    if (*value >= range || *value < -range / 2) {
      wrong(section.values.at(key).line, quoted(section.values.at(key).text) +
                                             " does not fit into " + std::to_string(type.bytes) +
                                             " bytes");
      return {};
    }
    return static_cast<std::uint32_t>(*value & (range - 1));
  }

  void add(const DescribedObject& object) {
    if (objects().size() >= kMostObjects) return wrong(object.line, "there are too many objects");
    const unsigned key = unsigned{object.index} << 8 | object.sub;
    if (!known_.insert(key).second) return wrong(object.line, "the object is there twice");
    objects().push_back(object);
  }

  void take_signals(const Section& section) {
    for (const auto& [key, value] : section.values) {
      if (result_.description.signals.size() >= kMostSignals)
        return wrong(value.line, "there are too many signals");
      DescribedSignal signal{.name = key, .line = value.line};
      const Text text = value.text;
      const std::size_t colon = text.find(':'), comma = text.find(',');
      const auto index = number(trimmed(text.substr(0, colon)));
      const auto sub = colon == Text::npos
                           ? std::optional<std::int64_t>(0)
                           : number(trimmed(text.substr(
                                 colon + 1, comma == Text::npos ? comma : comma - colon - 1)));
      if (comma != Text::npos) {
        const Text unit = trimmed(text.substr(comma + 1));
        const auto [end, error] =
            std::from_chars(unit.data(), unit.data() + unit.size(), signal.unit);
        if (error != std::errc() || end != unit.data() + unit.size() ||
            !std::isfinite(signal.unit) || !(std::abs(signal.unit) > 1e-12)) {
          wrong(value.line, quoted(unit) + " is no unit: write a number that is not 0");
          continue;
        }
      }
      if (!index || !sub || *index < 0 || *index > 0xFFFF || *sub < 0 || *sub > 0xFF) {
        wrong(value.line, quoted(text) + " is no object: write 0xINDEX:SUB, UNIT");
        continue;
      }
      signal.index = static_cast<std::uint16_t>(*index);
      signal.sub = static_cast<std::uint8_t>(*sub);
      result_.description.signals.push_back(signal);
    }
  }

  void check(const DescribedSignal& signal) {
    if (result_.description.find(signal.index, signal.sub) == nullptr)
      wrong(signal.line, "signal " + quoted(signal.name) + ": there is no such object in the file");
  }

  std::vector<Section> sections_;
  std::set<unsigned> known_;
  ReadDescription result_;
};

}  // namespace

const DescribedObject* Description::find(std::uint16_t index, std::uint8_t sub) const {
  const auto at = std::ranges::lower_bound(
      objects, std::pair(index, sub), {},
      [](const DescribedObject& object) { return std::pair(object.index, object.sub); });
  return at != objects.end() && at->index == index && at->sub == sub ? &*at : nullptr;
}

const DescribedSignal* Description::signal(std::string_view name) const {
  const std::string wanted = lower(name);
  const auto at = std::ranges::find(signals, wanted, &DescribedSignal::name);
  return at != signals.end() ? &*at : nullptr;
}

ReadDescription read_description(std::string_view text) { return Reader().read(text); }

}  // namespace lss::canopen
