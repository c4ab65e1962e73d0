#include "tools/lss-cli/recording/record_schema.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

#include "daemon/record/limits.h"
#include "tools/lss-cli/show/failure.h"

namespace lss::cli::recording {
namespace {

namespace most = lss::record::most;

class SchemaParser {
 public:
  explicit SchemaParser(std::string_view text) : text_(text) {}

  std::unique_ptr<RecordType> record() {
    if (text_.size() > most::kSchemaBytes)
      refuse(fmt::format("has {} bytes, at most {} are read", text_.size(), most::kSchemaBytes));
    auto type = make('{');
    members(*type, '\0');
    if (at_ != text_.size()) fail();
    return type;
  }

 private:
  [[noreturn]] static void refuse(const std::string& why) {
    throw Failure(ExitCode::failed, "the description of its records " + why,
                  "was the file made by lssd? Take another copy of it");
  }
  [[noreturn]] void fail() const {
    throw Failure(ExitCode::failed,
                  fmt::format("the description of its records cannot be read from \"{}\" on",
                              text_.substr(std::min(at_, text_.size()), 20)),
                  "was the file made by lssd? Take another copy of it");
  }
  char peek() const { return at_ < text_.size() ? text_[at_] : '\0'; }
  void expect(char c) {
    if (peek() != c) fail();
    ++at_;
  }
  static std::unique_ptr<RecordType> make(char what) {
    auto type = std::make_unique<RecordType>();
    type->what = what;
    return type;
  }

  void members(RecordType& type, char end) {
    std::size_t size = 0;
    bool fixed = true;
    while (at_ < text_.size() && peek() != end) {
      const std::size_t colon = text_.find(':', at_);
      if (colon == std::string_view::npos || colon - at_ > most::kName) fail();
      std::string name(text_.substr(at_, colon - at_));
      at_ = colon + 1;
      type.members.push_back({std::move(name), this->type()});
      expect(';');
      const auto& member = type.members.back().type->size;
      fixed = fixed && member.has_value();
      size += member.value_or(0);
      add(type, *type.members.back().type);
    }
    if (fixed) type.size = size;
  }

  // `count` parts of a type.
  static void add(RecordType& type, const RecordType& part, std::size_t count = 1) {
    type.least += count * part.least;
    type.fields += count * part.fields;
    if (type.fields > most::kFields) refuse(fmt::format("has more than {} fields", most::kFields));
  }

  std::unique_ptr<RecordType> type() {
    if (++depth_ > most::kSchemaDepth)
      refuse(fmt::format("is nested deeper than {}", most::kSchemaDepth));
    auto made = make(peek());
    ++at_;
    switch (made->what) {
      case '{':
        members(*made, '}');
        expect('}');
        break;
      case '[': {
        made->count = count();
        expect(']');
        made->members.push_back({"", type()});
        const RecordType& element = *made->members.front().type;
        if (element.size) made->size = *element.size * made->count;
        if (made->text()) {
          made->least = made->count;
        } else {
          add(*made, element, made->count);
        }
        break;
      }
      case '<':
        made->members.push_back({"", type()});
        add(*made, *made->members.front().type);
        made->least = 4;
        expect('>');
        break;
      case '(':
        do {
          made->members.push_back({"", type()});
          add(*made, *made->members.back().type);
        } while (peek() == '|' && ++at_ != 0);
        made->least = 1;
        expect(')');
        break;
      default:
        made->count = count();
        if (!made->number() || !std::has_single_bit(made->count) || made->count > 8 ||
            (made->what == 'f' && made->count < 4) ||
            (std::string_view("bc").find(made->what) != std::string_view::npos && made->count != 1))
          fail();
        made->size = made->least = made->count;
    }
    --depth_;
    return made;
  }

  std::size_t count() {
    constexpr std::size_t kMost = 1'000'000;
    std::size_t n = 0;
    const std::size_t begin = at_;
    while (peek() >= '0' && peek() <= '9' && n < kMost)
      n = n * 10 + static_cast<std::size_t>(text_[at_++] - '0');
    if (at_ == begin || n == 0 || n >= kMost) fail();
    return n;
  }

  std::string_view text_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

std::unique_ptr<RecordType> parse_schema(std::string_view text) {
  return SchemaParser(text).record();
}

}  // namespace lss::cli::recording
