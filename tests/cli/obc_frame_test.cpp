#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tools/lss-cli/obc/frame.h"

namespace lss::cli::obc {
namespace {

using testing::HasSubstr;

std::string line_of(std::uint32_t sequence, std::string_view words) {
  std::string line = frame(sequence, words);
  line.pop_back();
  return line;
}

// As zlib.crc32(b"7 walk forward --speed high") of Python says.
TEST(ObcFrame, IsTheCrc32OfZlibThenTheSequenceThenTheWords) {
  EXPECT_EQ(frame(7, "walk forward --speed high"), "c21dbfc0 7 walk forward --speed high\n");
  const auto request = read_request(line_of(7, "walk forward --speed high"));
  ASSERT_TRUE(request);
  EXPECT_EQ(request->sequence, 7U);
  EXPECT_EQ(request->words, "walk forward --speed high");
}

// Also of those that make a line end, or end the line no more.
TEST(ObcFrame, EverySingleBitErrorOfARequestIsRefused_Env_1) {
  for (const char* words :
       {"estop", "walk forward --speed high --heading 30", "JJJ *: result 12"}) {
    const std::string sent = frame(4294967295, words);
    for (std::size_t bit = 0; bit < sent.size() * 8; ++bit) {
      std::string received = sent;
      received[bit / 8] = static_cast<char>(received[bit / 8] ^ (1 << (bit % 8)));
      Lines lines;
      for (const std::string& bytes : {received, frame(1, "heartbeat")}) {
        for (const Lines::Line& line : lines.add(bytes)) {
          const auto request = read_request(line.text);
          if (request) {
            EXPECT_EQ(request->words, "heartbeat") << "bit " << bit << ": " << line.text;
          }
        }
      }
    }
  }
}

TEST(ObcFrame, BurstsOfThirtyTwoBitsInARequestAreRefused_Env_1) {
  const std::string sent = line_of(12, "walk forward --speed high");
  for (std::size_t at = 0; at + 4 <= sent.size(); ++at) {
    for (std::uint32_t pattern = 1; pattern < 0x800; pattern += 2) {
      std::string received = sent;
      for (std::size_t i = 0; i < 4; ++i)
        received[at + i] = static_cast<char>(received[at + i] ^
                                             static_cast<int>(pattern * 0x9E3779B1U >> (8 * i)));
      EXPECT_FALSE(read_request(received)) << received;
    }
  }
}

TEST(ObcFrame, EachRequestHasOneSpelling) {
  // With the CRCs that zlib.crc32 of Python gives.
  EXPECT_TRUE(read_request("293a71a9 1 status"));
  EXPECT_FALSE(read_request("293A71A9 1 status")) << "digits are lower-case";
  EXPECT_FALSE(read_request("84207abc 01 status")) << "no zero in front";
  EXPECT_FALSE(read_request("aab5a610 +1 status")) << "no sign";
  EXPECT_FALSE(read_request("28e038cd  1 status")) << "no second blank";
  EXPECT_FALSE(read_request("83dcefb7 1")) << "no words";
  EXPECT_FALSE(read_request("7b00651c status")) << "no sequence";
  EXPECT_FALSE(read_request("2fe2c98d 4294967296 status")) << "beyond 32 bits";
  EXPECT_FALSE(read_request(line_of(0, "status"))) << "of replies to what is no request";
  EXPECT_FALSE(read_request(line_of(1, "stat\tus")));
  EXPECT_FALSE(read_request(line_of(1, "status\r")));
  EXPECT_FALSE(read_request(""));
}

TEST(ObcFrame, LinesAreFoundInPartsOfAnySizeAndBounded) {
  const std::string stream = frame(1, "status") + frame(2, "data");
  Lines lines;
  std::vector<std::string> texts;
  for (const char c : stream) {
    for (const Lines::Line& line : lines.add({&c, 1})) texts.push_back(line.text);
  }
  EXPECT_THAT(texts, testing::ElementsAre(line_of(1, "status"), line_of(2, "data")));

  const auto longest = lines.add(std::string(kLongestRequest - 1, 'x') + "\n");
  ASSERT_EQ(longest.size(), 1U);
  EXPECT_FALSE(longest.front().too_long);
  const auto too_long = lines.add(std::string(1'000'000, 'x') + "\n" + frame(3, "stop"));
  ASSERT_EQ(too_long.size(), 2U);
  EXPECT_TRUE(too_long.front().too_long);
  EXPECT_LT(too_long.front().text.size(), kLongestRequest);
  EXPECT_EQ(read_request(too_long.back().text)->words, "stop");
}

}  // namespace
}  // namespace lss::cli::obc
