#pragma once

// Requests and replies of an OBC that polls: lines "CRC SEQUENCE TEXT\n" in printable ASCII. CRC is
// the CRC-32 of zlib (ISO-HDLC), 8 lower-case hexadecimal digits, over all between the first blank
// and the line end. One spelling for each value, so that no changed bit gives the same request.
// Pure functions.

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

namespace lss::cli::obc {

inline constexpr std::size_t kLongestRequest = 512;  // bytes, with the line end

struct Request {
  std::uint32_t sequence = 0;  // from 1
  std::string words;
};

// The error says what is wrong with the line, which is without its line end.
tl::expected<Request, std::string> read_request(std::string_view line);

// With its line end. Sequence 0: the reply to what is no request.
std::string frame(std::uint32_t sequence, std::string_view text);

// Divides a stream of bytes into lines, within a bounded memory.
class Lines {
 public:
  struct Line {
    std::string text;  // without the line end
    bool too_long = false;
  };
  // The lines that these bytes complete. Of one that is too long only the beginning is stored.
  std::vector<Line> add(std::string_view bytes);

 private:
  Line line_;
};

}  // namespace lss::cli::obc
