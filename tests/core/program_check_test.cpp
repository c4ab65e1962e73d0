// Bits that flip in the program: each is noticed once, in its block; the program of this test is as
// it was loaded.

#include "daemon/runtime/program_check.h"

#include <gtest/gtest.h>

#include <vector>

namespace lss {
namespace {

// Which steps of a round find a difference.
std::vector<std::size_t> differences(ProgramCheck& check) {
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < check.blocks(); ++i) {
    if (!check.step()) all.push_back(i);
  }
  return all;
}

TEST(ProgramCheck, EachFlippedBitIsFoundOnceInItsBlock) {
  std::vector<std::uint8_t> code(2 * ProgramCheck::kBlock + 5, 0xC3), constants(100, 1);
  ProgramCheck check({code, constants});
  ASSERT_EQ(check.blocks(), 4u);
  EXPECT_TRUE(differences(check).empty());
  for (std::size_t at = 0; at < code.size(); at += 4999) {
    code[at] ^= 1u << at % 8;
    EXPECT_EQ(differences(check), std::vector{at / ProgramCheck::kBlock}) << at;
    EXPECT_TRUE(differences(check).empty()) << "reported once";
  }
  code.back() ^= 0x80;
  constants[99] ^= 1;
  EXPECT_EQ(differences(check), (std::vector<std::size_t>{2, 3}));
  EXPECT_EQ(check.last().data(), constants.data());
}

struct Virtual {
  virtual ~Virtual() = default;
};

TEST(ProgramCheck, LooksAtTheCodeConstantsAndVirtualFunctionsOfThisProgram) {
  ProgramCheck check;
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the address sanitizer allows nobody to read between two constants";
#endif
  EXPECT_TRUE(differences(check).empty());
  EXPECT_TRUE(differences(check).empty());
  static const char kConstant[] = "a constant";
  const Virtual base;
  const void* table = *reinterpret_cast<const void* const*>(&base);
  for (const void* looked_at :
       {reinterpret_cast<const void*>(&differences), static_cast<const void*>(kConstant), table}) {
    bool seen = false;
    for (std::size_t i = 0; i < check.blocks(); ++i) {
      check.step();
      const auto* first = check.last().data();
      const auto* byte = static_cast<const std::uint8_t*>(looked_at);
      seen |= byte >= first && byte < first + check.last().size();
    }
    EXPECT_TRUE(seen) << looked_at;
  }
}

}  // namespace
}  // namespace lss
