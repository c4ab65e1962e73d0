// Requests of an OBC that polls, over its socket: split anywhere the lines are the same, and a
// request has one spelling only.

#include <fmt/format.h>

#include <boost/crc.hpp>

#include "tests/fuzz/fuzz.h"
#include "tools/lss-cli/obc/frame.h"

namespace {

using namespace lss::cli::obc;
using lss::fuzz::must;

void request(std::string_view line) {
  const auto request = read_request(line);
  if (!request) return must(!request.error().empty(), "a refusal says why");
  must(frame(request->sequence, request->words) == std::string(line) + '\n',
       "a request has one spelling");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  lss::fuzz::Input in({data, size});
  Lines whole, split;
  while (!in.empty()) {
    const std::string text = lss::fuzz::text_of(in.take(1u + in.byte()));
    const std::vector<Lines::Line> lines = whole.add(text);
    std::vector<Lines::Line> same;
    for (const char& c : text)
      for (Lines::Line& line : split.add({&c, 1})) same.push_back(std::move(line));
    must(std::ranges::equal(lines, same,
                            [](const Lines::Line& a, const Lines::Line& b) {
                              return a.text == b.text && a.too_long == b.too_long;
                            }),
         "lines that are split otherwise are the same");
    for (const Lines::Line& line : lines) {
      must(line.text.size() <= kLongestRequest, "a line has a bounded length");
      if (line.too_long) continue;
      request(line.text);
      boost::crc_32_type crc;  // a right one, which a fuzzer cannot guess
      crc.process_bytes(line.text.data(), line.text.size());
      request(fmt::format("{:08x} {}", crc.checksum(), line.text));
    }
  }
  return 0;
}
