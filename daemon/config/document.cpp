#include "daemon/config/document.h"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <system_error>

namespace lss::config {
namespace {

// Position after the text that begins with the quote at `at`.
std::size_t end_of_text(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const bool lines = text.substr(at, 3) == std::string(3, quote);
  const std::string_view close = text.substr(at, lines ? 3 : 1);
  for (at += close.size(); at < text.size(); ++at) {
    if (text[at] == '\\' && quote == '"') {
      ++at;
    } else if (text[at] == '\n' && !lines) {
      return at;
    } else if (text.substr(at, close.size()) == close) {
      at += close.size();
      // A multi-line text may end with two more quotes of its own.
      for (int i = 0; lines && i < 2 && at < text.size() && text[at] == quote; ++i) ++at;
      return at;
    }
  }
  return text.size();
}

// At least the number of parts of the longest dotted key.
std::size_t longest_key(std::string_view text) {
  std::size_t longest = 0, parts = 1;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '"' || c == '\'') {
      at = end_of_text(text, at);
      continue;
    }
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '.') longest = std::max(longest, ++parts);
    if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) parts = 1;
    ++at;
  }
  return longest;
}

}  // namespace

std::optional<std::string> too_much(std::string_view text) {
  if (text.size() > most::kBytes)
    return fmt::format("is larger than a configuration may be, {} bytes", most::kBytes);
  if (longest_key(text) > most::kKeyParts)
    return fmt::format("has a key of more than {} parts", most::kKeyParts);
  return std::nullopt;
}

std::string one_line(std::string error) {
  std::ranges::replace_if(
      error, [](unsigned char c) { return c < ' ' || c == 0x7F; }, ' ');
  return error;
}

tl::expected<std::string, std::string> read_document(const std::filesystem::path& file) {
  std::error_code trouble;
  if (!std::filesystem::is_regular_file(file, trouble))
    return tl::unexpected<std::string>("no such file");
  std::ifstream stream(file, std::ios::binary);
  std::string text(most::kBytes + 1, '\0');  // one byte more, to find a file that is too large
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad() || !stream.is_open()) return tl::unexpected<std::string>("cannot be read");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (auto why = too_much(text)) return tl::unexpected(*std::move(why));
  return text;
}

}  // namespace lss::config
