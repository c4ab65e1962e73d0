#include "tools/lss-cli/obc/frame.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "tools/lss-cli/recording/bytes.h"

namespace lss::cli::obc {
namespace {

constexpr std::size_t kCrcDigits = 8;

std::string crc_text(std::string_view text) {
  return fmt::format("{:08x}", recording::crc_of(recording::bytes_of(text)));
}

tl::unexpected<std::string> wrong(std::string why) { return tl::unexpected(std::move(why)); }

bool is_text(std::string_view line) {
  return std::ranges::all_of(line, [](char c) { return c >= ' ' && c <= '~'; });
}

}  // namespace

tl::expected<Request, std::string> read_request(std::string_view line) {
  if (line.size() >= kLongestRequest)
    return wrong(fmt::format("the line is longer than {} bytes", kLongestRequest));
  if (!is_text(line)) return wrong("the line has bytes that are no printable ASCII");
  if (line.size() <= kCrcDigits || line[kCrcDigits] != ' ')
    return wrong("the line does not begin with 8 hexadecimal digits and a blank");
  const std::string_view checked = line.substr(kCrcDigits + 1);
  if (const std::string crc = crc_text(checked); line.substr(0, kCrcDigits) != crc)
    return wrong("the CRC is wrong");
  Request request;
  const char* const end = checked.data() + checked.size();
  const auto [rest, error] = std::from_chars(checked.data(), end, request.sequence);
  if (error != std::errc() || rest == end || *rest != ' ' || checked.front() == '0')
    return wrong("no sequence number from 1 to 4294967295 and a blank after the CRC");
  request.words.assign(rest + 1, end);
  return request;
}

std::string frame(std::uint32_t sequence, std::string_view text) {
  const std::string checked = fmt::format("{} {}", sequence, text);
  return fmt::format("{} {}\n", crc_text(checked), checked);
}

std::vector<Lines::Line> Lines::add(std::string_view bytes) {
  std::vector<Line> complete;
  for (const char c : bytes) {
    if (c == '\n') {
      complete.push_back(std::exchange(line_, {}));
    } else if (line_.text.size() + 1 < kLongestRequest) {
      line_.text.push_back(c);
    } else {
      line_.too_long = true;
    }
  }
  return complete;
}

}  // namespace lss::cli::obc
